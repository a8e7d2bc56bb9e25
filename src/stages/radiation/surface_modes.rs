//! The modes for which the radiation of a surface is solved: those of one structure, or of several of the same shape.

use std::sync::Arc;

use nalgebra::DMatrix;
use serde::Serialize;

use crate::error::Error;
use crate::stages::bodies::{Body, MovingSurface};
use crate::stages::{Input, Stored, all};

/// Structures of one shape: each of the same bodies with the same meshes, but of other materials or loads.
#[derive(Clone, Serialize)]
pub struct SurfaceModes(pub Vec<Vec<Stored<Body>>>);

impl SurfaceModes {
    /// The bodies of all structures.
    pub fn inputs(&self) -> Vec<&dyn Input> {
        self.0.iter().flatten().map(|body| body as &dyn Input).collect()
    }

    /// The modes of each body, those of all structures side by side.
    ///
    /// # Errors
    /// Those of the stages that make the bodies.
    pub fn get(&self) -> Result<JoinedModes, Error> {
        let structures: Vec<Vec<Arc<Body>>> = self.0.iter().map(|bodies| all(bodies)).collect::<Result<_, _>>()?;
        let modes = |place: usize| {
            let columns = structures.iter().flat_map(|bodies| bodies[place].skin.column_iter());
            DMatrix::from_columns(&columns.collect::<Vec<_>>())
        };
        let joined = match &structures[..] {
            [] | [_] => None,
            [first, ..] => Some((0..first.len()).map(modes).collect()),
        };
        Ok(JoinedModes {
            bodies: structures.into_iter().next().unwrap_or_default(),
            joined,
        })
    }
}

/// The bodies of the first structure in the modes of all.
pub struct JoinedModes {
    bodies: Vec<Arc<Body>>,
    /// Modes of all structures on the surface of each body; none where there is only one structure.
    joined: Option<Vec<DMatrix<f32>>>,
}

impl JoinedModes {
    /// The surfaces of the bodies, and how they move.
    pub fn surfaces(&self) -> Vec<MovingSurface<'_>> {
        let own = self.bodies.iter().map(|body| body.moving_surface());
        match &self.joined {
            None => own.collect(),
            Some(joined) => own
                .zip(joined)
                .map(|(surface, modes)| MovingSurface { modes, ..surface })
                .collect(),
        }
    }
}
