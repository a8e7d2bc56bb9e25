//! `modes/BODY/*`: mode shapes of a body, written by `nailnoise modes`.

use std::path::{Path, PathBuf};

use nailnoise_meshes::uff::{self, Mode};
use nalgebra::DMatrix;

use super::{fields, motion};
use crate::atomic_write::AtomicWrite;
use crate::error::Error;
use crate::stages::bodies::Body;

/// The folder of the modes of a body in that of a run.
fn of_modes(body: &Body) -> PathBuf {
    Path::new("modes").join(body.name)
}

/// Writes the mode shapes of a body, [`Body::shapes`], to `modes/BODY/`; returns the `.pvd` that lists them.
///
/// # Errors
/// [`Error::Write`] or [`Error::Mesh`] with the file that could not be written.
pub fn write_modes(staging: &AtomicWrite, body: &Body, shapes: &DMatrix<f64>) -> Result<PathBuf, Error> {
    fields::write_modes(staging, &of_modes(body), body, shapes)
}

/// Writes one period of mode `mode` (from 0) of a body to `modes/BODY/`; returns the `.pvd` that plays it.
///
/// # Errors
/// [`Error::NoMode`] if the mode does not exist; [`Error::Write`] or [`Error::Mesh`] with the file that could not be
/// written.
pub fn write_motion(staging: &AtomicWrite, body: &Body, mode: usize) -> Result<PathBuf, Error> {
    let modes = body.basis.hz.len();
    if mode >= modes {
        return Err(Error::NoMode { mode: mode + 1, modes });
    }
    motion::write(staging, &of_modes(body), body, mode)
}

/// Writes the skin and the modes of a body, [`Body::shapes`], to `modes/BODY/modes.uff` for modal-test software.
///
/// # Errors
/// [`Error::Write`] or [`Error::Mesh`] with the file that could not be written.
pub fn write_universal(
    staging: &AtomicWrite,
    name: &str,
    (body, loss_factor): (&Body, f64),
    shapes: &DMatrix<f64>,
) -> Result<PathBuf, Error> {
    let path = of_modes(body).join("modes.uff");
    let modes: Vec<Mode<'_>> = body
        .basis
        .hz
        .iter()
        .zip(shapes.column_iter())
        .map(|(&hz, shape)| Mode {
            hz,
            loss_factor,
            // The columns of a matrix that owns its values are contiguous.
            shape: shape.data.into_slice(),
        })
        .collect();
    let text = uff::text(&format!("{name} {}", body.name), &body.surface, &modes)?;
    staging.write(&path, text.as_bytes())?;
    Ok(path)
}
