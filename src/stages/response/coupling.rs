//! Two-way coupling: the modes of workpiece and support replace the cycle's lumped workpiece, whichever engine computes
//! the cycle.
//!
//! Cycle and structure advance in the same steps. At the end of each step, the forces between them are consistent with
//! the motion that the forces cause, so that the support's stiffness acts back on penetration, recoil and the release
//! of the trigger. The nail's force acts along its embedded shank. The wood's motion at the nail is the mean with the
//! same weights, so that the power that leaves the cycle equals the power that reaches the wood.

use std::sync::Arc;

use nailnoise_dynamics::network::{self, Record};
use nailnoise_dynamics::{Compliance, CouplingWork, WoodForces, WoodMotion, Workpiece, simulate_on};
use nailnoise_fem::vibration::{Driven, ModalBody, ModalResponse, Settings, Support};
use nalgebra::{DMatrix, DVectorView};

use super::nail_force::{DrivenFastener, Resistance};
use crate::error::Error;
use crate::result::Check;
use crate::stages::bodies::STATIONS;
use crate::stages::cycle::{Engine, OnWorkpiece, ShotRecord, WORKPIECE};

/// Loads of the shot on the workpiece, in the order of a body's load participations: the nail stations from the surface
/// downwards, the nose, and gravity.
pub const COUPLED_LOADS: usize = STATIONS + 2;
pub(super) const NOSE: usize = STATIONS;
pub(super) const GRAVITY: usize = STATIONS + 1;

/// The loads without a shot.
const WEIGHT: [f64; COUPLED_LOADS] = {
    let mut loads = [0.0; COUPLED_LOADS];
    loads[GRAVITY] = 1.0;
    loads
};

/// Largest difference between the forces on both sides, relative to the largest force.
const FORCE_LIMIT: f64 = 1e-6;
/// Largest difference between the work on both sides, relative to the work of gas, motors and forces on the
/// tool's bodies.
const WORK_LIMIT: f64 = 1e-4;
/// The same relative to the largest energy in the structure, which on a rigid floor is a thousandth of the other.
/// Forces that start or jump within a step cause an error proportional to the square of the step.
const STRUCTURE_LIMIT: f64 = 1e-3;

/// A cycle and a response that are consistent with each other.
pub struct Coupled {
    /// The cycle; its workpiece is the surface below the nose, its support that of the block.
    pub shot: ShotRecord,
    /// The response of workpiece and support.
    pub response: Arc<ModalResponse>,
    /// For each body, amplitudes of its modes in vacuum in terms of its modes in the response, if they differ.
    pub coordinates: Vec<Option<DMatrix<f64>>>,
    /// Iterations of the coupling, and the remaining difference.
    pub work: CouplingWork,
    /// Forces and work on both sides.
    pub checks: Vec<Check>,
}

/// The tool on the bodies: its cycle, its fastener and the acceleration due to gravity \[m/s2\].
#[derive(Debug, Clone, Copy)]
pub struct CoupledTool<'a> {
    /// The engine of the cycle.
    pub engine: &'a Engine,
    /// The fastener in the workpiece; `None` for a tool that drives none.
    pub fastener: Option<&'a DrivenFastener>,
    /// Acceleration due to gravity \[m/s2\].
    pub gravity: f64,
}

/// Computes cycle and response together; the workpiece is the first body.
///
/// Each body's load participations have [`COUPLED_LOADS`] columns, down positive.
///
/// # Errors
/// The errors of cycle and response, and an error if the two do not converge.
pub fn couple(
    tool: CoupledTool<'_>,
    bodies: &[ModalBody],
    supports: &[Support],
    transient: &Settings,
) -> Result<Coupled, Error> {
    let mut wood = Wood {
        bodies,
        supports,
        transient,
        resistance: tool.fastener.map(Resistance::of),
        carrying: carrying(&bodies[0], tool.gravity),
        // The bodies are under their own weight until the cycle places the tool on them.
        run: Driven::new(bodies, supports, &WEIGHT, &WEIGHT, transient)?,
        at: Reading::default(),
        loads: WEIGHT,
        shares: [0.0; STATIONS],
        work: 0.0,
    };
    let (shot, work) = shot_on(tool.engine, &mut wood)?;
    let work_of_wood = wood.work;
    let response = wood.run.finish()?;
    let checks = checks(&shot, &response, work_of_wood);
    Ok(Coupled {
        shot,
        response: Arc::new(response),
        coordinates: vec![None; bodies.len()],
        work,
        checks,
    })
}

/// The shot of an engine on external wood.
fn shot_on(engine: &Engine, wood: &mut Wood<'_>) -> Result<(ShotRecord, CouplingWork), Error> {
    match engine {
        Engine::Keys(cycle) => {
            let (record, work) = simulate_on(&cycle.parameters, &cycle.settings, wood)?;
            Ok((ShotRecord::of_keys(record), work))
        }
        Engine::Assembly(cycle) => {
            let bodies = &cycle.assembly.bodies;
            // An assembly without it is refused before.
            let body = bodies.iter().position(|body| body.name == WORKPIECE);
            let body = body.unwrap_or(bodies.len());
            let coupled = network::simulate_on(&cycle.assembly, &cycle.numerics, body, wood);
            let (record, work) = coupled.map_err(|error| match error {
                Error::Network(error) => cycle.placed(error.placed.error),
                other => other,
            })?;
            Ok((ShotRecord::of_assembly(&cycle.assembly, record), work))
        }
    }
}

/// Fraction of each support's force on a body that acts upwards: the combined effect of weight and support on the
/// rigid-body motions, Phi_s^T (Phi^T M e)/g = e . n. Without gravity, every support counts fully.
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
    /// Of a fastener, if the tool drives one.
    resistance: Option<Resistance>,
    /// Fraction of each support's force that carries the workpiece.
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
        match &self.resistance {
            Some(resistance) => resistance.shares(depth),
            None => std::array::from_fn(|station| if station == 0 { 1.0 } else { 0.0 }),
        }
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
    /// The displacement of the material around the nail is the mean of its stations' displacements. Because the weights
    /// change with depth, the mean is taken of the increments, not of the positions; so adding a station does not move
    /// the nail.
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
        self.at = Reading {
            nail: self.run.motion()[0],
            ..Reading::default()
        };
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
        // Forces are linear and the motion is cubic over the step.
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
fn checks(shot: &ShotRecord, response: &ModalResponse, work_of_wood: f64) -> Vec<Check> {
    let forces = shot.workpiece.as_ref();
    let (mut apart, mut largest) = (0.0f64, f64::MIN_POSITIVE);
    for sample in 0..shot.len().min(response.samples()) {
        let on_wood = response.loads.column(sample);
        let nail: f64 = on_wood.rows(0, STATIONS).sum();
        let [of_nail, seat] = forces.map_or([0.0; 2], |on| forces_at(on, sample));
        for (cycle, wood) in [(of_nail, nail), (seat, on_wood[NOSE])] {
            apart = apart.max((cycle - wood).abs());
            largest = largest.max(cycle.abs());
        }
    }
    let energy = &response.energy;
    let peak = (0..energy.time.len()).fold(f64::MIN_POSITIVE, |peak, k| {
        peak.max(energy.kinetic_total(k)).max(energy.work[k].abs())
    });
    let [work, applied] = work_of(&shot.record);
    let applied = applied.max(f64::MIN_POSITIVE);
    vec![
        Check::at_most(
            "coupling: force difference between cycle and wood, relative to the largest force [-]",
            apart / largest,
            FORCE_LIMIT,
        ),
        Check::at_most(
            "coupling: work difference between cycle and wood, relative to the work of all forces [-]",
            (work - work_of_wood) / applied,
            WORK_LIMIT,
        ),
        Check::at_most(
            "coupling: work difference between cycle and wood, relative to the structure's energy [-]",
            (work - work_of_wood) / peak,
            STRUCTURE_LIMIT,
        ),
    ]
}

/// Forces of fastener and seat in the cycle at a sample. A nose that lands may pull until the end of the step in which
/// it meets the wood, but not in the wood.
fn forces_at(on: &OnWorkpiece, sample: usize) -> [f64; 2] {
    [on.fastener[sample], on.seat[sample] - on.nose[sample].min(0.0)]
}

/// Work of a cycle on its workpiece, and of gas, motors and forces on its bodies.
fn work_of(record: &Record) -> [f64; 2] {
    let of = |prefix: &str| -> f64 {
        let entries = record.ledger.iter().filter(|entry| entry.name.starts_with(prefix));
        entries.map(|entry| entry.value.abs()).sum()
    };
    [
        record.integral(&format!("coupling.{WORKPIECE}")).unwrap_or(f64::NAN),
        of("work."),
    ]
}
