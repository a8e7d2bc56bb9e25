//! The tasks of a scheduler: each leaves outputs of stages in a folder and names the files, so that they can be carried
//! elsewhere.

use std::path::PathBuf;
use std::sync::Arc;

use nailnoise::cost::{self, MemoryLimit};
use nailnoise::graph::Graph;
use nailnoise::stages::Progress;
use nailnoise::study::tasks::{self, Candidates};
use nailnoise::study::{self, Subset};
use pyo3::prelude::*;

use crate::design::{NativeDesign, unbounded};
use crate::error::{raised, value_error};
use crate::study::request;
use crate::work;

/// The candidates of a study (`structures` says whether these are drawn) or, without a sound, of draws of shots.
#[pyclass(frozen, name = "Candidates", module = "nailnoise._native")]
pub(crate) struct NativeCandidates {
    candidates: Arc<Candidates>,
}

#[pymethods]
impl NativeCandidates {
    #[staticmethod]
    fn of_study(py: Python<'_>, design: &NativeDesign, seed: u64, structures: bool) -> PyResult<Self> {
        let design = Arc::clone(&design.design);
        let made = work::off_the_lock(py, None, move |_| Ok(Candidates::of_study(&design, seed, structures)?))?;
        Ok(Self {
            candidates: Arc::new(made),
        })
    }

    #[staticmethod]
    fn of_shots(py: Python<'_>, design: &NativeDesign, seed: u64) -> PyResult<Self> {
        let design = Arc::clone(&design.design);
        let made = work::off_the_lock(py, None, move |_| Ok(Candidates::of_shots(&design, seed)?))?;
        Ok(Self {
            candidates: Arc::new(made),
        })
    }

    /// Computes the shots of a block into a folder; how many candidates are accepted, and the files.
    fn outcomes(&self, py: Python<'_>, block: u64, folder: PathBuf) -> PyResult<(usize, Vec<String>)> {
        let candidates = Arc::clone(&self.candidates);
        work::off_the_lock(py, None, move |observer| {
            let store = unbounded(&folder)?;
            let accepted = candidates.outcomes(&Graph::quiet(&store, observer), block)?;
            Ok((accepted, store.take_used()))
        })
    }
}

/// Computes a task of a study into a folder; how many draws it made, and the files. With `screened` the outcomes of all
/// candidates are in the folder by then.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // they are those of the Python function
pub(crate) fn study_task(
    py: Python<'_>,
    design: &NativeDesign,
    draws: u32,
    seed: u64,
    structures: Option<u16>,
    task: (u32, u32),
    screened: bool,
    folder: PathBuf,
    report: Option<Py<PyAny>>,
) -> PyResult<(usize, Vec<String>)> {
    let (number, of) = task;
    if !(1..=of).contains(&number) {
        return Err(value_error(format!(
            "there is no task {number} of {of}; the first is 1"
        )));
    }
    let part = if screened {
        Subset::Screened { number, of }
    } else {
        Subset::Task { number, of }
    };
    let (design, request) = (Arc::clone(&design.design), request(draws, seed, structures, part)?);
    work::off_the_lock(py, report, move |observer| {
        cost::refuse(&design, &cost::of_run(&design)?, MemoryLimit::default())?;
        let progress = Progress::to(Arc::clone(&observer));
        let store = unbounded(&folder)?;
        let made = study::draws(&Graph::quiet(&store, observer), &design, &request, &progress)?;
        Ok((made.draws.len(), store.take_used()))
    })
}

/// Computes the levels of a design without its sensors into a folder; the files.
#[pyfunction]
pub(crate) fn levels_task(py: Python<'_>, design: &NativeDesign, folder: PathBuf) -> PyResult<Vec<String>> {
    let design = Arc::clone(&design.design);
    work::off_the_lock(py, None, move |observer| {
        cost::refuse(&design, &cost::of_run(&design)?, MemoryLimit::default())?;
        let store = unbounded(&folder)?;
        tasks::levels(&Graph::quiet(&store, observer), &design)?;
        Ok(store.take_used())
    })
}

/// Name of the modes and radiation matrices of a design; designs that share them have one name.
#[pyfunction]
pub(crate) fn structures(design: &NativeDesign) -> PyResult<String> {
    tasks::structures(&design.design).map_err(raised)
}
