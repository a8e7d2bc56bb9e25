//! Converts a recorded drive to points: zero offset, start, binning, speed.
//!
//! The source publishes only the fit through repeats (Nili Ahmadabadi 2016, ch. 2). It gives no sampling rate, filter
//! or definition of the start, so the steps here are our own. At high speed the cell measures less force than acts on
//! the wood, because it accelerates with the projectile: F_r = F_cell M_1/(M - m_f) with M_1 = M + M_n, where m_f is
//! the mass ahead of the cell.

use thiserror::Error;

use super::drive::{Conditions, Driving, Point};

/// Width of a bin as a fraction of the nail's length; all bins of a drive have the same weight.
pub(super) const BIN: f64 = 0.01;
/// Length of the tip as a fraction of the nail's length; the start is sought within it.
const TIP: f64 = 0.09;
/// Fractions of the largest force between which a line is fitted to find the start.
const START: [f64; 2] = [0.02, 0.10];
/// Speed of longitudinal waves along a steel nail, sqrt(E/rho) with E = 205 GPa and rho = 7850 kg/m3 \[m/s\].
const WAVE_SPEED: f64 = 5110.0;
/// Number of wave transits after which the nail counts as rigid. This is a choice: four round trips. With fewer, the
/// first bins contain the ringing of the impact.
const WAVE_PASSES: f64 = 8.0;
/// Window of the moving average that shows whether the depth decreases \[samples\].
const SLIDING: usize = 5;
/// Residual of the momentum balance above which a drive is flagged, as a fraction of the momentum.
const MOMENTUM: f64 = 0.02;

/// A drive as it was recorded.
#[derive(Debug, Clone, Default)]
pub struct Trace {
    /// Time \[s\]; may be empty for a drive at constant speed.
    pub time: Vec<f64>,
    /// Depth of the tip \[m\].
    pub depth: Vec<f64>,
    /// Force measured by the cell \[N\].
    pub force: Vec<f64>,
}

/// How to determine where the tip meets the wood.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Start {
    /// For drives at constant speed: where a line fitted to the tip's force between 2 and 10 % of the largest force
    /// crosses zero. For drives by a projectile: depth 0 of the recording.
    Automatic,
    /// Where the force first exceeds this value \[N\].
    Force(f64),
    /// Depth 0 of the recording.
    Recorded,
}

/// Settings for cleaning a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cleaning {
    /// How to determine where the tip meets the wood.
    pub start: Start,
    /// N, number of samples in the slope fit for the speed after an impact; odd.
    pub slope_samples: usize,
    /// Acceleration of gravity along the drive \[m/s2\].
    pub gravity: f64,
}

impl Default for Cleaning {
    fn default() -> Self {
        Self {
            start: Start::Automatic,
            slope_samples: 21,
            gravity: 9.81,
        }
    }
}

/// The masses of a drive by a projectile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Masses {
    /// M_n, mass of the nail \[kg\].
    pub nail: f64,
    /// m_f, mass of the projectile ahead of the cell's plane \[kg\].
    pub ahead: f64,
}

/// Points of a drive, with flags for the user.
#[derive(Debug, Clone, PartialEq)]
pub struct Cleaned {
    /// Means in bins of 1 % of the nail's length.
    pub points: Vec<Point>,
    /// sigma_v, standard error of the speed \[m/s\]; only after an impact.
    pub speed_error: Option<f64>,
    /// Points for the user to check.
    pub flags: Vec<Flag>,
}

/// Something in a drive that the user should check.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum Flag {
    /// The force rises too fast for a fit of the start.
    #[error("the force rises too fast for a line on the tip: the drive begins at 2 % of its largest force")]
    FastRise,
    /// Forces below zero, but within their noise.
    #[error("{bins} bins have a mean force below zero by less than its noise, taken as 0")]
    Clipped {
        /// Number of bins.
        bins: usize,
    },
    /// Samples beyond the range of the law, with the head in the wood.
    #[error("{samples} samples deeper than the nail's length are left out: the head is in the wood")]
    HeadInWood {
        /// Number of samples.
        samples: usize,
    },
    /// Force and motion are inconsistent.
    #[error(
        "the forces take {impulse:.4} N s and the motion loses {loss:.4} N s ({:+.1} % of the momentum): check \
         masses, speed of \
         impact and cell",
        100.0 * share
    )]
    Momentum {
        /// Impulse of the forces \[N s\].
        impulse: f64,
        /// Momentum lost by the motion \[N s\].
        loss: f64,
        /// Their difference as a fraction of the momentum after the impact.
        share: f64,
    },
}

/// Largest time \[s\], depth \[m\] and force \[N\] of a recording: a week of creep, the longest pile, and a force that
/// crushes its shank.
const LIMITS: [(&str, f64, &str); 3] = [("time", 1e6, "s"), ("depth", 10.0, "m"), ("force", 1e7, "N")];

/// Why a recording cannot be used.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CleanError {
    /// Too few samples.
    #[error("there are {count} samples between the surface and the deepest point, at least {least} are needed")]
    TooFew {
        /// Samples found.
        count: usize,
        /// Samples needed.
        least: usize,
    },
    /// A number that is not finite.
    #[error("a number is not finite")]
    NotFinite {
        /// Index of the sample, from 0.
        sample: usize,
    },
    /// A number that is implausibly large.
    #[error("the {quantity} is {value:?} {unit}; at most {limit:?} {unit} is expected")]
    TooLarge {
        /// Index of the sample, from 0.
        sample: usize,
        /// Name of the quantity.
        quantity: &'static str,
        /// Its value.
        value: f64,
        /// The largest value accepted.
        limit: f64,
        /// Unit of both.
        unit: &'static str,
    },
    /// The force never rises.
    #[error("the force is nowhere above 0 N")]
    NoForce,
    /// The force never reaches the threshold of the start.
    #[error("the force does not reach {threshold} N, the start asked for")]
    NoStart {
        /// The threshold \[N\].
        threshold: f64,
    },
    /// Times are not equally spaced.
    #[error("the time does not rise by equal steps: {step} s here, {expected} s on average")]
    Time {
        /// Index of the sample, from 0.
        sample: usize,
        /// Its step \[s\].
        step: f64,
        /// The mean step \[s\].
        expected: f64,
    },
    /// The times are missing, but the speed must be derived from them.
    #[error("a drive by a projectile needs the column time_s")]
    NoTime,
    /// The depth decreases before the deepest point.
    #[error("the depth goes back by {:.3} mm, more than three times its noise of {:.3} mm", 1e3 * back, 1e3 * noise)]
    GoesBack {
        /// Index of the sample, from 0.
        sample: usize,
        /// Distance by which it decreases \[m\].
        back: f64,
        /// sigma_y \[m\].
        noise: f64,
    },
    /// A force below zero by more than its noise.
    #[error(
        "the mean force is {force:.1} N at a depth of {:.2} mm, below zero by more than three standard errors of \
         {error:.1} N",
        1e3 * depth
    )]
    Negative {
        /// Index of the sample, from 0.
        sample: usize,
        /// The depth \[m\].
        depth: f64,
        /// Mean force \[N\].
        force: f64,
        /// Its standard error \[N\].
        error: f64,
    },
    /// The mass ahead of the cell is not less than the projectile's.
    #[error("the mass ahead of the cell, {ahead} kg, is not less than the projectile's, {mass} kg")]
    CellMass {
        /// m_f \[kg\].
        ahead: f64,
        /// M \[kg\].
        mass: f64,
    },
}

impl CleanError {
    /// The sample concerned, from 0.
    pub fn sample(&self) -> Option<usize> {
        match self {
            Self::NotFinite { sample }
            | Self::TooLarge { sample, .. }
            | Self::Time { sample, .. }
            | Self::GoesBack { sample, .. }
            | Self::Negative { sample, .. } => Some(*sample),
            _ => None,
        }
    }

    /// How to fix it.
    pub fn remedy(&self) -> &'static str {
        match self {
            Self::TooFew { .. } => "record at a higher rate, or check that depths are in m and rise into the wood",
            Self::NotFinite { .. } => "remove the sample, or the drive",
            Self::TooLarge { .. } => "check the units of the columns, or remove the sample",
            Self::NoForce => "give the force in N, positive against the nail",
            Self::NoStart { .. } => "lower --start, or check that forces are in N",
            Self::Time { .. } => "give samples at equal intervals, times in s",
            Self::NoTime => "add the column time_s to the file",
            Self::GoesBack { .. } => "one file holds one drive: cut what follows it, or smooth a faulty gauge",
            Self::Negative { .. } => "check the zero of the load cell, or leave the drive out",
            Self::CellMass { .. } => "correct mass_ahead_of_cell_kg or projectile_mass_kg",
        }
    }
}

impl Trace {
    /// Extracts the points of the drive; `masses` are needed after an impact.
    ///
    /// # Errors
    /// [`CleanError`], with the sample concerned.
    pub fn clean(&self, conditions: &Conditions, masses: &Masses, how: &Cleaning) -> Result<Cleaned, CleanError> {
        let n = self.depth.len().min(self.force.len());
        for sample in 0..n {
            let time = self.time.get(sample).copied().unwrap_or(0.0);
            if !(self.depth[sample].is_finite() && self.force[sample].is_finite() && time.is_finite()) {
                return Err(CleanError::NotFinite { sample });
            }
            for ((quantity, limit, unit), value) in
                LIMITS.into_iter().zip([time, self.depth[sample], self.force[sample]])
            {
                if value.abs() > limit {
                    return Err(CleanError::TooLarge {
                        sample,
                        quantity,
                        value,
                        limit,
                        unit,
                    });
                }
            }
        }
        if n < SLIDING {
            return Err(CleanError::TooFew {
                count: n,
                least: SLIDING,
            });
        }
        let step = self.time_step()?;
        let deepest = (0..n).fold(0, |best, k| if self.depth[k] > self.depth[best] { k } else { best });
        let peak = self.force[..=deepest].iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let contact = (0..=deepest).find(|&k| self.force[k] > START[0] * peak).unwrap_or(0);
        // Samples before contact give the zero offset and the noise of the cell.
        let before = &self.force[..contact];
        let zero = if before.is_empty() { 0.0 } else { mean(before) };
        let noise = if before.len() < SLIDING {
            None
        } else {
            Some(deviation(before, zero))
        };
        let force: Vec<f64> = self.force.iter().map(|force| force - zero).collect();
        let peak = peak - zero;
        if peak.is_nan() || peak <= 0.0 {
            return Err(CleanError::NoForce);
        }
        let mut flags = Vec::new();
        let surface = self.surface(conditions, how.start, &force[..=deepest], peak, &mut flags)?;
        let first = (0..=deepest).find(|&k| self.depth[k] > surface).unwrap_or(deepest);
        let count = deepest + 1 - first;
        if count < SLIDING {
            return Err(CleanError::TooFew { count, least: SLIDING });
        }
        self.refuse_return(first, deepest)?;
        let samples = match conditions.driving {
            Driving::Constant { speed } => (first..=deepest).map(|k| (k, force[k], speed)).collect::<Vec<_>>(),
            Driving::Impact { mass, speed } => {
                let Some(step) = step else {
                    return Err(CleanError::NoTime);
                };
                let drive = Impact {
                    mass,
                    speed,
                    step,
                    masses,
                    gravity: how.gravity,
                };
                drive.samples(
                    self,
                    &force,
                    (first, deepest),
                    how.slope_samples,
                    conditions,
                    &mut flags,
                )?
            }
        };
        let speed_error = match (conditions.driving, step) {
            (Driving::Impact { .. }, Some(step)) => {
                let n = how.slope_samples as f64;
                Some(self.depth_noise(first, deepest) / step * (12.0 / (n * n * n - n)).sqrt())
            }
            _ => None,
        };
        let points = self.bins(&samples, surface, conditions, noise, &mut flags)?;
        Ok(Cleaned {
            points,
            speed_error,
            flags,
        })
    }

    /// The sampling interval; none without times.
    fn time_step(&self) -> Result<Option<f64>, CleanError> {
        let n = self.time.len();
        if n < 2 {
            return Ok(None);
        }
        let expected = (self.time[n - 1] - self.time[0]) / (n - 1) as f64;
        for k in 1..n {
            let step = self.time[k] - self.time[k - 1];
            if !(step > 0.0 && (step - expected).abs() < 0.5 * expected) {
                return Err(CleanError::Time {
                    sample: k,
                    step,
                    expected,
                });
            }
        }
        Ok(Some(expected))
    }

    /// Recorded depth at which the tip meets the wood.
    fn surface(
        &self,
        conditions: &Conditions,
        start: Start,
        force: &[f64],
        peak: f64,
        flags: &mut Vec<Flag>,
    ) -> Result<f64, CleanError> {
        match start {
            Start::Recorded => return Ok(0.0),
            Start::Automatic if !conditions.driving.is_constant() => return Ok(0.0),
            Start::Automatic => {}
            Start::Force(threshold) => {
                let Some(k) = force.iter().position(|force| *force > threshold) else {
                    return Err(CleanError::NoStart { threshold });
                };
                if k == 0 {
                    return Ok(self.depth[0]);
                }
                let part = (threshold - force[k - 1]) / (force[k] - force[k - 1]);
                return Ok(self.depth[k - 1] + part * (self.depth[k] - self.depth[k - 1]));
            }
        }
        let [low, high] = START.map(|part| part * peak);
        let contact = force.iter().position(|force| *force > low).unwrap_or(0);
        let end = (contact..force.len())
            .find(|&k| force[k] > high)
            .unwrap_or(force.len() - 1);
        let on_tip = (contact..end).filter(|&k| self.depth[k] - self.depth[contact] < TIP * conditions.specimen.length);
        let points: Vec<(f64, f64)> = on_tip.map(|k| (self.depth[k], force[k])).collect();
        if let Some((intercept, slope)) = line(&points)
            && slope > 0.0
        {
            let surface = -intercept / slope;
            let least = self.depth[contact] - TIP * conditions.specimen.length;
            if surface <= self.depth[contact] && surface >= least {
                return Ok(surface);
            }
        }
        flags.push(Flag::FastRise);
        Ok(self.depth[contact])
    }

    /// sigma_y of the depth, from its second differences: sqrt(mean d2^2/6).
    fn depth_noise(&self, first: usize, last: usize) -> f64 {
        let mut squares: Vec<f64> = self.depth[first..=last]
            .windows(3)
            .map(|w| (w[2] - 2.0 * w[1] + w[0]).powi(2))
            .collect();
        // The median of the squares of normal numbers is 0.4549 times their mean; using it suppresses outliers.
        squares.sort_by(f64::total_cmp);
        squares
            .get(squares.len() / 2)
            .map_or(0.0, |median| (median / 0.454_9 / 6.0).sqrt())
    }

    fn refuse_return(&self, first: usize, last: usize) -> Result<(), CleanError> {
        let noise = self.depth_noise(first, last);
        let allowed = (3.0 * noise).max(1e-6);
        let mut farthest = f64::NEG_INFINITY;
        for k in first..(last + 2).saturating_sub(SLIDING) {
            let now = mean(&self.depth[k..k + SLIDING]);
            if farthest - now > allowed {
                return Err(CleanError::GoesBack {
                    sample: k + SLIDING / 2,
                    back: farthest - now,
                    noise,
                });
            }
            farthest = farthest.max(now);
        }
        Ok(())
    }

    /// Averages (sample, force, speed) in bins of depth.
    fn bins(
        &self,
        samples: &[(usize, f64, f64)],
        surface: f64,
        conditions: &Conditions,
        noise: Option<f64>,
        flags: &mut Vec<Flag>,
    ) -> Result<Vec<Point>, CleanError> {
        let length = conditions.specimen.length;
        let bin = |k: usize| ((self.depth[k] - surface) / (BIN * length)).floor();
        let last = (1.0 / BIN).round();
        let mut points = Vec::new();
        let (mut beyond, mut clipped) = (0, 0);
        let mut sorted: Vec<_> = samples.iter().filter(|(k, ..)| bin(*k) >= 0.0).collect();
        // Noise may put neighbouring samples out of order.
        sorted.sort_by(|a, b| self.depth[a.0].total_cmp(&self.depth[b.0]));
        for group in sorted.chunk_by(|a, b| bin(a.0) == bin(b.0)) {
            if bin(group[0].0) > last || (self.depth[group[0].0] - surface) > length * (1.0 + 1e-6) {
                beyond += group.len();
                continue;
            }
            let n = group.len() as f64;
            let of = |value: fn(&(usize, f64, f64)) -> f64| group.iter().map(|sample| value(sample)).sum::<f64>() / n;
            let force = of(|sample| sample.1);
            let depth = group.iter().map(|sample| self.depth[sample.0] - surface).sum::<f64>() / n;
            if force < 0.0 {
                let spread = (group.iter().map(|s| (s.1 - force).powi(2)).sum::<f64>() / n).sqrt();
                let error = noise.unwrap_or(spread) / n.sqrt();
                if force < -3.0 * error {
                    let sample = group[0].0;
                    return Err(CleanError::Negative {
                        sample,
                        depth,
                        force,
                        error,
                    });
                }
                clipped += 1;
            }
            points.push(Point {
                depth,
                speed: of(|sample| sample.2),
                root: conditions.root(force),
            });
        }
        if clipped > 0 {
            flags.push(Flag::Clipped { bins: clipped });
        }
        if beyond > 0 {
            flags.push(Flag::HeadInWood { samples: beyond });
        }
        if points.is_empty() {
            return Err(CleanError::TooFew { count: 0, least: 1 });
        }
        Ok(points)
    }
}

/// A drive by a projectile.
struct Impact<'a> {
    mass: f64,
    speed: f64,
    step: f64,
    masses: &'a Masses,
    gravity: f64,
}

impl Impact<'_> {
    /// Samples with the force on the wood and the speed, excluding the first wave transits through the nail.
    fn samples(
        &self,
        trace: &Trace,
        cell: &[f64],
        (first, deepest): (usize, usize),
        slope_samples: usize,
        conditions: &Conditions,
        flags: &mut Vec<Flag>,
    ) -> Result<Vec<(usize, f64, f64)>, CleanError> {
        if !(self.masses.ahead >= 0.0 && self.masses.ahead < self.mass) {
            return Err(CleanError::CellMass {
                ahead: self.masses.ahead,
                mass: self.mass,
            });
        }
        let joined = self.mass + self.masses.nail;
        let factor = joined / (self.mass - self.masses.ahead);
        let half = slope_samples / 2;
        let ringing = (WAVE_PASSES * conditions.specimen.length / WAVE_SPEED / self.step).ceil() as usize;
        let (from, to) = (first + ringing.max(half), (deepest + 1).saturating_sub(half));
        if from + 2 > to {
            return Err(CleanError::TooFew {
                count: to.saturating_sub(from),
                least: 2,
            });
        }
        let slope = |k: usize| {
            let window: Vec<(f64, f64)> = (k - half..=k + half)
                .map(|i| ((i as f64 - k as f64) * self.step, trace.depth[i]))
                .collect();
            line(&window).map_or(0.0, |(_, slope)| slope)
        };
        let samples: Vec<_> = (from..to).map(|k| (k, factor * cell[k], slope(k))).collect();
        // Momentum balance from the impact to the last sample: M_1 (v_1 - v) = int F_r dt - M_1 g t.
        let (last, _, speed) = samples[samples.len() - 1];
        let impulse: f64 = (first..last)
            .map(|k| 0.5 * (cell[k] + cell[k + 1]) * self.step * factor)
            .sum();
        let start = self.speed * self.mass / joined;
        let time = (last - first) as f64 * self.step;
        let found = impulse - joined * self.gravity * time;
        let expected = joined * (start - speed);
        if (found - expected).abs() > MOMENTUM * joined * start {
            flags.push(Flag::Momentum {
                impulse: found,
                loss: expected,
                share: (found - expected) / (joined * start),
            });
        }
        Ok(samples)
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn deviation(values: &[f64], mean: f64) -> f64 {
    (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (values.len() - 1) as f64).sqrt()
}

/// Intercept and slope of the least-squares line; none if it is not determined.
fn line(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let n = points.len() as f64;
    let [mx, my] = [0, 1].map(|i| points.iter().map(|p| if i == 0 { p.0 } else { p.1 }).sum::<f64>() / n);
    let [mut sxx, mut sxy] = [0.0; 2];
    for (x, y) in points {
        sxx += (x - mx) * (x - mx);
        sxy += (x - mx) * (y - my);
    }
    (points.len() > 1 && sxx > 0.0).then(|| (my - sxy / sxx * mx, sxy / sxx))
}
