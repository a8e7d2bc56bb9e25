//! Outcomes of many shots without their sound: the inexpensive part of a study.

use nailnoise_dynamics::network::{self, RunError};
use nailnoise_dynamics::{CycleError, simulate_figures};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::cycle::{AssembledCycle, Cycle, Engine, ShotRecord};
use super::{Code, Postcard, Progress, Stage, code};
use crate::error::Error;

/// The cycles of several shots.
#[derive(Serialize)]
pub struct Outcomes {
    /// The engine of each.
    pub engines: Vec<Engine>,
}

/// The outcome of a shot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum ShotOutcome {
    /// The cycle was computed.
    Shot(ShotFigures),
    /// The piston used up the volume below it: nothing stops it, and the model is no longer valid.
    DryFire,
    /// The solver failed.
    SolverFailure(String),
    /// The values violate a rule of the cycle.
    Refused(String),
}

/// Figures of a shot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ShotFigures {
    /// Name of the outcome in the output.
    pub outcome: String,
    /// Mean speed of the piston over the nail's length in the wood \[m/s\].
    pub mean_drive_speed: Option<f64>,
    /// Maximum depth of the nail's tip \[m\].
    pub penetration: f64,
    /// Mass that left through the exhaust holes \[kg\].
    pub exhaust_mass: f64,
}

impl ShotOutcome {
    /// Its name: the outcome, `dry_fire`, `solver_failure` or `refused`.
    pub fn name(&self) -> &str {
        match self {
            Self::Shot(shot) => &shot.outcome,
            Self::DryFire => "dry_fire",
            Self::SolverFailure(_) => "solver_failure",
            Self::Refused(_) => "refused",
        }
    }
}

impl Stage for Outcomes {
    type Output = Vec<ShotOutcome>;
    type Error = Error;
    type Codec = Postcard;
    const NAME: &'static str = "outcomes of shots";
    const CODE: Code = code![dynamics, stages_cycle, stages_outcomes];

    fn compute(&self, _: &Progress) -> Result<Vec<ShotOutcome>, Error> {
        Ok(self.engines.par_iter().map(outcome).collect())
    }
}

/// The outcome of the shot of an engine.
pub fn outcome(engine: &Engine) -> ShotOutcome {
    match engine {
        Engine::Keys(cycle) => of_keys(cycle),
        Engine::Assembly(cycle) => of_assembly(cycle),
    }
}

fn of_assembly(cycle: &AssembledCycle) -> ShotOutcome {
    match network::simulate(&cycle.assembly, &cycle.numerics) {
        Ok(record) => {
            let shot = ShotRecord::of_assembly(&cycle.assembly, record);
            ShotOutcome::Shot(ShotFigures {
                mean_drive_speed: None,
                penetration: shot.fastener_depth(),
                exhaust_mass: shot.discharged_mass(),
                outcome: shot.outcome,
            })
        }
        Err(
            error @ (RunError::Integration { .. }
            | RunError::Collapse { .. }
            | RunError::Chatter { .. }
            | RunError::Switching { .. }
            | RunError::Coupling { .. }),
        ) => ShotOutcome::SolverFailure(error.to_string()),
        Err(error) => ShotOutcome::Refused(error.to_string()),
    }
}

fn of_keys(cycle: &Cycle) -> ShotOutcome {
    match simulate_figures(&cycle.parameters, &cycle.settings) {
        Ok((figures, _)) => ShotOutcome::Shot(ShotFigures {
            outcome: figures.outcome.name().to_owned(),
            mean_drive_speed: figures.summary.mean_drive_speed,
            penetration: figures.summary.penetration,
            exhaust_mass: figures.summary.exhaust_mass,
        }),
        Err(CycleError::DryFire { .. }) => ShotOutcome::DryFire,
        Err(error @ (CycleError::Integration { .. } | CycleError::Collapse { .. } | CycleError::Chatter { .. })) => {
            ShotOutcome::SolverFailure(error.to_string())
        }
        Err(error) => ShotOutcome::Refused(rule(&error).to_owned()),
    }
}

/// The rule of the cycle that a shot violates.
fn rule(error: &CycleError) -> &'static str {
    match error {
        CycleError::ValveNotClosed { .. } => "the head valve does not close",
        CycleError::SpringRange { .. } => "the closing spring leaves its law",
        CycleError::LapOverlap { .. } => "intake and exhaust overlap",
        CycleError::DiameterOrder { .. } => "a diameter exceeds its outer one",
        _ => "another rule of the cycle",
    }
}
