//! Calibration: conditions the ranges of a design on the user's measurements of the tool.
//!
//! The crate `nailnoise-calibration` does the sampling; this module contains the measurement file, the quantities of
//! the cycle, the tool as a simulator, the levels that weight its draws, and the result with its files.

mod assembly_quantities;
mod check;
mod error;
mod fields;
mod figures;
mod files;
mod history;
mod inputs;
mod joint;
mod key;
mod level_bands;
mod level_draws;
mod level_file;
mod level_quantities;
mod level_reader;
mod level_rows;
mod levels;
mod measurements;
mod next;
mod posterior;
mod quantities;
mod quantity_reader;
mod random;
mod reader;
mod redraw;
mod request;
mod result;
mod shot;
mod shown;
mod spread;
mod start;
mod structures;
mod tasks;
mod toml_line;
mod tool;
mod trace;

use std::path::Path;

pub use check::{CheckCost, CheckResult, CheckRow, CheckedKind};
pub use error::CalibrationError;
pub use files::{Files, JOINT};
pub use levels::{LevelRow, LevelWork};
pub use next::{NextRow, next_of_study};
pub use posterior::Work;
pub use redraw::Redrawn;
pub use request::{Request, Treatment};
pub use result::{
    CalibrationResult, ConflictRow, FigureRow, InputRow, MeasurementRow, NOT_CONVERGED, PairRow, Verdict,
};
pub use structures::{
    ModeRow, PeakRow, PlateInput, PlateResult, StructuresRequest, StructuresResult, calibrate_structures,
};
pub use tasks::{Worker, Workers, files_of};

use inputs::Inputs;

use crate::design::{Assignment, Design};
use crate::error::Error;
use crate::graph::Graph;
use crate::stages::Progress;
use crate::store::Store;

/// Calibrates the design in a file, with further assignments, using the measurements in another file. Without
/// measurements the draws are those of the ranges.
///
/// Completed blocks of candidates and completed moves of the sampler are stored, so that repeating the call resumes an
/// interrupted one. `workers` compute their shots; without them, the threads of this process do.
///
/// # Errors
/// The first fault in the design or the measurements, with its place; or if no candidate has the observed outcomes.
pub fn calibrate(
    store: &Store,
    design: &Design,
    assignments: &[Assignment],
    measured: Option<&Path>,
    (request, workers): (&Request, Option<&dyn Workers>),
    progress: &Progress,
) -> Result<(CalibrationResult, Files), Error> {
    let Inputs {
        design: narrowed,
        file,
        measured,
        held_out,
        held_levels,
    } = Inputs::read(design, assignments, measured, request)?;
    let tool = tool::Tool::new(&narrowed, &measured, request.seed)?;
    let key = key::key(&narrowed, &tool, &measured, (request.draws, request.seed));
    let calibration = posterior::Calibration {
        tool,
        measured: &measured,
        request,
        store,
        key,
        workers,
        progress,
    };
    let mut posterior = calibration.posterior(held_out)?;
    let graph = Graph::quiet(store, progress.observer());
    let levels = if measured.levels.is_empty() {
        None
    } else {
        let stage = levels::LevelStage {
            design: &narrowed,
            measured: &measured,
            request,
            graph: &graph,
            progress,
            joint: joint::joint(&posterior, None, &file),
        };
        let weighted = stage.weighted(&posterior, &held_levels)?;
        Some(levels::ByLevels::of(weighted, &mut posterior, request.seed))
    };
    progress.stage("figures of the draws");
    let (mut result, mut table) = result::result(&posterior, &narrowed, &measured, request, &file);
    let joint = joint::joint(&posterior, levels.as_ref(), &file);
    if let Some(levels) = &levels {
        let ranges = level_rows::ranges(store, design)?;
        level_rows::add(levels, (&measured, &ranges), &mut result, &mut table);
    }
    if request.next {
        let levelled = next::Levelled {
            tool: &posterior.tool,
            design: &narrowed,
            joint: joint.clone(),
            effort: &measured.effort,
            points: posterior.state.particles.iter().map(|own| own.z.as_slice()).collect(),
        };
        result.next = levelled.next(&graph, request.levels, request.seed, progress)?;
    }
    let pairs = result.pairs.iter().map(|own| (&own.inputs, own.rank_correlation));
    let note = redraw::note(&request.redraw, pairs);
    result.notes.extend(note);
    let files = files::files(
        &posterior,
        &narrowed,
        &result,
        (&table, &joint),
        (&measured.narrowed, &request.redraw),
    )?;
    Ok((result, files))
}

/// A check of a calibration.
#[derive(Debug, Clone, Copy)]
pub struct CheckRequest<'a> {
    /// File of measurements.
    pub measured: &'a Path,
    /// Settings of each calibration.
    pub request: &'a Request,
    /// Number of truths from the ranges that are measured and calibrated.
    pub runs: usize,
    /// Folder of the finished runs; repeating a check that was interrupted continues with them.
    pub folder: &'a Path,
}

/// Checks a calibration, see [`CheckResult`]. `before` receives the estimated work.
///
/// # Errors
/// Those of [`calibrate`], and of the files in the folder.
pub fn check(
    store: &Store,
    design: &Design,
    assignments: &[Assignment],
    asked: CheckRequest<'_>,
    progress: &Progress,
    before: impl FnOnce(CheckCost),
) -> Result<CheckResult, Error> {
    let read = Inputs::read(design, assignments, Some(asked.measured), asked.request)?;
    let check = check::Check {
        design: &read.design,
        measured: &read.measured,
        file: read.file,
        held_out: read.held_out,
        request: asked.request,
        store,
        progress,
    };
    before(check.cost(asked.runs)?);
    check.run(asked.runs, asked.folder)
}
