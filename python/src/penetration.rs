//! Penetration laws and their fits.

use std::path::PathBuf;

use nailnoise::penetration::fitting::{Options, Rate, default_form, fit_files};
use nailnoise::penetration::{self, PenetrationError, file_of};
use nailnoise::{Error, figures};
use nailnoise_penetration::fit::{Cleaning, Form, Leave, Method, Start};
use nailnoise_penetration::{NAILS, PenetrationCurve, PenetrationLaw, WOODS};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::{json_of, raised, value_error};
use crate::values::{drawn, floats};
use crate::work;

/// An error of the library about penetration.
fn refused(error: impl Into<PenetrationError>) -> PyErr {
    raised(Error::Penetration(error.into()))
}

/// Names of the published laws, of woods and of nails.
#[pyfunction]
pub(crate) fn penetration_names() -> [Vec<&'static str>; 3] {
    [
        PenetrationLaw::ALL.iter().map(|law| law.as_str()).collect(),
        WOODS.iter().map(|wood| wood.name).collect(),
        NAILS.iter().map(|nail| nail.name).collect(),
    ]
}

/// Force \[N\], its band and the work \[J\] of a published law, or of the table in a file, over depths \[m\].
#[pyfunction]
pub(crate) fn penetration_curve<'py>(
    py: Python<'py>,
    law: Option<&str>,
    table: Option<PathBuf>,
    wood: &str,
    nail: &str,
    speed: f64,
    depths: Option<Vec<f64>>,
) -> PyResult<Bound<'py, PyDict>> {
    let nail = penetration::nail(nail).map_err(refused)?;
    let curve = match (law, table) {
        (Some(law), _) => PenetrationCurve::new(
            penetration::law(law).map_err(refused)?,
            penetration::wood(wood).map_err(refused)?,
            nail,
            speed,
        ),
        (None, Some(path)) => {
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            PenetrationCurve::tabulated(&name, penetration::table(&path).map_err(refused)?, nail)
        }
        (None, None) => return Err(value_error("give the name of a law, or a file with a table")),
    };
    let curve = curve.map_err(refused)?;
    let depths = depths.unwrap_or_else(|| (0..=200).map(|step| nail.length * f64::from(step) / 200.0).collect());
    let forces = depths.iter().map(|depth| curve.force(*depth));
    let forces = forces.collect::<Result<Vec<f64>, _>>().map_err(refused)?;
    let work = depths.iter().map(|depth| curve.work(*depth));
    let work = work.collect::<Result<Vec<f64>, _>>().map_err(refused)?;
    let bands = depths.iter().map(|depth| curve.band(*depth));
    let bands = bands.collect::<Result<Option<Vec<[f64; 2]>>, _>>().map_err(refused)?;
    let chart = figures::penetration(
        &curve.name,
        std::slice::from_ref(&curve),
        std::slice::from_ref(&curve.name),
    );
    let made = PyDict::new(py);
    made.set_item("name", &curve.name)?;
    made.set_item("depth", floats(py, &depths))?;
    made.set_item("force", floats(py, &forces))?;
    made.set_item("work", floats(py, &work))?;
    if let Some(bands) = bands {
        made.set_item("band", floats(py, bands.as_flattened()))?;
    }
    made.set_item("notes", curve.notes())?;
    made.set_item("charts", drawn(&[chart.map_err(refused)?]))?;
    Ok(made)
}

/// Fits a law to the drives of files; its figures and the notes as JSON, the text of `fit.toml`, residuals by point,
/// and charts.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // they are those of the Python function
pub(crate) fn fit_penetration<'py>(
    py: Python<'py>,
    files: Vec<PathBuf>,
    form: Option<&str>,
    method: Option<&str>,
    reduce: bool,
    leave: Option<&str>,
    split: bool,
    start: Option<f64>,
    rate: Option<&str>,
    friction_share: Option<f64>,
    extrapolate: bool,
    report: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let method = match method {
        None => None,
        Some("least-squares") => Some(Method::LeastSquares),
        Some("within-between") => Some(Method::WithinBetween),
        Some(other) => {
            return Err(value_error(format!(
                "there is no method `{other}`; give least-squares or within-between"
            )));
        }
    };
    let leave = match leave {
        None => None,
        Some("group") => Some(Leave::Group),
        Some("nail") => Some(Leave::Nail),
        Some("wood") => Some(Leave::Wood),
        Some("drive") => Some(Leave::Drive),
        Some(other) => {
            return Err(value_error(format!(
                "`{other}` cannot be left out; give group, nail, wood or drive"
            )));
        }
    };
    let rate = match rate {
        None => None,
        Some(given @ ("speed" | "estimate")) => Some(Rate {
            share: friction_share,
            estimate: given == "estimate",
        }),
        Some(other) => {
            return Err(value_error(format!(
                "there is no rate `{other}`; give speed or estimate"
            )));
        }
    };
    let form: Form = form
        .unwrap_or_else(|| default_form(rate.as_ref()))
        .parse()
        .map_err(refused)?;
    let options = Options {
        form,
        method,
        reduce,
        leave,
        split,
        rate,
        cleaning: Cleaning {
            start: start.map_or(Start::Automatic, Start::Force),
            ..Cleaning::default()
        },
        extrapolate,
    };
    let fitting = work::off_the_lock(py, report, move |_| {
        Ok(fit_files(&files, &options).map_err(Error::Penetration)?)
    })?;
    let (law, drives) = (&fitting.law, &fitting.drives);
    let subject = format!("{}, {} drives", law.form(), drives.len());
    let charts = [
        figures::fit(&subject, law, drives),
        figures::residuals(&subject, drives, &fitting.residuals),
    ];
    let made = PyDict::new(py);
    made.set_item("fit", json_of(law.file())?)?;
    made.set_item("fitting", json_of(&fitting)?)?;
    made.set_item("toml", file_of(law).map_err(refused)?)?;
    made.set_item("residuals", floats(py, &fitting.residuals))?;
    made.set_item("charts", drawn(&charts))?;
    Ok(made)
}
