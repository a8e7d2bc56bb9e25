//! Runs, cycles and modes of a design, and comparisons of runs.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use nailnoise::chain::{self, BodyStages, Chain, Options};
use nailnoise::comparison::{Comparison, Finished};
use nailnoise::cost::{self, MemoryLimit};
use nailnoise::design::inputs;
use nailnoise::graph::Graph;
use nailnoise::result::FiguresOfShot;
use nailnoise::stages::bodies::BodyKind;
use nailnoise::study::StudySource;
use nailnoise::{figures, output};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::design::{NativeDesign, store};
use crate::error::{json_of, raised, value_error};
use crate::values::{drawn, floats};
use crate::work;

/// Charts by name, as SVG.
type Charts = Vec<(String, String)>;

/// Runs a design; the text of `result.json`, the microphones' signals, and charts.
#[pyfunction]
pub(crate) fn run<'py>(
    py: Python<'py>,
    design: &NativeDesign,
    cache: Option<PathBuf>,
    keep: bool,
    report: Option<Py<PyAny>>,
) -> PyResult<(String, Bound<'py, PyDict>, Charts)> {
    let design = Arc::clone(&design.design);
    let (run, charts) = work::off_the_lock(py, report, move |observer| {
        cost::refuse(&design, &cost::of_run(&design)?, MemoryLimit::default())?;
        let store = store(cache, keep)?;
        let study = StudySource::find(&store, &design, false);
        let graph = Graph::new(Arc::new(store), observer);
        let mut run = Chain::new(&graph, &design, Options::default())?.run(&design)?;
        let study = study.of_run(&design, &run.result);
        run.result.state_study(study);
        let charts = drawn(&figures::sound(design.name(), &run));
        Ok((run, charts))
    })?;
    let signals = PyDict::new(py);
    for (source, microphones) in &run.microphones.signals {
        let arrays: Vec<Bound<'_, PyBytes>> = microphones.iter().map(|signal| floats(py, signal)).collect();
        signals.set_item(source, arrays)?;
    }
    Ok((json_of(&run.result)?, signals, charts))
}

/// Computes the nailing cycle; its figures as JSON, its histories by name with their units, and charts.
#[pyfunction]
pub(crate) fn cycle<'py>(
    py: Python<'py>,
    design: &NativeDesign,
    report: Option<Py<PyAny>>,
) -> PyResult<(String, Bound<'py, PyDict>, Charts)> {
    let design = Arc::clone(&design.design);
    let (shot, charts) = work::off_the_lock(py, report, move |_| {
        cost::refuse(&design, &[cost::of_cycle(&design)], MemoryLimit::default())?;
        let shot = chain::shot(&design)?;
        let charts = drawn(&figures::shot(design.name(), &design, &shot));
        Ok((shot, charts))
    })?;
    let histories = PyDict::new(py);
    let time: Vec<f64> = (0..shot.len()).map(|index| shot.time(index)).collect();
    histories.set_item("time", ("s", floats(py, &time)))?;
    for column in output::columns(&shot.record) {
        histories.set_item(column.name, (column.unit, floats(py, column.values)))?;
    }
    Ok((json_of(&FiguresOfShot::from(&shot))?, histories, charts))
}

/// Modes of a body (`workpiece`, `worktable` or `tool`): frequencies \[Hz\], which of them are rigid, loss factor, and
/// points and displacements at the nodes (row by row, three values a node, a mode after the other).
#[pyfunction]
pub(crate) fn modes<'py>(
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
    let surface = &body.surface;
    let faces = surface.faces.iter().flat_map(|face| {
        let corners = face.kind.corners();
        std::iter::once(corners).chain((0..corners).map(|corner| surface.volume_nodes[face.nodes[corner]]))
    });
    made.set_item("faces", faces.collect::<Vec<_>>())?;
    made.set_item("shapes", floats(py, &shapes.shapes.as_slice()[..values]))?;
    Ok(made)
}

/// Compares results, each the text of a `result.json`; the first is the reference.
#[pyfunction]
pub(crate) fn compare(results: Vec<String>) -> PyResult<String> {
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
