//! Energy bookkeeping of a run.

use serde::Serialize;

use super::kernels::{Lane, State, half_squares, sum};
use super::model::{ModalBody, Support, SupportLaw};
use super::system::{System, effective_zeta};

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
    /// Energy lost in the supports since t = 0: in dashpots, and in springs that relax after separation.
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

    /// Total kinetic, strain and contact energy at entry k \[J\].
    pub fn mechanical(&self, k: usize) -> f64 {
        let bodies: f64 = self.kinetic.iter().chain(&self.strain).map(|e| e[k]).sum();
        bodies + self.contact_elastic[k]
    }

    /// Kinetic energy of all bodies at entry k \[J\].
    pub fn kinetic_total(&self, k: usize) -> f64 {
        self.kinetic.iter().map(|e| e[k]).sum()
    }

    /// Largest violation of the energy balance, relative to the peak of kinetic energy or of the loads' work, whichever
    /// is greater \[1\].
    pub(crate) fn imbalance(&self) -> f64 {
        let (mut worst, mut scale): (f64, f64) = (0.0, 0.0);
        for k in 0..self.time.len() {
            let dissipated: f64 = self.dissipated.iter().map(|e| e[k]).sum();
            let stored = self.mechanical(k) - self.mechanical(0);
            worst = worst.max((self.work[k] - stored - dissipated - self.contact_lost[k]).abs());
            scale = scale.max(self.kinetic_total(k)).max(self.work[k].abs());
        }
        // In a run at rest, only the rounding of the static energies remains to compare.
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

/// Energy sum k d^2/2 of the support springs in contact.
pub(super) fn elastic_energy(supports: &[Support], penetration: &[f64]) -> f64 {
    let spring = |(s, d): (&Support, &f64)| {
        let closed = s.law == SupportLaw::Bonded || *d > 0.0;
        if closed { 0.5 * s.stiffness * d * d } else { 0.0 }
    };
    supports.iter().zip(penetration).map(spring).sum()
}

/// For modes up to this omega h, the cubic of a [`Ledger`] suffices; its relative error in their work is (omega
/// h)^4/720 = 2e-5.
const RESOLVED: f64 = 0.35;

/// Work in poorly resolved modes that the cubic of a [`Ledger`] misses. Residual vectors are such modes: their
/// frequencies are far above those of the analysis, and they follow every kink of a force.
///
/// A mode's equation of motion yields the integral of its motion over a step without quadrature:
///
///   int q dt = ((g0 + g1) h/2 - (q1' - q0') - 2 zeta omega (q1 - q0))/omega^2.
///
/// From it follows the work of a modal force that is linear over the step, beyond that of the cubic:
///
///   -(f1 - f0)/h (int q dt - (q0 + q1) h/2 + (q1' - q0') h^2/12).
#[derive(Debug, Clone)]
pub(super) struct Unresolved {
    step: f64,
    modes: Vec<PoorlyResolved>,
}

#[derive(Debug, Clone)]
struct PoorlyResolved {
    lane: usize,
    slot: usize,
    /// 2 zeta omega \[1/s\] and omega^2.
    damping: f64,
    omega2: f64,
    /// q, q', force of the loads and of the supports at the start of the step.
    start: [f64; 4],
}

impl Unresolved {
    pub(super) fn new(bodies: &[ModalBody], system: &System, step: f64) -> Self {
        let mut modes = Vec::new();
        for (body, part) in bodies.iter().zip(&system.parts) {
            for (j, (&omega, &zeta)) in body.omega.iter().zip(&body.zeta).enumerate() {
                if omega * step > RESOLVED {
                    modes.push(PoorlyResolved {
                        lane: part.lanes.start + j / 4,
                        slot: j % 4,
                        damping: 2.0 * effective_zeta(omega, zeta, step) * omega,
                        omega2: omega * omega,
                        start: [0.0; 4],
                    });
                }
            }
        }
        Self { step, modes }
    }

    /// Sets the state at t = 0.
    pub(super) fn begin(&mut self, state: &State) {
        self.modes.iter_mut().for_each(|mode| mode.start = mode.now(state));
    }

    /// Advances to the state at the end of a step; returns the work of loads and of supports that ledgers miss \[J\].
    pub(super) fn add(&mut self, state: &State) -> [f64; 2] {
        let h = self.step;
        let mut left_out = [0.0; 2];
        for mode in &mut self.modes {
            let ([q0, v0, load0, support0], end) = (mode.start, mode.now(state));
            let [q1, v1, load1, support1] = end;
            let impulse = 0.5 * h * (load0 + support0 + load1 + support1);
            let integral = (impulse - (v1 - v0) - mode.damping * (q1 - q0)) / mode.omega2;
            let beyond = integral - 0.5 * h * (q0 + q1) + h * h / 12.0 * (v1 - v0);
            left_out[0] -= (load1 - load0) / h * beyond;
            left_out[1] -= (support1 - support0) / h * beyond;
            mode.start = end;
        }
        left_out
    }
}

impl PoorlyResolved {
    fn now(&self, state: &State) -> [f64; 4] {
        let at = |values: &[Lane]| values[self.lane][self.slot];
        [at(&state.q), at(&state.v), at(&state.applied), at(&state.contact)]
    }
}

/// Work and impulse of forces that are linear over each step, for motions given with their rates at the samples.
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

    /// Adds a step. With u approximated by the cubic through values and rates at both ends, the work is
    ///
    ///   int F u' dt = (F0 + F1)/2 (u1 - u0) + (F1 - F0) h/12 (u1' - u0').
    ///
    /// The relative error is (omega h)^4/720 for a motion at omega; [`Unresolved`] removes it if it is large.
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use nalgebra::DMatrix;

    use crate::random::Random;
    use crate::vibration::{Loads, ModalBody, Settings, Start, Support, SupportLaw, respond};

    /// Energy imbalance of a mode at omega h = `phase` under an irregular load, on a spring if `supported`.
    fn imbalance(phase: f64, supported: bool) -> f64 {
        let settings = Settings {
            duration: 2e-3,
            decay: f64::INFINITY,
            start: Start::Rest,
            require_contact: false,
            ..Settings::default()
        };
        let mut random = Random::new(3);
        let (modes, supports) = (2, usize::from(supported));
        let body = ModalBody {
            name: "mode".into(),
            omega: vec![1000.0, phase / settings.step],
            zeta: vec![0.01; modes],
            loads: DMatrix::from_element(modes, 1, 1.0),
            supports: DMatrix::from_element(modes, supports, 1.0),
        };
        let spring = Support {
            stiffness: 1e9,
            damping: 100.0,
            gap: 0.0,
            law: SupportLaw::Bonded,
        };
        let loads = Loads {
            interval: settings.step,
            history: DMatrix::from_fn(1, 200, |_, _| 100.0 * random.next()),
            final_values: vec![0.0],
        };
        let response = respond(&[body], &vec![spring; supports], &loads, &settings).unwrap();
        response.energy.imbalance()
    }

    #[test]
    fn the_balance_closes_for_modes_that_the_step_resolves_poorly() {
        for supported in [false, true] {
            for phase in [0.5, 1.0, 2.0, 3.1, 5.0, 40.0] {
                let found = imbalance(phase, supported);
                // Without the correction, the cubic would leave an imbalance of up to 0.01; the error of the mode on
                // its spring, at omega h = 0.2, remains.
                assert!(found < 1e-6, "omega h = {phase}, supported {supported}: {found:e}");
            }
        }
    }
}
