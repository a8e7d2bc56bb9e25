//! The native module of the Python package `nailnoise`: what `python/nailnoise/__init__.py` builds its classes on.
//!
//! Results cross as JSON text, tables as CSV text and histories as bytes of 64-bit floats, so that the module needs neither the C
//! interface of NumPy nor a second layout of any result. Work runs on a thread of its own without the interpreter's lock.

mod error;
mod work;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use nailnoise::chain::{self, BodyStages, Chain, Options};
use nailnoise::comparison::{Comparison, Finished};
use nailnoise::cost::{self, MemoryLimit};
use nailnoise::design::{Assignment, Design, inputs};
use nailnoise::graph::Graph;
use nailnoise::stages::bodies::BodyKind;
use nailnoise::stages::{Observer, Progress, WithoutStages};
use nailnoise::store::{LIMIT, Store};
use nailnoise::study::{self, Axis, Part, Request, StudyResult};
use nailnoise::{Error, output};
use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::{Boundary, BoundaryMesh, Exterior, Panel};
use nailnoise_dynamics::{EnergyFlow, Events, LogEntry, Outcome, Summary};
use nailnoise_meshes::FaceKind;
use nalgebra::{DMatrix, Point3};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use serde::Serialize;

use error::{Refused, json_of, raised, value_error};

/// A design file with the values set over it.
#[pyclass(frozen, name = "Design", module = "nailnoise._native")]
struct NativeDesign {
    design: Arc<Design>,
    assignments: Vec<String>,
}

/// Assignments `key=value`.
fn parsed(assignments: &[String]) -> PyResult<Vec<Assignment>> {
    assignments
        .iter()
        .map(|text| text.parse().map_err(value_error))
        .collect()
}

#[pymethods]
impl NativeDesign {
    /// Reads a design file with assignments `key=value` over it.
    #[staticmethod]
    fn load(path: PathBuf, assignments: Vec<String>) -> PyResult<Self> {
        let design = Design::load_with(&path, &parsed(&assignments)?).map_err(|error| raised(error.into()))?;
        Ok(Self {
            design: Arc::new(design),
            assignments,
        })
    }

    /// The same file with more assignments.
    fn with_assignments(&self, more: Vec<String>) -> PyResult<Self> {
        Self::load(self.design.path().to_owned(), [&self.assignments[..], &more].concat())
    }

    #[getter]
    fn name(&self) -> &str {
        self.design.name()
    }

    #[getter]
    fn digest(&self) -> String {
        self.design.digest()
    }

    #[getter]
    fn path(&self) -> PathBuf {
        self.design.path().to_owned()
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.design.warnings().iter().map(ToString::to_string).collect()
    }

    /// All values with units, ranges and sources, as JSON.
    fn entries(&self) -> PyResult<String> {
        json_of(&self.design.entries())
    }
}

/// Where results are kept: the folder given, the user's cache, or nowhere.
fn store(cache: Option<PathBuf>, keep: bool) -> Result<Store, Error> {
    Ok(match cache {
        _ if !keep => Store::none(),
        Some(folder) => Store::at(folder, LIMIT),
        None => Store::of_user()?,
    })
}

/// Runs a design; the text of `result.json` and the microphones' signals.
#[pyfunction]
fn run<'py>(
    py: Python<'py>,
    design: &NativeDesign,
    cache: Option<PathBuf>,
    keep: bool,
    report: Option<Py<PyAny>>,
) -> PyResult<(String, Bound<'py, PyDict>)> {
    let design = Arc::clone(&design.design);
    let run = work::off_the_lock(py, report, move |observer| {
        cost::refuse(&design, &cost::of_run(&design)?, MemoryLimit::default())?;
        let graph = Graph::new(Arc::new(store(cache, keep)?), observer);
        Ok(Chain::new(&graph, &design, Options::default())?.run(&design)?)
    })?;
    let signals = PyDict::new(py);
    for (source, microphones) in &run.microphones.signals {
        let arrays: Vec<Bound<'_, PyBytes>> = microphones.iter().map(|signal| floats(py, signal)).collect();
        signals.set_item(source, arrays)?;
    }
    Ok((json_of(&run.result)?, signals))
}

/// Computes the nailing cycle; its figures as JSON, and its histories by name with their units.
#[pyfunction]
fn cycle<'py>(
    py: Python<'py>,
    design: &NativeDesign,
    report: Option<Py<PyAny>>,
) -> PyResult<(String, Bound<'py, PyDict>)> {
    let design = Arc::clone(&design.design);
    let record = work::off_the_lock(py, report, move |_| {
        cost::refuse(&design, &[cost::of_cycle(&design)], MemoryLimit::default())?;
        Ok(chain::cycle(&design)?)
    })?;
    let histories = PyDict::new(py);
    let time: Vec<f64> = (0..record.len()).map(|index| record.time(index)).collect();
    histories.set_item("time", ("s", floats(py, &time)))?;
    for column in output::columns(&record) {
        histories.set_item(column.name, (column.unit, floats(py, column.values)))?;
    }
    let figures = CycleFigures {
        outcome: record.outcome,
        events: &record.events,
        summary: &record.summary,
        energy: &record.energy,
        log: &record.log,
        checks: &record.checks,
    };
    Ok((json_of(&figures)?, histories))
}

/// A cycle without its histories, as `nailnoise cycle --json` has it.
#[derive(Serialize)]
struct CycleFigures<'a> {
    outcome: Outcome,
    events: &'a Events,
    summary: &'a Summary,
    energy: &'a EnergyFlow,
    log: &'a [LogEntry],
    checks: &'a [nailnoise::result::Check],
}

/// Modes of a body (`workpiece`, `worktable` or `tool`): frequencies \[Hz\], which of them are rigid, loss factor, and points and
/// displacements at the nodes (row by row, three values a node, a mode after the other).
#[pyfunction]
fn modes<'py>(
    py: Python<'py>,
    design: &NativeDesign,
    body: &str,
    cache: Option<PathBuf>,
    keep: bool,
    report: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let kinds = [BodyKind::Workpiece, BodyKind::Worktable, BodyKind::Tool];
    let kind = kinds.into_iter().find(|kind| kind.name() == body);
    let kind =
        kind.ok_or_else(|| value_error(format!("there is no body `{body}`; give workpiece, worktable or tool")))?;
    let design = Arc::clone(&design.design);
    let (body, shapes, loss_factor) = work::off_the_lock(py, report, move |observer| {
        cost::refuse(&design, &[cost::of_body(&design, kind)?], MemoryLimit::default())?;
        let graph = Graph::new(Arc::new(store(cache, keep)?), observer);
        let whole = || {
            let stages = BodyStages::add(&graph, &design, kind, false)?;
            Ok((stages.body.get()?, stages.modes.get()?, stages.loss_factor))
        };
        Ok(whole().map_err(|error| inputs::located(&design, error))?)
    })?;
    let made = PyDict::new(py);
    made.set_item("hz", floats(py, body.basis.hz.as_slice()))?;
    made.set_item("rigid", body.basis.rigid.clone())?;
    made.set_item("loss_factor", loss_factor)?;
    made.set_item("modes_there_are", body.basis.sturm.count)?;
    let points: Vec<f64> = body
        .mesh
        .nodes
        .iter()
        .flat_map(|point| [point.x, point.y, point.z])
        .collect();
    made.set_item("points", floats(py, &points))?;
    let values = shapes.shapes.nrows() * body.basis.hz.len();
    made.set_item("shapes", floats(py, &shapes.shapes.as_slice()[..values]))?;
    Ok(made)
}

/// Compares results, each the text of a `result.json`; the first is the reference.
#[pyfunction]
fn compare(results: Vec<String>) -> PyResult<String> {
    let mut finished: Vec<Finished> = Vec::with_capacity(results.len());
    for (place, text) in results.iter().enumerate() {
        let mut own = Finished::parse(Path::new("result.json"), text).map_err(raised)?;
        if finished.iter().any(|other| other.name() == own.name()) {
            own.rename(format!("{} ({})", own.name(), place + 1));
        }
        finished.push(own);
    }
    json_of(&Comparison::new(&finished))
}

/// What a study is asked for.
fn request(draws: u32, seed: u64, structures: Option<u16>, task: Option<(u32, u32)>) -> PyResult<Request> {
    if draws == 0 {
        return Err(value_error("a study needs at least one draw"));
    }
    let part = match task {
        None => Part::All,
        Some((number, of)) if (1..=of).contains(&number) => Part::Task { number, of },
        Some((number, of)) => {
            return Err(value_error(format!(
                "there is no task {number} of {of}; the first is 1"
            )));
        }
    };
    Ok(Request {
        draws: draws as usize,
        seed,
        shots_a_structure: structures.filter(|each| *each > 0).map(usize::from),
        part,
        workpiece_sensors: false,
    })
}

/// Draws designs from the ranges; the text of `study.json` and of `draws.csv`. Draws that tasks have left in `folder` are read
/// from there, and those that are missing are computed into it.
#[pyfunction(name = "study")]
#[allow(clippy::too_many_arguments)] // they are those of the Python function
fn study_of(
    py: Python<'_>,
    design: &NativeDesign,
    draws: u32,
    seed: u64,
    structures: Option<u16>,
    cache: Option<PathBuf>,
    keep: bool,
    folder: Option<PathBuf>,
    report: Option<Py<PyAny>>,
) -> PyResult<(String, String)> {
    let (design, request) = (Arc::clone(&design.design), request(draws, seed, structures, None)?);
    let (result, table) = work::off_the_lock(py, report, move |observer| {
        cost::refuse(&design, &cost::of_run(&design)?, MemoryLimit::default())?;
        let cache = store(cache, keep)?;
        let shared = folder.map(|folder| Store::at(folder, u64::MAX));
        let progress = Progress::to(Arc::clone(&observer));
        let graph = quiet(shared.as_ref().unwrap_or(&cache), observer);
        let made = study::draws(&graph, &design, &request, &progress)?;
        let nominal = study::nominal(&graph, &design, &request)?;
        let result = StudyResult::new(&design, &request, &made, nominal.as_deref());
        study::keep(&cache, &design, &result)?;
        Ok((result, study::csv(&made)?))
    })?;
    Ok((json_of(&result)?, String::from_utf8_lossy(&table).into_owned()))
}

/// Computes a task of a study into a folder; how many draws it made. For schedulers: tasks share the folder and need no order.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // they are those of the Python function
fn study_task(
    py: Python<'_>,
    design: &NativeDesign,
    draws: u32,
    seed: u64,
    structures: Option<u16>,
    task: (u32, u32),
    folder: PathBuf,
    report: Option<Py<PyAny>>,
) -> PyResult<usize> {
    let (design, request) = (
        Arc::clone(&design.design),
        request(draws, seed, structures, Some(task))?,
    );
    let made = work::off_the_lock(py, report, move |observer| {
        cost::refuse(&design, &cost::of_run(&design)?, MemoryLimit::default())?;
        let progress = Progress::to(Arc::clone(&observer));
        let graph = quiet(&Store::at(folder, u64::MAX), observer);
        Ok(study::draws(&graph, &design, &request, &progress)?)
    })?;
    Ok(made.draws.len())
}

/// Levels over a grid of values, as JSON.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // they are those of the Python function
fn sweep(
    py: Python<'_>,
    design: &NativeDesign,
    vary: Vec<String>,
    draws: Option<u32>,
    seed: u64,
    cache: Option<PathBuf>,
    keep: bool,
    report: Option<Py<PyAny>>,
) -> PyResult<String> {
    let axes = vary
        .iter()
        .map(|text| text.parse::<Axis>().map_err(value_error))
        .collect::<PyResult<Vec<Axis>>>()?;
    let request = draws.map(|draws| request(draws, seed, None, None)).transpose()?;
    let (design, assignments) = (Arc::clone(&design.design), parsed(&design.assignments)?);
    let points = work::off_the_lock(py, report, move |observer| {
        let progress = Progress::to(Arc::clone(&observer));
        let graph = quiet(&store(cache, keep)?, observer);
        let base = (design.path(), &assignments[..]);
        let limit = MemoryLimit::default();
        Ok(study::sweep(&graph, base, &axes, request.as_ref(), limit, &progress)?)
    })?;
    json_of(&points)
}

/// Power \[W\] that a closed surface of triangles radiates into free air at 20 degC and 101 325 Pa: points \[m\], triangles (their
/// corners counter-clockwise from outside), a normal velocity for each point \[m/s, rms\], and the frequency \[Hz\].
#[pyfunction]
fn radiated_power(
    py: Python<'_>,
    points: Vec<[f64; 3]>,
    triangles: Vec<[usize; 3]>,
    velocity: Vec<f64>,
    hz: f64,
) -> PyResult<f64> {
    work::off_the_lock(py, None, move |_| {
        let outside = triangles.iter().flatten().any(|node| *node >= points.len());
        if outside || velocity.len() != points.len() || !(hz.is_finite() && hz > 0.0) {
            return Err(Refused::Value(
                "triangles index points, there is a velocity for each point, and the frequency is above 0".to_owned(),
            ));
        }
        let panels = triangles
            .iter()
            .filter_map(|nodes| Panel::new(FaceKind::Tri3, nodes, 0))
            .collect();
        let mesh = BoundaryMesh {
            points: points.into_iter().map(Point3::from).collect(),
            panels,
            patches: vec!["surface".to_owned()],
        };
        let wrong = |error: &dyn std::fmt::Display| Refused::Value(error.to_string());
        let boundary = Boundary::new(mesh, None).map_err(|error| wrong(&error))?;
        let exterior = Exterior::new(boundary, &Air::default());
        if exterior.boundary().velocity_values() != 3 * triangles.len() {
            return Err(Refused::Value("the surface has triangles without area".to_owned()));
        }
        let of_corners = triangles.iter().flatten().map(|node| velocity[*node]);
        let pattern = DMatrix::from_iterator(3 * triangles.len(), 1, of_corners);
        let resistance = exterior.resistance(hz, &pattern).map_err(|error| wrong(&error))?;
        Ok(resistance.far_field[(0, 0)])
    })
}

/// A graph that does not report the stages of each of many shots.
fn quiet(store: &Store, observer: Arc<dyn Observer>) -> Graph {
    Graph::new(Arc::new(store.clone()), Arc::new(WithoutStages(observer)))
}

/// Numbers as bytes, in the order of the machine.
fn floats<'py>(py: Python<'py>, values: &[f64]) -> Bound<'py, PyBytes> {
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_ne_bytes()).collect();
    PyBytes::new(py, &bytes)
}

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("NailnoiseError", module.py().get_type::<error::NailnoiseError>())?;
    module.add_class::<NativeDesign>()?;
    module.add_function(wrap_pyfunction!(run, module)?)?;
    module.add_function(wrap_pyfunction!(cycle, module)?)?;
    module.add_function(wrap_pyfunction!(modes, module)?)?;
    module.add_function(wrap_pyfunction!(compare, module)?)?;
    module.add_function(wrap_pyfunction!(study_of, module)?)?;
    module.add_function(wrap_pyfunction!(study_task, module)?)?;
    module.add_function(wrap_pyfunction!(sweep, module)?)?;
    module.add_function(wrap_pyfunction!(radiated_power, module)?)
}
