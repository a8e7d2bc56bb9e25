//! The native module of the Python package `nailnoise`, on which the classes in `python/nailnoise/__init__.py` are
//! based.
//!
//! Results are passed as JSON text, tables as CSV text and histories as bytes of 64-bit floats, so that the module
//! needs neither the C interface of NumPy nor a second layout of any result. Work runs on a separate thread without the
//! interpreter's lock.

mod blocks;
mod calibrate;
mod command;
mod design;
mod error;
mod measure;
mod penetration;
mod runs;
mod study;
mod tasks;
mod values;
mod work;

use mimalloc::MiMalloc;
use pyo3::prelude::*;

/// The allocator of the command, for the same reason.
#[global_allocator]
static MEMORY: MiMalloc = MiMalloc;

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("CANDIDATES", nailnoise::study::tasks::CANDIDATES)?;
    module.add("SOURCES", nailnoise::model::sources::names().collect::<Vec<_>>())?;
    module.add(
        "ROLES",
        nailnoise::measurement::wrapping::Role::ALL
            .map(|role| role.name())
            .to_vec(),
    )?;
    module.add("NailnoiseError", module.py().get_type::<error::NailnoiseError>())?;
    module.add("NoCacheError", module.py().get_type::<error::NoCacheError>())?;
    module.add_function(wrap_pyfunction!(command::command, module)?)?;
    module.add_class::<design::NativeDesign>()?;
    module.add_class::<tasks::NativeCandidates>()?;
    module.add_function(wrap_pyfunction!(design::cache_folder, module)?)?;
    module.add_function(wrap_pyfunction!(runs::run, module)?)?;
    module.add_function(wrap_pyfunction!(runs::cycle, module)?)?;
    module.add_function(wrap_pyfunction!(runs::modes, module)?)?;
    module.add_function(wrap_pyfunction!(runs::compare, module)?)?;
    module.add_function(wrap_pyfunction!(study::compare_draws, module)?)?;
    module.add_function(wrap_pyfunction!(study::study_of, module)?)?;
    module.add_function(wrap_pyfunction!(study::shots, module)?)?;
    module.add_function(wrap_pyfunction!(study::sweep, module)?)?;
    module.add_function(wrap_pyfunction!(study::axis_values, module)?)?;
    module.add_function(wrap_pyfunction!(tasks::study_task, module)?)?;
    module.add_function(wrap_pyfunction!(tasks::levels_task, module)?)?;
    module.add_function(wrap_pyfunction!(tasks::structures, module)?)?;
    module.add_function(wrap_pyfunction!(calibrate::calibrate, module)?)?;
    module.add_function(wrap_pyfunction!(calibrate::measurement_files, module)?)?;
    module.add_class::<calibrate::NativeWorker>()?;
    module.add_function(wrap_pyfunction!(measure::measure, module)?)?;
    module.add_function(wrap_pyfunction!(measure::test_energies, module)?)?;
    module.add_function(wrap_pyfunction!(penetration::penetration_names, module)?)?;
    module.add_function(wrap_pyfunction!(penetration::penetration_curve, module)?)?;
    module.add_function(wrap_pyfunction!(penetration::fit_penetration, module)?)?;
    module.add_function(wrap_pyfunction!(blocks::radiated_power, module)?)?;
    module.add_function(wrap_pyfunction!(blocks::mesh_modes, module)?)?;
    module.add_function(wrap_pyfunction!(blocks::exhaust_levels, module)?)?;
    module.add_function(wrap_pyfunction!(blocks::signal_levels, module)?)
}
