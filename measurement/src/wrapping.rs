//! Selective wrapping: which part of each source's energy each configuration of the test transmits.

use std::f64::consts::LN_10;

use serde::{Deserialize, Serialize};

/// A configuration of the test, in the order in which it is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Configuration {
    /// Nothing is wrapped: all sources.
    Total,
    /// Everything is wrapped: the sound that the wraps transmit.
    Residual,
    /// Only the exhaust is bare.
    Exhaust,
    /// Only the body is bare.
    Body,
    /// Only the workpiece is bare, with the worktable if there is one.
    Workpiece,
}

/// A source as the protocol of the test separates it, in the order of all tables of this module.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// The workpiece with its support.
    Workpiece,
    /// The exhaust.
    Exhaust,
    /// The tool's body.
    Body,
}

impl Role {
    /// All, in order.
    pub const ALL: [Self; 3] = [Self::Workpiece, Self::Exhaust, Self::Body];

    /// Its name in manifests and results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Workpiece => "workpiece",
            Self::Exhaust => "exhaust",
            Self::Body => "body",
        }
    }
}

impl Configuration {
    /// All, in order.
    pub const ALL: [Self; 5] = [Self::Total, Self::Residual, Self::Exhaust, Self::Body, Self::Workpiece];

    /// The configuration with a number from 1 to 5.
    pub fn from_number(number: usize) -> Option<Self> {
        Self::ALL.get(number.checked_sub(1)?).copied()
    }

    /// Its number, from 1.
    pub fn number(self) -> usize {
        self as usize + 1
    }

    /// The measured quantity: a source, `total` or `residual`.
    pub fn measures(self) -> &'static str {
        match self {
            Self::Total => "total",
            Self::Residual => "residual",
            Self::Exhaust | Self::Body | Self::Workpiece => self.source().map_or("", Role::name),
        }
    }

    /// The source that it measures after subtraction of the residual; `None` for total and residual.
    pub fn source(self) -> Option<Role> {
        match self {
            Self::Total | Self::Residual => None,
            Self::Exhaust => Some(Role::Exhaust),
            Self::Body => Some(Role::Body),
            Self::Workpiece => Some(Role::Workpiece),
        }
    }
}

/// Insertion loss of a wrap or muffler \[dB\]: linear in lg f between two frequencies \[Hz\], constant outside.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct InsertionLoss {
    /// Lower frequency \[Hz\], and loss below it \[dB\].
    pub low: (f64, f64),
    /// Upper frequency \[Hz\], and loss above it \[dB\].
    pub high: (f64, f64),
}

impl InsertionLoss {
    /// The loss at a frequency \[dB\].
    pub fn db(&self, hz: f64) -> f64 {
        let ((f0, d0), (f1, d1)) = (self.low, self.high);
        let share = ((hz / f0).ln() / (f1 / f0).ln()).clamp(0.0, 1.0);
        d0 + share * (d1 - d0)
    }

    /// Fraction of the energy transmitted, 10^(-D/10).
    pub fn transmission(&self, hz: f64) -> f64 {
        decibels_as_share(self.db(hz))
    }
}

/// Fraction of the energy that remains after a loss \[dB\].
pub fn decibels_as_share(loss: f64) -> f64 {
    (-0.1 * LN_10 * loss).exp()
}

/// The wraps of a test.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Wrapping {
    /// Foam and barrier on the workpiece and its support.
    pub workpiece: InsertionLoss,
    /// Foam and barrier on the tool's body.
    pub body: InsertionLoss,
    /// Muffler on the exhaust.
    pub muffler: InsertionLoss,
    /// Fraction of the exhaust's energy that passes the body's wrap, which fits tightly around the exhaust.
    pub exhaust_mask: f64,
    /// Fraction of the workpiece's energy that passes the body's wrap, which extends down over the nose.
    pub workpiece_mask: f64,
}

/// Fractions of energy transmitted at one frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transmissions {
    /// Through the workpiece's wrap, t_w.
    pub workpiece: f64,
    /// Through the body's wrap, t_b.
    pub body: f64,
    /// Through the muffler, t_m.
    pub muffler: f64,
    /// Exhaust noise past the body's wrap, m_x.
    pub exhaust_mask: f64,
    /// Workpiece noise past the body's wrap, m_w.
    pub workpiece_mask: f64,
}

impl Wrapping {
    /// Wraps that transmit nothing and do not mask other sources.
    pub fn perfect() -> Self {
        let all = InsertionLoss {
            low: (100.0, f64::INFINITY),
            high: (1000.0, f64::INFINITY),
        };
        Self {
            workpiece: all,
            body: all,
            muffler: all,
            exhaust_mask: 1.0,
            workpiece_mask: 1.0,
        }
    }

    /// The fractions transmitted at a frequency.
    pub fn at(&self, hz: f64) -> Transmissions {
        let through = |loss: &InsertionLoss| {
            // Two infinite losses have no finite difference.
            if loss.low.1.is_infinite() {
                0.0
            } else {
                loss.transmission(hz)
            }
        };
        Transmissions {
            workpiece: through(&self.workpiece),
            body: through(&self.body),
            muffler: through(&self.muffler),
            exhaust_mask: self.exhaust_mask,
            workpiece_mask: self.workpiece_mask,
        }
    }
}

impl Transmissions {
    /// Through the wrap or muffler of a source.
    pub fn of_source(&self, source: Role) -> f64 {
        match source {
            Role::Workpiece => self.workpiece,
            Role::Exhaust => self.muffler,
            Role::Body => self.body,
        }
    }

    /// Fraction T_cs of the energy of each source (workpiece, exhaust, body) in each configuration.
    pub fn matrix(&self) -> [[f64; 3]; 5] {
        let (w, b, m) = (self.workpiece, self.body, self.muffler);
        [
            [1.0, 1.0, 1.0],
            [w, m, b],
            [w, self.exhaust_mask, b],
            [w, m, 1.0],
            [self.workpiece_mask, m, b],
        ]
    }
}

/// Energies of the configurations, E_c = sum_s T_cs E_s + B, from those of the sources and the background, all in the
/// same unit.
pub fn configurations(shares: &[[f64; 3]; 5], sources: &[f64; 3], background: f64) -> [f64; 5] {
    shares.map(|row| row.iter().zip(sources).map(|(t, e)| t * e).sum::<f64>() + background)
}

/// Nonnegative least-squares energies of the sources, from those of the configurations.
///
/// ```text
/// min_E sum_c (sum_s T_cs E_s + B - E_c)^2,   E_s >= 0
/// ```
///
/// With three sources, all eight sets of positive sources are tried; since the problem is convex, the minimum is the
/// smallest sum of squares among the solutions without negative values.
pub fn sources(shares: &[[f64; 3]; 5], energies: &[f64; 5], background: f64) -> [f64; 3] {
    let (mut best, mut least) = ([0.0; 3], f64::INFINITY);
    for set in 0..8_u32 {
        let present = [0, 1, 2].map(|s| set >> s & 1 == 1);
        // Absent sources get the equation E_s = 0.
        let mut normal = nalgebra::Matrix3::<f64>::identity();
        let mut right = nalgebra::Vector3::zeros();
        for i in (0..3).filter(|i| present[*i]) {
            right[i] = (0..5).map(|c| shares[c][i] * (energies[c] - background)).sum();
            for j in (0..3).filter(|j| present[*j]) {
                normal[(i, j)] = (0..5).map(|c| shares[c][i] * shares[c][j]).sum();
            }
        }
        let Some(found) = normal.lu().solve(&right) else {
            continue;
        };
        let found: [f64; 3] = found.into();
        if found.iter().any(|e| *e < 0.0) {
            continue;
        }
        let misfit = configurations(shares, &found, background)
            .iter()
            .zip(energies)
            .map(|(made, measured)| (made - measured).powi(2))
            .sum();
        if misfit < least {
            (best, least) = (found, misfit);
        }
    }
    best
}

/// The sources' energies as evaluated from those of the configurations, in the same unit. A value may be negative.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Separated {
    /// The workpiece bare, minus the residual: X_5.
    pub workpiece: f64,
    /// The exhaust bare, minus the residual: X_3.
    pub exhaust: f64,
    /// The body bare, minus the residual: X_4.
    pub body: f64,
    /// Upper bound of the workpiece: the total minus exhaust and body, U = E_1 - X_3 - X_4.
    pub bound: f64,
    /// The total divided by the sum of the three sources, E_1/(X_3 + X_4 + X_5).
    pub closure: f64,
}

/// The sources from the energies of the configurations.
pub fn separated(energies: &[f64; 5]) -> Separated {
    let [total, residual, ..] = *energies;
    let [exhaust, body, workpiece] = [2, 3, 4].map(|c: usize| energies[c] - residual);
    Separated {
        workpiece,
        exhaust,
        body,
        bound: total - exhaust - body,
        closure: total / (exhaust + body + workpiece),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn energy(level: f64) -> f64 {
        10f64.powf(0.1 * level)
    }

    fn level(energy: f64) -> f64 {
        10.0 * energy.log10()
    }

    fn close(found: f64, expected: f64, tolerance: f64) {
        assert!((found - expected).abs() < tolerance, "{found} for {expected}");
    }

    /// A test whose numbers were computed by hand.
    const SHARES: Transmissions = Transmissions {
        workpiece: 0.03,
        muffler: 0.02,
        body: 0.05,
        workpiece_mask: 0.4,
        exhaust_mask: 0.6,
    };

    #[test]
    fn configurations_hold_what_the_wraps_let_through() {
        let found = configurations(&SHARES.matrix(), &[100.0, 98.0, 94.0].map(energy), energy(70.0));
        for (found, expected) in found.into_iter().zip([102.749, 87.496, 96.255, 94.695, 96.296]) {
            close(level(found), expected, 5e-4);
        }
    }

    #[test]
    fn subtraction_gives_sources_bound_and_closure() {
        let found = separated(&configurations(
            &SHARES.matrix(),
            &[100.0, 98.0, 94.0].map(energy),
            energy(70.0),
        ));
        close(level(found.exhaust), 95.634, 5e-4);
        close(level(found.body), 93.777, 5e-4);
        close(level(found.workpiece), 95.682, 5e-4);
        close(level(found.bound), 101.067, 5e-4);
        close(level(found.closure), 2.861, 5e-4);
    }

    #[test]
    fn least_squares_return_the_sources() {
        let sources_were = [100.0, 98.0, 94.0].map(energy);
        let (shares, background) = (SHARES.matrix(), energy(70.0));
        let found = sources(&shares, &configurations(&shares, &sources_were, background), background);
        for (found, was) in found.into_iter().zip(sources_were) {
            close(found / was, 1.0, 1e-12);
        }
    }

    #[test]
    fn least_squares_give_no_negative_energy() {
        let shares = SHARES.matrix();
        let mut energies = configurations(&shares, &[1.0, 0.5, 0.0], 0.0);
        energies[3] *= 0.5;
        let found = sources(&shares, &energies, 0.0);
        assert!(found.iter().all(|e| *e >= 0.0) && found[2] == 0.0, "{found:?}");
    }

    #[test]
    fn wraps_without_effect_leave_no_differences_and_the_total_as_bound() {
        let open = Transmissions {
            workpiece: 1.0,
            body: 1.0,
            muffler: 1.0,
            exhaust_mask: 1.0,
            workpiece_mask: 1.0,
        };
        let energies = configurations(&open.matrix(), &[3.0, 2.0, 1.0], 0.5);
        let found = separated(&energies);
        assert_eq!([found.workpiece, found.exhaust, found.body], [0.0; 3]);
        assert_eq!(found.bound, energies[0]);
    }

    #[test]
    fn perfect_wraps_return_the_sources() {
        let energies = configurations(&Wrapping::perfect().at(1000.0).matrix(), &[3.0, 2.0, 1.0], 0.0);
        let found = separated(&energies);
        assert_eq!([found.workpiece, found.exhaust, found.body], [3.0, 2.0, 1.0]);
        assert_eq!((found.bound, found.closure), (3.0, 1.0));
    }

    /// Wraps of 10, 20 and 30 dB that do not mask other sources: each source is too low, and the closure too high, by
    /// 10 lg(1/(1 - 10^(-D/10))).
    #[test]
    fn leaking_wraps_lower_the_sources_by_what_they_leak() {
        for (loss, expected) in [(10.0, 0.458), (20.0, 0.0436), (30.0, 0.0043)] {
            let share = decibels_as_share(loss);
            let wraps = Transmissions {
                workpiece: share,
                body: share,
                muffler: share,
                exhaust_mask: 1.0,
                workpiece_mask: 1.0,
            };
            let found = separated(&configurations(&wraps.matrix(), &[3.0, 2.0, 1.0], 0.0));
            close(-level(found.exhaust / 2.0), expected, 5e-4);
            close(level(found.closure), expected, 5e-4);
        }
    }

    #[test]
    fn a_masked_exhaust_raises_the_bound_of_the_workpiece() {
        for (workpiece, exhaust, hidden, expected) in [(100.0, 100.0, 0.5, 1.761), (95.0, 100.5, 0.6, 4.954)] {
            let wraps = Transmissions {
                workpiece: 0.0,
                body: 0.0,
                muffler: 0.0,
                exhaust_mask: 1.0 - hidden,
                workpiece_mask: 1.0,
            };
            let found = separated(&configurations(
                &wraps.matrix(),
                &[workpiece, exhaust, 90.0].map(energy),
                0.0,
            ));
            close(level(found.bound) - workpiece, expected, 5e-4);
        }
    }

    #[test]
    fn insertion_loss_is_linear_in_the_logarithm_of_frequency() {
        let loss = InsertionLoss {
            low: (125.0, 10.0),
            high: (4000.0, 30.0),
        };
        close(loss.db(125.0 * 32f64.sqrt()), 20.0, 1e-12);
        assert_eq!((loss.db(50.0), loss.db(8000.0)), (10.0, 30.0));
    }
}
