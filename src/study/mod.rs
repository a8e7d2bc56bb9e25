//! Designs drawn at random from the ranges of a design: what becomes of each shot.
//!
//! Every key that has a range and takes part in the cycle is drawn uniformly from it, independently of the others.
//! Draws whose values do not go together are no designs: they are counted and drawn again.

mod parameters;

use std::collections::BTreeMap;

use nailnoise_acoustics::random::uniform;
use nailnoise_dynamics::prf::fit::standard_normal;
use nailnoise_dynamics::{CycleError, Outcome, Parameters, Settings, Summary, simulate};
use rayon::prelude::*;
use serde::Serialize;

pub use parameters::{Parameter, taking_part};

use crate::design::inputs::cycle::{cycle_settings, parameters as cycle_parameters};
use crate::design::{Conflict, Design, Value};
use crate::error::Error;
use crate::stages::Progress;

/// Candidates drawn at most for each design asked for, lest a design whose ranges hardly go together never ends.
const MOST_CANDIDATES: usize = 1000;
/// Candidates computed at a time.
const BATCH: usize = 256;
/// Interval of the samples, which no outcome needs \[s\].
const SAMPLES: f64 = 1e-3;

/// Designs drawn from the ranges of one.
#[derive(Debug, Clone, Serialize)]
pub struct Study {
    /// Seed of the draws.
    pub seed: u64,
    /// The keys that were drawn.
    pub parameters: Vec<Parameter>,
    /// Candidates drawn for the designs, those that were refused among them.
    pub candidates: usize,
    /// How many were refused, by the keys that do not go together or the rule of the cycle that is broken.
    pub refused: BTreeMap<String, usize>,
    /// How many designs came to each end: an outcome, `dry_fire` or `solver_failure`.
    pub counts: BTreeMap<String, usize>,
    /// The designs, in the order they were drawn.
    pub draws: Vec<Draw>,
}

/// One design drawn.
#[derive(Debug, Clone, Serialize)]
pub struct Draw {
    /// Number of the candidate.
    pub candidate: usize,
    /// Values of the parameters, in their order.
    pub values: Vec<Value>,
    /// What became of it.
    pub fate: Fate,
}

/// What became of a shot.
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Fate {
    /// The cycle was computed.
    Shot {
        /// What the shot did.
        outcome: Outcome,
        /// Its figures.
        summary: Box<Summary>,
    },
    /// The piston used up the volume below it: nothing stops it, and the model ends.
    DryFire,
    /// The solver gave up.
    SolverFailure(String),
}

impl Fate {
    /// Its name: the outcome, `dry_fire` or `solver_failure`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Shot { outcome, .. } => outcome_name(*outcome),
            Self::DryFire => "dry_fire",
            Self::SolverFailure(_) => "solver_failure",
        }
    }
}

/// The name of an outcome, as in the output.
pub fn outcome_name(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Drives => "drives",
        Outcome::StrikesBumper => "strikes_bumper",
        Outcome::Underdriven => "underdriven",
        Outcome::Overdriven => "overdriven",
        Outcome::DoesNotOpen => "does_not_open",
        Outcome::DoesNotRelease => "does_not_release",
    }
}

/// Draws `count` designs from the ranges of `design` and computes the cycle of each.
///
/// The draws depend on `seed` and the ranges alone, not on the number of threads. Fewer than `count` designs come back
/// where a thousand candidates for each were not enough.
///
/// # Errors
/// As [`parameters`](cycle_parameters).
pub fn study(design: &Design, count: usize, seed: u64, progress: &Progress) -> Result<Study, Error> {
    let parameters = taking_part(design)?;
    let settings = Settings {
        sample_interval: SAMPLES,
        ..cycle_settings(design)
    };
    let mut study = Study {
        seed,
        parameters,
        candidates: 0,
        refused: BTreeMap::new(),
        counts: BTreeMap::new(),
        draws: Vec::new(),
    };
    while study.draws.len() < count && study.candidates < MOST_CANDIDATES.saturating_mul(count) {
        let first = study.candidates;
        let candidate = |index| candidate(design, &study.parameters, &settings, seed, index);
        let batch: Vec<_> = (first..first + BATCH).into_par_iter().map(candidate).collect();
        for result in batch {
            if study.draws.len() == count {
                break;
            }
            study.candidates += 1;
            match result {
                Ok(draw) => {
                    *study.counts.entry(draw.fate.name().to_owned()).or_default() += 1;
                    study.draws.push(draw);
                }
                Err(reason) => *study.refused.entry(reason).or_default() += 1,
            }
        }
        progress.done(study.draws.len() as u64, count as u64);
    }
    Ok(study)
}

/// FNV-1a of a key, so that another key in the design changes no number drawn for this one.
fn hash(key: &str) -> u64 {
    key.bytes().fold(0xCBF2_9CE4_8422_2325, |hash: u64, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01B3)
    })
}

/// One candidate, or why it is no design.
fn candidate(
    design: &Design,
    parameters: &[Parameter],
    settings: &Settings,
    seed: u64,
    candidate: usize,
) -> Result<Draw, String> {
    let draw = |parameter: &Parameter| {
        let share = uniform(seed, candidate as u64, hash(&parameter.key));
        let [low, high] = parameter.range;
        match parameter.value {
            // Every whole number of the range is as likely.
            Value::Count(_) => parameter.hold((low.ceil() + share * (high.floor() - low.ceil() + 1.0)).floor()),
            _ => parameter.hold(low + share * (high - low)),
        }
    };
    let values: Vec<Value> = parameters.iter().map(draw).collect();
    let changes: Vec<(&str, Value)> = parameters
        .iter()
        .map(|p| p.key.as_str())
        .zip(values.iter().cloned())
        .collect();
    let mut drawn = design.clone();
    drawn.set(&changes).map_err(|error| error.to_string())?;
    if let Some(conflict) = drawn.conflict() {
        return Err(keys(&conflict));
    }
    let mut shot = cycle_parameters(&drawn).map_err(|error| error.to_string())?;
    draw_law(&mut shot, design.wood.hardness_modulus, seed, candidate as u64);
    let fate = match simulate(&shot, settings) {
        Ok(record) => Fate::Shot {
            outcome: record.outcome,
            summary: Box::new(record.summary),
        },
        Err(CycleError::DryFire { .. }) => Fate::DryFire,
        Err(error) if is_failure(&error) => Fate::SolverFailure(error.to_string()),
        Err(error) => return Err(rule(&error).to_owned()),
    };
    Ok(Draw {
        candidate,
        values,
        fate,
    })
}

/// Draws the fitted law of a shot, if it has one, with the covariance of its coefficients and the scatter of specimens.
/// The law keeps `hardness_modulus` \[N/m\] of the design, because the scatter of specimens holds that of H_M.
pub fn draw_law(shot: &mut Parameters, hardness_modulus: f64, seed: u64, candidate: u64) {
    if let Some(law) = &mut shot.penetration_fit {
        let share = |place: usize| uniform(seed, candidate, hash("wood.penetration_fit").wrapping_add(place as u64));
        let normal: Vec<f64> = (0..law.draw_size())
            .map(|place| standard_normal(share(place)))
            .collect();
        *law = law.drawn(&normal, hardness_modulus);
    }
}

/// Whether the solver gave up, rather than the design being none.
fn is_failure(error: &CycleError) -> bool {
    matches!(
        error,
        CycleError::Integration { .. } | CycleError::Collapse { .. } | CycleError::Chatter { .. }
    )
}

fn keys(conflict: &Conflict) -> String {
    conflict.keys().join(", ")
}

/// The rule of the cycle that a candidate breaks.
fn rule(error: &CycleError) -> &'static str {
    match error {
        CycleError::ValveNotClosed { .. } => "the head valve does not close",
        CycleError::SpringRange { .. } => "the closing spring leaves its law",
        CycleError::LapOverlap { .. } => "intake and exhaust overlap",
        CycleError::DiameterOrder { .. } => "a diameter exceeds its outer one",
        _ => "another rule of the cycle",
    }
}
