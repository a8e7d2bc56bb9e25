//! Calibration of a design with measurements.

use std::path::PathBuf;
use std::sync::Arc;

use nailnoise::calibration::{self, Redrawn, Request, Treatment};
use nailnoise::figures;
use nailnoise::stages::Progress;
use pyo3::prelude::*;

use crate::design::{NativeDesign, parsed, store, unbounded};
use crate::error::{json_of, value_error};
use crate::values::drawn;
use crate::work;

/// Fewest draws, as in the command.
const FEWEST: u32 = 64;

/// Words for the treatment of measurements that contradict each other.
const TREATMENTS: [(&str, Treatment); 2] = [("leave-out", Treatment::LeaveOut), ("widen", Treatment::Widen)];

/// The text of `calibration.json`, `posterior.csv`, `calibrated.toml` and `calibrated.draws`, and charts as names and
/// SVG.
type CalibrationFiles = (String, String, String, String, Vec<(String, String)>);

/// Conditions the ranges of a design on the measurements in a file. `folder` is where the calibrated design will be.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // they are those of the Python function
pub(crate) fn calibrate(
    py: Python<'_>,
    design: &NativeDesign,
    measured: Option<PathBuf>,
    draws: u32,
    moves: u16,
    seed: u64,
    hold_out: Vec<String>,
    conflict: &str,
    next: bool,
    levels: u32,
    redraw: Vec<String>,
    folder: PathBuf,
    cache: Option<PathBuf>,
    keep: bool,
    shared: Option<PathBuf>,
    report: Option<Py<PyAny>>,
) -> PyResult<CalibrationFiles> {
    if draws < FEWEST {
        return Err(value_error(format!("a calibration needs {FEWEST} draws or more")));
    }
    if measured.is_none() && !next {
        return Err(value_error(
            "give a file of measurements, or next=True to rank what to measure first",
        ));
    }
    let treatment = TREATMENTS
        .iter()
        .find(|(name, _)| *name == conflict)
        .map(|(_, own)| *own);
    let treatment = treatment.ok_or_else(|| value_error("conflict is \"leave-out\" or \"widen\""))?;
    let redrawn = |name: &String| {
        let class = Redrawn::ALL.into_iter().find(|(own, _)| own == name);
        class.map(|(_, class)| class)
    };
    let redraw: Option<Vec<Redrawn>> = redraw.iter().map(redrawn).collect();
    let redraw = redraw.ok_or_else(|| value_error("redraw is a list of \"board\", \"nails\" and \"support\""))?;
    let request = Request {
        draws: draws.next_multiple_of(2) as usize,
        moves: usize::from(moves.max(1)),
        seed,
        hold_out,
        treatment,
        next,
        levels: levels as usize,
        redraw,
    };
    let (design, assignments) = (Arc::clone(&design.design), parsed(&design.assignments)?);
    let made = work::off_the_lock(py, report, move |observer| {
        let store = match shared.as_deref() {
            Some(folder) => unbounded(folder)?,
            None => store(cache, keep)?,
        };
        let progress = Progress::to(observer);
        let measured = measured.as_deref();
        let (result, files) = calibration::calibrate(&store, &design, &assignments, measured, &request, &progress)?;
        let charts = drawn(&figures::calibration(&result));
        Ok((result, files.design(&folder), files.draws, files.joint, charts))
    })?;
    let (result, toml, table, joint, charts) = made;
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    Ok((json_of(&result)?, text(table), toml, text(joint), charts))
}
