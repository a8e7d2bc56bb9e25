//! Two-way coupling: the modes of workpiece and support replace the cycle's lumped workpiece.
//!
//! Cycle and structure advance by the same steps. At the end of each step they agree on the forces between them and on
//! the motion these cause, so that the support's stiffness acts back on penetration, recoil and the release of the
//! trigger. The nail's force acts along its embedded shank, and the motion the nail feels is the mean of the wood's
//! with the same weights: the power that leaves the cycle is the power that reaches the wood.

use std::sync::Arc;

use nailnoise_dynamics::{
    Compliance, CouplingWork, CycleRecord, Parameters, WoodForces, WoodMotion, Workpiece, simulate_on,
};
use nailnoise_fem::vibration::{Driven, ModalBody, ModalResponse, Settings, Support};
use nalgebra::{DMatrix, DVectorView};

use super::nail_force::{DrivenFastener, FastenerLaw, Resistance};
use crate::error::Error;
use crate::result::Check;
use crate::stages::bodies::STATIONS;
use crate::stages::cycle::Cycle;

/// Loads of the shot on the workpiece in the order of a body's load participations: the nail's stations from the
/// surface down, the nose, and gravity.
pub const COUPLED_LOADS: usize = STATIONS + 2;
pub(super) const NOSE: usize = STATIONS;
pub(super) const GRAVITY: usize = STATIONS + 1;

/// The loads without the shot.
const WEIGHT: [f64; COUPLED_LOADS] = {
    let mut loads = [0.0; COUPLED_LOADS];
    loads[GRAVITY] = 1.0;
    loads
};

/// Largest difference of the forces on both sides, as a part of the largest force.
const FORCE_LIMIT: f64 = 1e-6;
/// Largest difference of the work on both sides, as a part of the work of gas, hand and gravity on the tool's bodies.
const WORK_LIMIT: f64 = 1e-4;
/// The same as a part of the largest energy in the structure, a thousandth of the other on a rigid floor: forces that
/// set in or jump within a step leave an error of the order of the step squared.
const STRUCTURE_LIMIT: f64 = 1e-3;

/// A cycle and a response that agree with each other.
pub struct Coupled {
    /// The cycle; its workpiece is the surface under the nose, its support that of the block.
    pub record: CycleRecord,
    /// Parameters of the cycle.
    pub parameters: Parameters,
    /// The response of workpiece and support.
    pub response: Arc<ModalResponse>,
    /// Amplitudes of each body's modes in vacuum for its modes in the response, if they differ.
    pub coordinates: Vec<Option<DMatrix<f64>>>,
    /// Iterations of the coupling and the difference left.
    pub work: CouplingWork,
    /// Forces and work on both sides.
    pub checks: Vec<Check>,
}

/// Computes cycle and response together, the workpiece being the first body.
///
/// Each body's load participations have [`COUPLED_LOADS`] columns, down positive.
///
/// # Errors
/// Those of cycle and response, and that they do not agree.
pub fn couple(
    cycle: &Cycle,
    bodies: &[ModalBody],
    supports: &[Support],
    transient: &Settings,
) -> Result<Coupled, Error> {
    let parameters = &cycle.parameters;
    let mut wood = Wood {
        bodies,
        supports,
        transient,
        resistance: Resistance::of(&DrivenFastener {
            law: FastenerLaw::Nail(Box::new(parameters.clone())),
            friction_share: parameters.friction_share,
        }),
        carrying: carrying(&bodies[0], parameters.ambient.gravity),
        // Under its own weight, until the cycle puts the tool on it.
        run: Driven::new(bodies, supports, &WEIGHT, &WEIGHT, transient)?,
        at: Reading::default(),
        loads: WEIGHT,
        shares: [0.0; STATIONS],
        work: 0.0,
    };
    let (record, work) = simulate_on(parameters, &cycle.settings, &mut wood)?;
    let work_of_wood = wood.work;
    let response = wood.run.finish()?;
    let checks = checks(&record, &response, work_of_wood);
    Ok(Coupled {
        record,
        parameters: parameters.clone(),
        response: Arc::new(response),
        coordinates: vec![None; bodies.len()],
        work,
        checks,
    })
}

/// Part of each support's force on a body that acts upwards: combined effect of weight and support on the rigid
/// motions, Phi_s^T (Phi^T M e)/g = e . n. Without gravity all of them count.
fn carrying(body: &ModalBody, gravity: f64) -> Vec<f64> {
    let weight = body.loads.column(GRAVITY);
    let upwards = |support: DVectorView<'_, f64>| {
        let rigid = (0..body.omega.len()).filter(|&j| body.omega[j] == 0.0);
        rigid.map(|j| support[j] * weight[j]).sum::<f64>() / gravity
    };
    let columns = body.supports.column_iter();
    columns.map(|s| if gravity > 0.0 { upwards(s) } else { 1.0 }).collect()
}

/// Motion of the wood along its loads at a sample.
#[derive(Debug, Clone, Default)]
struct Reading {
    motion: Vec<f64>,
    rate: Vec<f64>,
    /// Position of the material around the nail.
    nail: f64,
}

/// Workpiece and support as a workpiece of the cycle.
struct Wood<'a> {
    bodies: &'a [ModalBody],
    supports: &'a [Support],
    transient: &'a Settings,
    resistance: Resistance,
    /// Part of each support's force that carries the workpiece.
    carrying: Vec<f64>,
    run: Driven<'a>,
    /// At the present sample.
    at: Reading,
    loads: [f64; COUPLED_LOADS],
    shares: [f64; STATIONS],
    /// Work of nail and nose so far.
    work: f64,
}

impl Wood<'_> {
    fn shares(&self, depth: f64) -> [f64; STATIONS] {
        self.resistance.shares(depth)
    }

    fn loads(&self, forces: &WoodForces) -> [f64; COUPLED_LOADS] {
        let mut loads = WEIGHT;
        for (load, share) in loads.iter_mut().zip(self.shares(forces.depth)) {
            *load = forces.nail * share;
        }
        loads[NOSE] = forces.seat;
        loads
    }

    /// The current motion of the run, with the tip at a depth.
    ///
    /// The material around the nail moves by the mean of its stations' motions. Their weights change with depth, so the
    /// mean is taken of the steps, not of the positions: a new station does not move the nail by joining.
    fn reading(&self, depth: f64) -> (Reading, WoodMotion) {
        let run = &self.run;
        let (motion, rate) = (run.motion().to_vec(), run.rate().to_vec());
        let shares = self.shares(depth);
        let (mut step, mut velocity) = (0.0, 0.0);
        for k in 0..STATIONS {
            let before = self.at.motion.get(k).copied().unwrap_or(motion[k]);
            step += 0.5 * (self.shares[k] + shares[k]) * (motion[k] - before);
            velocity += shares[k] * rate[k];
        }
        let nail = self.at.nail + step;
        let answer = WoodMotion {
            seat: [motion[NOSE], rate[NOSE]],
            nail: [nail, velocity],
            support: run
                .support_forces()
                .iter()
                .zip(&self.carrying)
                .map(|(f, c)| f * c)
                .sum(),
        };
        (Reading { motion, rate, nail }, answer)
    }

    fn keep(&mut self, reading: Reading, forces: &WoodForces) {
        self.at = reading;
        self.loads = self.loads(forces);
        self.shares = self.shares(forces.depth);
    }
}

impl Workpiece for Wood<'_> {
    type Error = Error;

    fn start(&mut self, seat: f64) -> Result<WoodMotion, Error> {
        let forces = WoodForces {
            seat,
            ..WoodForces::default()
        };
        let loads = self.loads(&forces);
        self.run = Driven::new(self.bodies, self.supports, &loads, &WEIGHT, self.transient)?;
        self.at.nail = self.run.motion()[0];
        let (reading, motion) = self.reading(0.0);
        self.keep(reading, &forces);
        Ok(motion)
    }

    fn compliance(&self, depth: f64) -> Compliance {
        let run = &self.run;
        let shares = self.shares(depth);
        let nail = || shares.iter().copied().enumerate().filter(|(_, share)| *share > 0.0);
        let of = |rate: bool| {
            let both: f64 = nail()
                .map(|(k, a)| nail().map(|(l, b)| a * b * run.compliance(rate, k, l)).sum::<f64>())
                .sum();
            let cross: f64 = nail().map(|(k, a)| a * run.compliance(rate, k, NOSE)).sum();
            [[both, cross], [cross, run.compliance(rate, NOSE, NOSE)]]
        };
        Compliance {
            position: of(false),
            velocity: of(true),
        }
    }

    fn trial(&mut self, forces: &WoodForces) -> Result<WoodMotion, Error> {
        let loads = self.loads(forces);
        self.run.trial(&loads)?;
        Ok(self.reading(forces.depth).1)
    }

    fn accept(&mut self, forces: &WoodForces) -> Result<WoodMotion, Error> {
        let loads = self.loads(forces);
        self.run.accept(&loads)?;
        let (reading, motion) = self.reading(forces.depth);
        // Forces linear, motion cubic over the step.
        let h = self.transient.step;
        for (l, (before, after)) in self.loads.iter().zip(&loads).enumerate().take(GRAVITY) {
            let (mean, change) = (0.5 * (before + after), after - before);
            self.work += mean * (reading.motion[l] - self.at.motion[l])
                + change * (h / 12.0) * (reading.rate[l] - self.at.rate[l]);
        }
        self.keep(reading, forces);
        Ok(motion)
    }
}

/// Forces and work on both sides of the coupling.
fn checks(record: &CycleRecord, response: &ModalResponse, work_of_wood: f64) -> Vec<Check> {
    let (mut apart, mut largest) = (0.0f64, f64::MIN_POSITIVE);
    for sample in 0..record.len().min(response.samples()) {
        let on_wood = response.loads.column(sample);
        let nail: f64 = on_wood.rows(0, STATIONS).sum();
        let seat = record.forces.nose[sample].max(0.0) + record.forces.guard[sample];
        for (cycle, wood) in [(record.forces.penetration[sample], nail), (seat, on_wood[NOSE])] {
            apart = apart.max((cycle - wood).abs());
            largest = largest.max(cycle.abs());
        }
    }
    let energy = &response.energy;
    let peak = (0..energy.time.len()).fold(f64::MIN_POSITIVE, |peak, k| {
        peak.max(energy.kinetic_total(k)).max(energy.work[k].abs())
    });
    let e = &record.energy;
    let applied = e.piston_work.abs() + e.valve_work.abs() + e.hand.abs() + e.gravity.abs();
    vec![
        Check::at_most(
            "coupling: force difference between cycle and wood, relative to the largest force [-]",
            apart / largest,
            FORCE_LIMIT,
        ),
        Check::at_most(
            "coupling: work difference between cycle and wood, relative to the work of all forces [-]",
            (record.energy.wood - work_of_wood) / applied,
            WORK_LIMIT,
        ),
        Check::at_most(
            "coupling: work difference between cycle and wood, relative to the structure's energy [-]",
            (record.energy.wood - work_of_wood) / peak,
            STRUCTURE_LIMIT,
        ),
    ]
}
