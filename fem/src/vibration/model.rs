//! The inputs of a transient run: bodies in modal coordinates, supports, loads, start and settings.

use nalgebra::DMatrix;
use serde::Serialize;

/// A linear body in mass-normalised modal coordinates q [m sqrt(kg)].
///
///   q_j'' + 2 zeta_j omega_j q_j' + omega_j^2 q_j = sum_l loads_jl F_l - sum_i supports_ji f_i.
///
/// F_l are applied forces \[N\] and f_i support forces \[N\] (positive when the support pushes the body back).
#[derive(Debug, Clone, PartialEq)]
pub struct ModalBody {
    /// Name for messages and results.
    pub name: String,
    /// Angular natural frequencies [rad/s]; exactly 0 for a rigid mode.
    pub omega: Vec<f64>,
    /// Damping ratios zeta = eta/2 of the modes \[1\]; no effect if omega = 0.
    pub zeta: Vec<f64>,
    /// Modes x loads [1/sqrt(kg)]: mode shape at the point and in the direction of each load (for a distributed load,
    /// its virtual work per unit of F_l). A load that does not act on this body has a column of zeros.
    pub loads: DMatrix<f64>,
    /// Modes x supports [1/sqrt(kg)]: mode shape at each support point along the body's OUTWARD normal, so that
    /// positive motion closes the gap. Two bodies in contact have opposite normals there, hence opposite forces.
    pub supports: DMatrix<f64>,
}

impl ModalBody {
    /// Number of modes.
    pub fn modes(&self) -> usize {
        self.omega.len()
    }
}

/// Behaviour of a support when its gap is open or its force would be tensile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SupportLaw {
    /// f = max(0, k d + c d') while d > 0, else 0: the support transmits only compression and can open.
    Unilateral,
    /// f = k d + c d' always: glued, linear.
    Bonded,
}

/// A spring and a parallel dashpot between two bodies, or between a body and the ground, which act on the penetration d
/// = sum over bodies (supports^T q) - gap.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Support {
    /// Stiffness k = k'' A_i [N/m].
    pub stiffness: f64,
    /// Dashpot constant c = c'' A_i [N s/m].
    pub damping: f64,
    /// Gap at q = 0 \[m\]; negative for an initial penetration.
    pub gap: f64,
    /// Whether it can transmit tension.
    pub law: SupportLaw,
}

/// Applied loads on the uniform time grid of the cycle's record, piecewise linear between samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Loads {
    /// Sampling interval \[s\] of `history`.
    pub interval: f64,
    /// Loads x samples \[N\], the first column at t = 0.
    pub history: DMatrix<f64>,
    /// Value of each load \[N\] long after the record: gravity is constant, while the forces of the shot approach final
    /// values.
    pub final_values: Vec<f64>,
}

impl Loads {
    /// Loads that are constant in time.
    pub fn constant(values: &[f64]) -> Self {
        Self {
            interval: 1.0,
            history: DMatrix::from_column_slice(values.len(), 1, values),
            final_values: values.to_vec(),
        }
    }

    /// Number of loads.
    pub fn count(&self) -> usize {
        self.history.nrows()
    }

    /// Time of the last sample \[s\].
    pub(crate) fn record_end(&self) -> f64 {
        self.interval * self.history.ncols().saturating_sub(1) as f64
    }

    /// Samples the loads on the grid 0, `step`, 2 `step`, ...: loads x `samples`. They are linear between the record's
    /// samples. After the record,
    ///
    ///   F(t) = F_final + (F_end - F_final) (1 + cos(pi (t - t_end)/taper))/2  for  t_end < t < t_end + taper,
    ///
    /// and F_final afterwards.
    pub fn sampled(&self, step: f64, samples: usize, taper: f64) -> DMatrix<f64> {
        let last = self.history.ncols() - 1;
        let end = self.record_end();
        let mut sampled = DMatrix::zeros(self.count(), samples);
        for n in 0..samples {
            let time = n as f64 * step;
            let position = time / self.interval;
            // A grid time that equals a record time up to rounding uses that sample.
            let nearest = position.round();
            let on_sample = (position - nearest).abs() <= 1e-9 * position.max(1.0);
            let position = if on_sample { nearest } else { position };
            let mut column = sampled.column_mut(n);
            if position <= last as f64 {
                let left = (position.floor() as usize).min(last);
                let right = (left + 1).min(last);
                let weight = position - left as f64;
                for l in 0..self.count() {
                    let (a, b) = (self.history[(l, left)], self.history[(l, right)]);
                    column[l] = a + weight * (b - a);
                }
            } else {
                let remaining = if time < end + taper {
                    0.5 * (1.0 + (std::f64::consts::PI * (time - end) / taper).cos())
                } else {
                    0.0
                };
                for l in 0..self.count() {
                    let (from, to) = (self.history[(l, last)], self.final_values[l]);
                    column[l] = to + (from - to) * remaining;
                }
            }
        }
        sampled
    }
}

/// Displacements and velocities of one body's modes.
#[derive(Debug, Clone, PartialEq)]
pub struct ModalState {
    /// q [m sqrt(kg)].
    pub displacement: Vec<f64>,
    /// q' [m sqrt(kg)/s].
    pub velocity: Vec<f64>,
}

impl ModalState {
    /// A body at rest, undeformed.
    pub fn rest(modes: usize) -> Self {
        Self {
            displacement: vec![0.0; modes],
            velocity: vec![0.0; modes],
        }
    }
}

/// Which time derivative of the modal coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Motion {
    /// q.
    Displacement,
    /// q'.
    Velocity,
    /// q''.
    Acceleration,
}

/// State at t = 0.
#[derive(Debug, Clone, PartialEq)]
pub enum Start {
    /// At rest in static equilibrium with the loads at t = 0 (gravity, tool weight, hand force).
    Equilibrium,
    /// At rest with q = 0; the loads at t = 0 are applied suddenly.
    Rest,
    /// Given states, one per body: a perturbed equilibrium, a falling body.
    State(Vec<ModalState>),
}

/// Settings of a transient run.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Step h \[s\].
    pub step: f64,
    /// Longest time simulated \[s\].
    pub duration: f64,
    /// Time \[s\] that the loads take to approach their final values after the end of the record.
    pub taper: f64,
    /// Decrease of the energy below its maximum \[dB\] at which the run ends after the taper; infinite to continue to
    /// `duration`.
    pub decay: f64,
    /// Interval of the energy histories and of the decay test \[s\], rounded to whole steps.
    pub energy_interval: f64,
    /// State at t = 0.
    pub start: Start,
    /// Largest number of changes to the set of touching supports within one step.
    pub max_contact_iterations: usize,
    /// Largest omega h of the bodies' vibration on their supports. The contact force is linear over a step (linear
    /// acceleration method): stable up to 2 sqrt 3, period error (omega h)^2/24.
    pub contact_rate_limit: f64,
    /// Whether it is an error if no unilateral support ever touches.
    pub require_contact: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            step: 4e-6,
            duration: 0.3,
            taper: 5e-3,
            decay: 40.0,
            energy_interval: 1e-4,
            start: Start::Equilibrium,
            max_contact_iterations: 200,
            contact_rate_limit: 1.0,
            require_contact: true,
        }
    }
}
