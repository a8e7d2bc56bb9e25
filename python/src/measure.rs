//! The measurement side: levels from recordings, and virtual tests of a design.

use std::path::PathBuf;
use std::sync::Arc;

use nailnoise::cost::{self, MemoryLimit};
use nailnoise::figures;
use nailnoise::graph::Graph;
use nailnoise::measurement::Manifest;
use nailnoise::measurement::arrangement::Arrangement;
use nailnoise::measurement::processing::process_recordings;
use nailnoise::measurement::result::Processing;
use nailnoise::measurement::wrapping::Wrapping;
use nailnoise::stages::Progress;
use nailnoise::virtual_test::exact::exact;
use nailnoise::virtual_test::{VirtualTest, wrapping};
use pyo3::prelude::*;

use crate::design::{NativeDesign, store};
use crate::error::{json_of, value_error};
use crate::values::drawn;
use crate::work;

/// Levels of the sources from the recordings that a manifest names; the text of `measurement.json`, and charts.
#[pyfunction]
pub(crate) fn measure(
    py: Python<'_>,
    manifest: PathBuf,
    reading: &str,
    paired: bool,
    total_less_residual: bool,
    report: Option<Py<PyAny>>,
) -> PyResult<(String, Vec<(String, String)>)> {
    let reading = reading
        .parse()
        .map_err(|error| value_error(format!("the reading of zeroed lines: {error}")))?;
    let processing = Processing {
        reading,
        paired,
        total_less_residual,
    };
    let measured = work::off_the_lock(py, report, move |observer| {
        let progress = Progress::to(observer);
        let path = manifest;
        let manifest = Manifest::load(&path).map_err(nailnoise::Error::from)?;
        manifest
            .warnings
            .iter()
            .for_each(|warning| progress.note(&format!("warning: {warning}")));
        let arrangement = Arrangement::of(&manifest).map_err(nailnoise::Error::from)?;
        let step = |_, _| progress.observer().step();
        let mut measured = process_recordings(&manifest, &arrangement, processing, step, |_| {
            Ok::<(), nailnoise::Error>(())
        })?;
        measured.result.manifest = path.display().to_string();
        let charts = drawn(&figures::measurement(&measured));
        Ok((measured.result, charts))
    })?;
    Ok((json_of(&measured.0)?, measured.1))
}

/// The energies of a wrapping test of a design, without recordings and scatter, as JSON.
#[pyfunction]
pub(crate) fn test_energies(
    py: Python<'_>,
    design: &NativeDesign,
    perfect_wraps: bool,
    cache: Option<PathBuf>,
    keep: bool,
    report: Option<Py<PyAny>>,
) -> PyResult<String> {
    let design = Arc::clone(&design.design);
    let made = work::off_the_lock(py, report, move |observer| {
        cost::refuse(&design, &cost::of_run(&design)?, MemoryLimit::default())?;
        let wraps = if perfect_wraps {
            Wrapping::perfect()
        } else {
            wrapping(&design)
        };
        let graph = Graph::quiet(&store(cache, keep)?, observer);
        let test = VirtualTest::new(&graph, &design, wraps, 1)?;
        let own = test.own()?;
        let rate = design.test.sampling_rate;
        let background = design.acoustics.background_level;
        Ok(exact(
            &test.arrangement,
            rate,
            &wraps,
            &test.densities(&own),
            background,
        )?)
    })?;
    json_of(&made)
}
