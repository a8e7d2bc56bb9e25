//! Radiation of the moving bodies per unit of modal motion, before the motion is known.

mod boundary_elements;
mod flush;
mod tool;
mod workpiece;

use nailnoise_meshes::Surface;
use nalgebra::DMatrix;

pub(crate) use boundary_elements::{Discretisation, Places};
pub(crate) use flush::{FACE_POINTS, FlushTop, radiating_surface};
pub(crate) use tool::ToolRadiation;
pub(crate) use workpiece::{Covered, WorkpieceBoundaryElements, WorkpieceRadiation};

/// The moving surface of a body.
#[derive(Clone, Copy)]
pub(crate) struct MovingSurface<'a> {
    /// `workpiece`, `worktable` or `tool`.
    pub(crate) body: &'static str,
    /// Its outer faces.
    pub(crate) surface: &'a Surface,
    /// Displacement of the surface's points in each mode, (3 x points) x modes \[kg^-1/2\].
    pub(crate) modes: &'a DMatrix<f32>,
}
