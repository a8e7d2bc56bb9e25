//! Studies, sweeps and draws of shots.

use std::path::PathBuf;
use std::sync::Arc;

use nailnoise::chain;
use nailnoise::cost::{self, MemoryLimit};
use nailnoise::figures;
use nailnoise::graph::Graph;
use nailnoise::headline;
use nailnoise::stages::Progress;
use nailnoise::study::{self, Axis, PairedStudy, Request, StudyResult, Subset};
use nailnoise::{Design, Error};
use pyo3::prelude::*;

use crate::design::{NativeDesign, parsed, store, unbounded};
use crate::error::{json_of, value_error};
use crate::values::drawn;
use crate::work;

/// The request for a study.
pub(crate) fn request(draws: u32, seed: u64, structures: Option<u16>, part: Subset) -> PyResult<Request> {
    if draws == 0 {
        return Err(value_error("a study needs at least one draw"));
    }
    Ok(Request {
        shots_a_structure: structures.filter(|each| *each > 0).map(usize::from),
        part,
        ..Request::new(draws as usize, seed)
    })
}

/// The text of `study.json` and of `draws.csv`, and charts as names and SVG.
type StudyFiles = (String, String, Vec<(String, String)>);

/// Draws designs from the ranges; the text of `study.json` and of `draws.csv`, and charts. Draws that tasks have left
/// in `folder` are read from there, and those that are missing are computed into it.
#[pyfunction(name = "study")]
#[allow(clippy::too_many_arguments)] // they are those of the Python function
pub(crate) fn study_of(
    py: Python<'_>,
    design: &NativeDesign,
    draws: u32,
    seed: u64,
    structures: Option<u16>,
    cache: Option<PathBuf>,
    keep: bool,
    folder: Option<PathBuf>,
    report: Option<Py<PyAny>>,
) -> PyResult<StudyFiles> {
    let (design, request) = (
        Arc::clone(&design.design),
        request(draws, seed, structures, Subset::All)?,
    );
    let (result, table, charts) = work::off_the_lock(py, report, move |observer| {
        cost::refuse(&design, &cost::of_run(&design)?, MemoryLimit::default())?;
        let cache = store(cache, keep)?;
        let shared = folder.as_deref().map(unbounded).transpose()?;
        let progress = Progress::to(Arc::clone(&observer));
        let graph = Graph::quiet(shared.as_ref().unwrap_or(&cache), observer);
        let made = study::draws(&graph, &design, &request, &progress)?;
        let nominal = study::nominal(&graph, &design, &request)?;
        let result = StudyResult::new(&design, &request, &made, nominal.as_deref());
        study::store_study(&cache, &design, &result, &made)?;
        let mut result = result.with_surrogates(&design, &made);
        result.headline = headline::headline(&graph, &design, (&chain::cycle(&design)?).into())?;
        let charts = drawn(&figures::study(&result));
        let [table, _] = study::draw_files(&made)?;
        Ok((result, table, charts))
    })?;
    Ok((json_of(&result)?, String::from_utf8_lossy(&table).into_owned(), charts))
}

/// Changes of the levels from the first design to each other over common draws, as JSON.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // they are those of the Python function
pub(crate) fn compare_draws(
    py: Python<'_>,
    designs: Vec<PyRef<'_, NativeDesign>>,
    draws: u32,
    seed: u64,
    structures: Option<u16>,
    cache: Option<PathBuf>,
    keep: bool,
    report: Option<Py<PyAny>>,
) -> PyResult<String> {
    let request = request(draws, seed, structures, Subset::All)?;
    let designs: Vec<_> = designs.iter().map(|own| Arc::clone(&own.design)).collect();
    let paired = work::off_the_lock(py, report, move |observer| {
        for design in &designs {
            cost::refuse(design, &cost::of_run(design)?, MemoryLimit::default())?;
        }
        let progress = Progress::to(Arc::clone(&observer));
        let graph = Graph::quiet(&store(cache, keep)?, observer);
        let reference = &designs[0];
        let pair = |other: &Arc<Design>| {
            let made = study::common_draws(&graph, &[&**reference, &**other], &request, &progress)?;
            Ok(PairedStudy::new(
                (&**reference, &made[0]),
                (&**other, &made[1]),
                &request,
            ))
        };
        designs
            .iter()
            .skip(1)
            .map(pair)
            .collect::<Result<Vec<_>, Error>>()
            .map_err(Into::into)
    })?;
    json_of(&paired)
}

/// Draws designs only for the cycle, as JSON.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // they are those of the Python function
pub(crate) fn shots(
    py: Python<'_>,
    design: &NativeDesign,
    draws: u32,
    seed: u64,
    cache: Option<PathBuf>,
    keep: bool,
    report: Option<Py<PyAny>>,
) -> PyResult<String> {
    let design = Arc::clone(&design.design);
    let made = work::off_the_lock(py, report, move |observer| {
        let progress = Progress::to(Arc::clone(&observer));
        let graph = Graph::quiet(&store(cache, keep)?, observer);
        Ok(study::shots(&graph, &design, draws as usize, seed, &progress)?)
    })?;
    json_of(&made)
}

/// Levels over a grid of values, as JSON, and a chart over the first key.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // they are those of the Python function
pub(crate) fn sweep(
    py: Python<'_>,
    design: &NativeDesign,
    vary: Vec<String>,
    draws: Option<u32>,
    seed: u64,
    cache: Option<PathBuf>,
    keep: bool,
    report: Option<Py<PyAny>>,
) -> PyResult<(String, Vec<(String, String)>)> {
    let axes = axes(&vary)?;
    let request = draws.map(|draws| request(draws, seed, None, Subset::All)).transpose()?;
    let (design, assignments) = (Arc::clone(&design.design), parsed(&design.assignments)?);
    let (points, charts) = work::off_the_lock(py, report, move |observer| {
        let progress = Progress::to(Arc::clone(&observer));
        let graph = Graph::quiet(&store(cache, keep)?, observer);
        let base = (design.path(), &assignments[..]);
        let limit = MemoryLimit::default();
        let mut points = study::sweep(&graph, base, &axes, request.as_ref(), limit, &progress)?;
        headline::explain_first(&graph, base, &axes, &mut points)?;
        let charts = drawn(&[figures::sweep(design.name(), &axes, &points)]);
        Ok((points, charts))
    })?;
    Ok((json_of(&points)?, charts))
}

fn axes(vary: &[String]) -> PyResult<Vec<Axis>> {
    let axes = vary.iter().map(|text| text.parse::<Axis>().map_err(value_error));
    let axes = axes.collect::<PyResult<Vec<_>>>()?;
    study::distinct(&axes).map_err(value_error)?;
    Ok(axes)
}

/// The values of each key of a sweep, as written in a design.
#[pyfunction]
pub(crate) fn axis_values(vary: Vec<String>) -> PyResult<Vec<(String, Vec<String>)>> {
    Ok(axes(&vary)?.into_iter().map(|axis| (axis.key, axis.values)).collect())
}
