//! Calibration of a design with measurements.

use std::path::PathBuf;
use std::sync::Arc;

use nailnoise::calibration::{self, Redrawn, Request, Treatment, Worker, Workers};
use nailnoise::figures;
use nailnoise::stages::Progress;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::design::{NativeDesign, parsed, store, unbounded};
use crate::error::{json_of, value_error};
use crate::values::drawn;
use crate::work::{self, Callbacks};

/// Fewest draws, as in the command.
const FEWEST: u32 = 64;

/// Words for the treatment of measurements that contradict each other.
const TREATMENTS: [(&str, Treatment); 2] = [("leave-out", Treatment::LeaveOut), ("widen", Treatment::Widen)];

/// The text of `calibration.json`, `posterior.csv`, `calibrated.toml` and `calibrated.draws`, and charts as names and
/// SVG.
type CalibrationFiles = (String, String, String, String, Vec<(String, String)>);

/// A calibration in a process that computes tasks for another one.
#[pyclass(frozen, name = "CalibrationWorker", module = "nailnoise._native")]
pub(crate) struct NativeWorker {
    worker: Arc<Worker>,
}

#[pymethods]
impl NativeWorker {
    #[new]
    fn new(py: Python<'_>, design: &NativeDesign, measured: PathBuf, draws: usize, seed: u64) -> PyResult<Self> {
        let (design, assignments) = (Arc::clone(&design.design), parsed(&design.assignments)?);
        let of = (even(draws), seed);
        let make = move |_| Ok(Worker::new(&design, &assignments, &measured, of)?);
        Ok(Self {
            worker: Arc::new(work::off_the_lock(py, None, make)?),
        })
    }

    /// The result of a task.
    fn result<'py>(&self, py: Python<'py>, task: Vec<u8>) -> PyResult<Bound<'py, PyBytes>> {
        let worker = Arc::clone(&self.worker);
        let result = work::off_the_lock(py, None, move |_| Ok(worker.result(&task)?))?;
        Ok(PyBytes::new(py, &result))
    }
}

/// The files that a file of measurements names, and that file itself.
#[pyfunction]
pub(crate) fn measurement_files(py: Python<'_>, design: &NativeDesign, measured: PathBuf) -> PyResult<Vec<PathBuf>> {
    let (design, assignments) = (Arc::clone(&design.design), parsed(&design.assignments)?);
    work::off_the_lock(py, None, move |_| {
        Ok(calibration::files_of(&design, &assignments, &measured)?)
    })
}

/// Number of draws in two halves of equal size.
fn even(draws: usize) -> usize {
    draws.next_multiple_of(2)
}

/// Conditions the ranges of a design on the measurements in a file. `folder` is where the calibrated design will be.
/// `tasks` computes the shots on `workers` workers.
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
    tasks: Option<Py<PyAny>>,
    workers: usize,
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
        draws: even(draws as usize),
        moves: usize::from(moves.max(1)),
        seed,
        hold_out,
        treatment,
        next,
        levels: levels as usize,
        redraw,
    };
    let (design, assignments) = (Arc::clone(&design.design), parsed(&design.assignments)?);
    let callbacks = Callbacks { report, tasks };
    let made = work::with_workers(py, callbacks, workers, move |observer, workers| {
        let store = match shared.as_deref() {
            Some(folder) => unbounded(folder)?,
            None => store(cache, keep)?,
        };
        let progress = Progress::to(observer);
        let measured = measured.as_deref();
        let workers = workers.as_ref().map(|own| own as &dyn Workers);
        let (result, files) =
            calibration::calibrate(&store, &design, &assignments, measured, (&request, workers), &progress)?;
        let charts = drawn(&figures::calibration(&result));
        Ok((result, files.design(&folder), files.draws, files.joint, charts))
    })?;
    let (result, toml, table, joint, charts) = made;
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    Ok((json_of(&result)?, text(table), toml, text(joint), charts))
}
