//! How values are passed: results as JSON text, numbers as bytes, charts as SVG.

use nailnoise::figures::Chart;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

/// Numbers as bytes, in the order of the machine.
pub(crate) fn floats<'py>(py: Python<'py>, values: &[f64]) -> Bound<'py, PyBytes> {
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_ne_bytes()).collect();
    PyBytes::new(py, &bytes)
}

/// Charts by name, as SVG.
pub(crate) fn drawn(charts: &[Chart]) -> Vec<(String, String)> {
    charts.iter().map(|chart| (chart.name.clone(), chart.svg())).collect()
}
