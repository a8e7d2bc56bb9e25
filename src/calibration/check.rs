//! Simulation-based calibration of a tool and its measurements: truths drawn from the ranges, with the observed
//! outcomes, are measured with the stated errors and calibrated. [`nailnoise_calibration::ranks`] explains the test.
//!
//! A run with a conflict or with diagnostics beyond their limits is counted separately: places are uniform given any
//! event that the readings decide. Finished runs are stored in files, so that an interrupted check can be resumed.

use std::fs;
use std::path::Path;
use std::time::Instant;

use nailnoise_acoustics::random::uniform;
use nailnoise_calibration::Simulator;
use nailnoise_calibration::likelihood::{Datum, Likelihood, Prediction};
use nailnoise_calibration::ranks::{place, uniformity};
use serde::{Deserialize, Serialize};

use super::error::CalibrationError;
use super::key::key;
use super::measurements::Measurements;
use super::posterior::{Calibration, Work};
use super::random::standard_normal;
use super::request::{Request, Treatment};
use super::result::result;
use super::tool::{Tool, likelihood};
use crate::atomic_write::AtomicWrite;
use crate::design::{Design, Values};
use crate::error::Error;
use crate::result::DesignId;
use crate::stages::Progress;
use crate::store::Store;
use crate::study::{Frame, Rejections};
use crate::wording::hexadecimal;

/// Name and version of the layout.
const SCHEMA: &str = "nailnoise-calibration-check/1";

/// Seeds of the truths, of their shared errors and independent errors, of the runs and of places between two draws.
const TRUTHS: u64 = 0x5EED_7A17_C001;
const SHARED: u64 = 0x5EED_7A17_C002;
const ERRORS: u64 = 0x5EED_7A17_C003;
const RUNS: u64 = 0x5EED_7A17_C004;
const PLACES: u64 = 0x5EED_7A17_C005;

/// Largest number of candidates for a truth.
const MOST_IN_VAIN: u64 = 1 << 16;

/// If the smallest probability of all tested quantities, times their number, is below this, the deviation is not due to
/// chance.
const BY_CHANCE: f64 = 0.01;

/// Work of a calibration, measured on the shipped design: candidates per draw if 6 % have the outcome, steps of the
/// sampler, and cycles per proposal. Most proposals are rejected after the first condition.
const CANDIDATES: f64 = 17.0;
const STEPS: f64 = 4.7;
const CYCLES: f64 = 1.35;

/// Kind of a checked quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CheckedKind {
    /// An input, or a shared error.
    Input,
    /// The value that a reading measures.
    Reading,
    /// A figure of the design's own shot.
    Figure,
}

/// Result of a check.
#[derive(Debug, Clone, Serialize)]
pub struct CheckResult {
    /// Name and version of the layout.
    pub schema: &'static str,
    /// The design.
    pub design: DesignId,
    /// The file of measurements.
    pub measured: String,
    /// Draws of each calibration.
    pub draws: usize,
    /// Most moves in a step.
    pub moves: usize,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Number of truths that were measured and calibrated.
    pub runs: usize,
    /// Runs that converged without a conflict, whose places are tested.
    pub counted: usize,
    /// Runs with diagnostics beyond their limits.
    pub not_converged: usize,
    /// Converged runs with a reading in conflict.
    pub in_conflict: usize,
    /// Share of all quantities within their 90 % intervals in the counted runs, and in those counted separately; null
    /// without such runs.
    pub within_90: [Option<f64>; 2],
    /// The quantities.
    pub quantities: Vec<CheckRow>,
    /// Number of quantities tested: figures, readings, and inputs that moved in half of the counted runs.
    pub tested: usize,
    /// Smallest probability of a tested quantity, times their number; null with fewer than 8 counted runs.
    pub least: Option<f64>,
    /// Whether no quantity deviates from uniform places by more than chance; null with fewer than 8 counted runs.
    pub is_uniform: Option<bool>,
    /// Work of all runs.
    pub work: Work,
    /// Notes for the reader.
    pub notes: Vec<String>,
}

/// A quantity in the counted runs.
#[derive(Debug, Clone, Serialize)]
pub struct CheckRow {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub kind: CheckedKind,
    /// Place of the truth among the draws of each counted run, 0 to 1; null where a shot does not have the quantity.
    pub places: Vec<Option<f64>>,
    /// Number of counted runs in which the input moved; for other quantities, all counted runs.
    pub moved: usize,
    /// Whether it is tested.
    pub tested: bool,
    /// Share of the truths within the 50 % and the 90 % interval.
    pub within: [f64; 2],
    /// A^2 of Anderson and Darling; null with fewer than 8 places.
    pub statistic: Option<f64>,
    /// Probability of at least this statistic for uniform places.
    pub p: Option<f64>,
}

/// Work ahead of a check, estimated.
#[derive(Debug, Clone, Copy)]
pub struct CheckCost {
    /// Nailing cycles.
    pub cycles: f64,
    /// Time on the threads in use \[s\].
    pub seconds: f64,
}

/// A finished run.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Run {
    /// Digest of everything that determines it.
    key: String,
    /// Faults of its diagnostics.
    faults: Vec<String>,
    /// Readings in conflict.
    conflicts: Vec<String>,
    /// Place of each quantity's truth.
    places: Vec<Option<f64>>,
    /// Inputs that moved, by their place among the quantities.
    moved: Vec<usize>,
    likelihoods: u64,
    cycles: u64,
    runs: u64,
}

/// A point of the prior with the observed outcomes, and its predictions in the order of the readings.
struct Truth {
    z: Vec<f64>,
    predictions: Vec<Prediction>,
}

impl Truth {
    /// The first point of a stream whose shots have the observed outcomes and a value for each reading that counts.
    /// `shared` is the seed of the shared errors.
    ///
    /// # Errors
    /// If there is none among the first points.
    fn draw(tool: &Tool, likelihood: &Likelihood, (stream, shared): (u64, u64)) -> Result<Self, CalibrationError> {
        let bases: Vec<Values> = tool.conditions.iter().map(|own| Values::clone(&own.design)).collect();
        let active = vec![true; tool.keys()];
        let frame = Frame::new(&bases, &active, stream);
        for index in 0..MOST_IN_VAIN {
            let Ok(point) = tool.sampler.point(frame, index, &mut Rejections::new()) else {
                continue;
            };
            let mut z = tool.sampler.to_normal(&point);
            z.extend((0..tool.shared.len() as u64).map(|k| standard_normal(shared, index, k)));
            if let Some(predictions) = predictions(tool, likelihood, &z) {
                return Ok(Self { z, predictions });
            }
        }
        Err(CalibrationError::NothingAccepted {
            candidates: MOST_IN_VAIN,
            outcomes: "another outcome, or without the event of a reading".to_owned(),
        })
    }
}

/// Predictions of a point with the observed outcomes and a value for each reading that counts.
fn predictions(tool: &Tool, likelihood: &Likelihood, z: &[f64]) -> Option<Vec<Prediction>> {
    let data = likelihood.data();
    let mut all = vec![Prediction::Missing; data.len()];
    for &condition in likelihood.order() {
        let own = tool.predict(z, condition).ok()?;
        likelihood
            .of_condition(condition)
            .zip(own)
            .for_each(|(k, own)| all[k] = own);
    }
    let is_value = |(own, datum): (&Prediction, &Datum)| !datum.counts || matches!(own, Prediction::Value(_));
    all.iter().zip(data).all(is_value).then_some(all)
}

/// A check of the measurements of a design.
pub(super) struct Check<'a> {
    pub(super) design: &'a Design,
    pub(super) measured: &'a Measurements,
    /// Name of the file of measurements.
    pub(super) file: String,
    /// Readings of the cycle that are only predicted.
    pub(super) held_out: Vec<usize>,
    pub(super) request: &'a Request,
    pub(super) store: &'a Store,
    pub(super) progress: &'a Progress,
}

impl Check<'_> {
    /// The work of `runs` runs, from the time of one shot under each condition.
    ///
    /// # Errors
    /// Those of the tool.
    pub(super) fn cost(&self, runs: usize) -> Result<CheckCost, Error> {
        let tool = Tool::new(self.design, self.measured, self.request.seed)?;
        let nominal = vec![0.0; tool.variables()];
        let begin = Instant::now();
        // Outcome and predictions do not matter here.
        (0..tool.conditions.len()).for_each(|condition| drop(tool.observe(&nominal, condition)));
        let a_cycle = begin.elapsed().as_secs_f64() / tool.conditions.len().max(1) as f64;
        let a_draw = CANDIDATES + STEPS * CYCLES * self.request.moves as f64 + 2.0;
        let cycles = (runs * self.request.draws) as f64 * a_draw;
        Ok(CheckCost {
            cycles,
            seconds: cycles * a_cycle / rayon::current_num_threads() as f64,
        })
    }

    /// Makes the runs that `folder` does not contain yet, and tests all of them.
    ///
    /// # Errors
    /// Those of a calibration, and of files.
    pub(super) fn run(&self, runs: usize, folder: &Path) -> Result<CheckResult, Error> {
        let tool = Tool::new(self.design, self.measured, self.request.seed ^ TRUTHS)?;
        let likelihood = likelihood(&tool, self.measured, &self.held_out, &Default::default())?;
        let names = self.names(&tool);
        let mut all = Vec::new();
        for number in 0..runs as u64 {
            all.push(self.single_run(&tool, &likelihood, number, folder)?);
            self.progress
                .note(&format!("check: run {} of {runs} is finished", number + 1));
        }
        Ok(self.evaluated(&names, &all))
    }

    /// Names and kinds of the quantities: columns of the table of a calibration's draws.
    fn names(&self, tool: &Tool) -> Vec<(String, CheckedKind)> {
        let inputs = (0..tool.variables()).map(|k| (tool.name(k).to_owned(), CheckedKind::Input));
        let readings = self.measured.data.iter();
        let readings = readings.map(|own| (own.name.clone(), CheckedKind::Reading));
        let figures = tool.figures.iter().map(|own| (own.name.clone(), CheckedKind::Figure));
        inputs.chain(readings).chain(figures).collect()
    }

    fn single_run(&self, tool: &Tool, likelihood: &Likelihood, number: u64, folder: &Path) -> Result<Run, Error> {
        let seed = self.request.seed;
        let mut measured = self.measured.clone();
        // Levels belong to the second stage, which is not checked.
        measured.levels.clear();
        let request = Request {
            seed: uniform(seed ^ RUNS, number, 0).to_bits(),
            treatment: Treatment::LeaveOut,
            next: false,
            ..self.request.clone()
        };
        let own = Tool::new(self.design, &measured, request.seed)?;
        // Number and seed determine the truth and its readings.
        let digest = key(self.design, &own, &measured, (request.draws, request.seed))
            .with(&self.held_out)
            .with(&request.moves)
            .with(&seed)
            .with(&number)
            .digest();
        let digest = hexadecimal(&digest);
        let name = format!("run-{:04}.json", number + 1);
        if let Some(run) = finished(&folder.join(&name), &digest) {
            return Ok(run);
        }
        let truth = Truth::draw(
            tool,
            likelihood,
            (1 + number, uniform(seed ^ SHARED, number, 0).to_bits()),
        )?;
        let error = |k: usize| uniform(seed ^ ERRORS, number, k as u64).clamp(f64::EPSILON, 1.0 - f64::EPSILON);
        let shares: Vec<f64> = (0..truth.predictions.len()).map(error).collect();
        let readings = likelihood.measured(&truth.z, &truth.predictions, &shares);
        for (own, reading) in measured.data.iter_mut().zip(readings) {
            own.reading = reading;
        }
        let key = key(self.design, &own, &measured, (request.draws, request.seed));
        let calibration = Calibration {
            tool: own,
            measured: &measured,
            request: &request,
            store: self.store,
            key,
            workers: None,
            progress: self.progress,
        };
        let posterior = calibration.posterior(self.held_out.clone())?;
        let (found, table) = result(&posterior, self.design, &measured, &request, &self.file);
        let figures = posterior
            .tool
            .figures_at(self.design, std::iter::once(truth.z.as_slice()));
        let values = (0..posterior.tool.variables()).map(|k| posterior.tool.value(k, &truth.z));
        let values = values.chain(truth.predictions.iter().map(|own| own.value()));
        let values: Vec<f64> = values.chain(figures.into_iter().flatten()).collect();
        let place_of = |(k, value): (usize, &f64)| {
            let share = uniform(seed ^ PLACES, number, k as u64);
            place(*value, table.rows.iter().map(|row| row[k]), share)
        };
        let moved = |k: &usize| {
            let name = posterior.tool.name(*k);
            let row = found.inputs.iter().find(|own| own.name == name);
            row.is_some_and(|own| own.ratio < found.moved_below)
        };
        let run = Run {
            key: digest,
            places: values.iter().enumerate().map(place_of).collect(),
            moved: (0..posterior.tool.variables()).filter(moved).collect(),
            faults: found.faults,
            conflicts: found.conflicts.into_iter().map(|own| own.measurement).collect(),
            likelihoods: found.work.likelihoods,
            cycles: found.work.cycles,
            runs: found.work.runs,
        };
        let staging = AtomicWrite::within(folder)?;
        let json = serde_json::to_string(&run).map_err(Error::Json)? + "\n";
        staging.write(name.as_ref(), json.as_bytes())?;
        staging.place(&[], name.as_ref())?;
        Ok(run)
    }

    fn evaluated(&self, names: &[(String, CheckedKind)], all: &[Run]) -> CheckResult {
        let (sound, flagged): (Vec<&Run>, Vec<&Run>) = all.iter().partition(|own| own.faults.is_empty());
        let (counted, in_conflict): (Vec<&Run>, Vec<&Run>) =
            sound.into_iter().partition(|own| own.conflicts.is_empty());
        let apart: Vec<&Run> = flagged.iter().chain(&in_conflict).copied().collect();
        let quantities: Vec<CheckRow> = (0..names.len()).map(|k| row(k, &names[k], &counted)).collect();
        let tested: Vec<&CheckRow> = quantities.iter().filter(|own| own.tested).collect();
        let least = tested.iter().filter_map(|own| own.p).reduce(f64::min);
        let least = least.map(|p| (p * tested.len() as f64).min(1.0));
        let sum = |of: fn(&Run) -> u64| all.iter().map(of).sum();
        CheckResult {
            schema: SCHEMA,
            design: DesignId::from(self.design),
            measured: self.file.clone(),
            draws: self.request.draws,
            moves: self.request.moves,
            seed: self.request.seed,
            runs: all.len(),
            counted: counted.len(),
            not_converged: flagged.len(),
            in_conflict: in_conflict.len(),
            within_90: [&counted, &apart].map(|runs| {
                let places = runs.iter().flat_map(|own| own.places.iter().copied().flatten());
                share_within(&places.collect::<Vec<f64>>(), 0.9)
            }),
            tested: tested.len(),
            least,
            is_uniform: least.map(|least| least >= BY_CHANCE),
            quantities,
            work: Work {
                runs: sum(|own| own.runs),
                likelihoods: sum(|own| own.likelihoods),
                cycles: sum(|own| own.cycles),
            },
            notes: self.notes(),
        }
    }

    fn notes(&self) -> Vec<String> {
        let mut notes = vec![
            "truths are drawn from the ranges, with the outcomes that were noted and the events that readings need; \
             errors are those of the likelihood, at the sizes that the file states for its own values"
                .to_owned(),
        ];
        if !self.measured.levels.is_empty() {
            notes.push("levels and accelerations are left out: the check is of the nailing cycle".to_owned());
        }
        notes
    }
}

/// A finished run in a file, if it is the one with this digest.
fn finished(file: &Path, digest: &str) -> Option<Run> {
    let run: Run = serde_json::from_slice(&fs::read(file).ok()?).ok()?;
    (run.key == digest).then_some(run)
}

fn row(k: usize, (name, kind): &(String, CheckedKind), counted: &[&Run]) -> CheckRow {
    let places: Vec<Option<f64>> = counted.iter().map(|own| own.places.get(k).copied().flatten()).collect();
    let known: Vec<f64> = places.iter().copied().flatten().collect();
    let moved = match kind {
        CheckedKind::Input => counted.iter().filter(|own| own.moved.contains(&k)).count(),
        CheckedKind::Reading | CheckedKind::Figure => counted.len(),
    };
    let found = uniformity(&known);
    let within = |part: f64| share_within(&known, part).unwrap_or(f64::NAN);
    CheckRow {
        name: name.clone(),
        kind: *kind,
        moved,
        tested: 2 * moved >= counted.len() && found.is_some(),
        within: [within(0.5), within(0.9)],
        statistic: found.map(|own| own.statistic),
        p: found.map(|own| own.p),
        places,
    }
}

/// Share of places within the central interval that has this part of a uniform distribution; none without places.
fn share_within(places: &[f64], part: f64) -> Option<f64> {
    let ends = 0.5 * (1.0 - part)..=0.5 * (1.0 + part);
    let within = places.iter().filter(|own| ends.contains(*own)).count();
    (!places.is_empty()).then(|| within as f64 / places.len() as f64)
}
