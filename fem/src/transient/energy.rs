//! Energy bookkeeping of a run.

use serde::Serialize;

use super::kernels::{State, half_squares, sum};
use super::model::{Support, SupportLaw};
use super::system::System;

/// Energies on a coarse uniform grid, all in J; the first entry is t = 0.
///
///   work of loads = change of (kinetic + strain) + dissipated in the modes + change of contact_elastic + contact_lost
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct EnergyHistory {
    /// Times \[s\].
    pub time: Vec<f64>,
    /// Kinetic energy sum q'^2/2 of each body.
    pub kinetic: Vec<Vec<f64>>,
    /// Strain energy sum omega^2 q^2/2 of each body.
    pub strain: Vec<Vec<f64>>,
    /// Energy dissipated by each body's modal damping since t = 0.
    pub dissipated: Vec<Vec<f64>>,
    /// Energy stored in the support springs.
    pub contact_elastic: Vec<f64>,
    /// Energy lost in the supports since t = 0: dashpots, and springs that relax after letting go.
    pub contact_lost: Vec<f64>,
    /// Work of all applied loads since t = 0.
    pub work: Vec<f64>,
}

impl EnergyHistory {
    pub(super) fn new(bodies: usize) -> Self {
        let empty = vec![Vec::new(); bodies];
        Self {
            kinetic: empty.clone(),
            strain: empty.clone(),
            dissipated: empty,
            ..Self::default()
        }
    }

    /// Kinetic, strain and contact energy together at entry k \[J\].
    pub fn mechanical(&self, k: usize) -> f64 {
        let bodies: f64 = self.kinetic.iter().chain(&self.strain).map(|e| e[k]).sum();
        bodies + self.contact_elastic[k]
    }

    /// Kinetic energy of all bodies at entry k \[J\].
    pub fn kinetic_total(&self, k: usize) -> f64 {
        self.kinetic.iter().map(|e| e[k]).sum()
    }

    /// Largest violation of the balance over the largest energy in play, which is the peak of kinetic energy or of the
    /// loads' work, whichever is greater \[1\].
    pub(crate) fn imbalance(&self) -> f64 {
        let (mut worst, mut scale): (f64, f64) = (0.0, 0.0);
        for k in 0..self.time.len() {
            let dissipated: f64 = self.dissipated.iter().map(|e| e[k]).sum();
            let stored = self.mechanical(k) - self.mechanical(0);
            worst = worst.max((self.work[k] - stored - dissipated - self.contact_lost[k]).abs());
            scale = scale.max(self.kinetic_total(k)).max(self.work[k].abs());
        }
        // In a run at rest only the rounding of the static energies is left to compare.
        scale = scale.max(1e-9 * self.mechanical(0));
        if worst == 0.0 { 0.0 } else { worst / scale }
    }

    pub(super) fn record(
        &mut self,
        time: f64,
        system: &System,
        state: &State,
        elastic: f64,
        into_contact: f64,
        work: f64,
    ) {
        self.time.push(time);
        for (b, part) in system.parts.iter().enumerate() {
            let lanes = part.lanes.clone();
            self.kinetic[b].push(half_squares(None, &state.v[lanes.clone()]));
            self.strain[b].push(half_squares(
                Some(&system.omega2[lanes.clone()]),
                &state.q[lanes.clone()],
            ));
            self.dissipated[b].push(sum(&state.dissipated[lanes]));
        }
        let before = self.contact_elastic.first().copied().unwrap_or(elastic);
        self.contact_elastic.push(elastic);
        self.contact_lost.push(into_contact - (elastic - before));
        self.work.push(work);
    }
}

/// Energy sum k d^2/2 of the support springs, touching ones only.
pub(super) fn elastic_energy(supports: &[Support], penetration: &[f64]) -> f64 {
    let spring = |(s, d): (&Support, &f64)| {
        let closed = s.law == SupportLaw::Bonded || *d > 0.0;
        if closed { 0.5 * s.stiffness * d * d } else { 0.0 }
    };
    supports.iter().zip(penetration).map(spring).sum()
}

/// Work and impulse of forces that are linear over each step, along motions given with their rates at the samples.
#[derive(Debug, Clone)]
pub(super) struct Ledger {
    step: f64,
    force: Vec<f64>,
    motion: Vec<f64>,
    rate: Vec<f64>,
    /// Work of all forces \[J\].
    pub(super) work: f64,
    /// Impulse of each force \[N s\].
    pub(super) impulse: Vec<f64>,
}

impl Ledger {
    pub(super) fn new(step: f64, force: &[f64], motion: &[f64], rate: &[f64]) -> Self {
        let impulse = vec![0.0; force.len()];
        Self {
            step,
            force: force.to_vec(),
            motion: motion.to_vec(),
            rate: rate.to_vec(),
            work: 0.0,
            impulse,
        }
    }

    /// Adds a step. With the motion u as the cubic through values and rates at both ends,
    ///
    ///   int F u' dt = (F0 + F1)/2 (u1 - u0) + (F1 - F0) h/12 (u1' - u0'),
    ///
    /// which leaves a relative error of (omega h)^4/720 for a motion at omega.
    pub(super) fn add(&mut self, force: &[f64], motion: &[f64], rate: &[f64]) {
        let h = self.step;
        let mut work = 0.0;
        for k in 0..force.len() {
            let (mean, change) = (0.5 * (self.force[k] + force[k]), force[k] - self.force[k]);
            work += mean * (motion[k] - self.motion[k]) + change * (h / 12.0) * (rate[k] - self.rate[k]);
            self.impulse[k] += h * mean;
        }
        self.work += work;
        self.force.copy_from_slice(force);
        self.motion.copy_from_slice(motion);
        self.rate.copy_from_slice(rate);
    }
}
