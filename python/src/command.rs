//! The command `nailnoise` of the package.

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs a command line, whose first argument is the name of the program; returns the exit status. Wrong usage and an
/// interruption end the process.
#[pyfunction]
pub(crate) fn command(python: Python<'_>, arguments: Vec<OsString>) -> u8 {
    python.detach(|| nailnoise::commands::main_with(arguments).code())
}
