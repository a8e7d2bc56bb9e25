//! The modes for which the radiation of a surface is solved: those of one structure, or of several of the same shape.

use std::sync::Arc;

use nalgebra::DMatrix;
use serde::Serialize;

use crate::error::Error;
use crate::stages::bodies::{Body, MovingSurface};
use crate::stages::{Stored, all};

/// Structures with the same shape: each has the same bodies, but of other materials or loads. Their meshes are the same
/// or, if a structure is a single body, different meshes of the same outer surface.
#[derive(Clone, Serialize)]
pub struct SurfaceModes(pub Vec<Vec<Stored<Body>>>);

impl SurfaceModes {
    /// The modes of each body; those of all structures with the same meshes are concatenated.
    ///
    /// # Errors
    /// The errors of the stages that make the bodies.
    pub fn get(&self) -> Result<JoinedModes, Error> {
        let structures: Vec<Vec<Arc<Body>>> = self.0.iter().map(|bodies| all(bodies)).collect::<Result<_, _>>()?;
        let mut structures = structures.into_iter();
        let bodies = structures.next().unwrap_or_default();
        let same_points = |other: &Vec<Arc<Body>>| {
            let mut pairs = bodies.iter().zip(other);
            pairs.all(|(body, other)| body.surface.points == other.surface.points)
        };
        let (alike, others): (Vec<_>, Vec<_>) = structures.partition(same_points);
        let modes = |(place, body): (usize, &Arc<Body>)| {
            let columns = alike.iter().flat_map(|bodies| bodies[place].skin.column_iter());
            DMatrix::from_columns(&body.skin.column_iter().chain(columns).collect::<Vec<_>>())
        };
        let joined = (!alike.is_empty()).then(|| bodies.iter().enumerate().map(modes).collect());
        Ok(JoinedModes {
            joined,
            bodies,
            others: others.into_iter().flatten().collect(),
        })
    }
}

/// The bodies of the first structure with the modes of all structures that have the same meshes, and the bodies of the
/// others.
pub struct JoinedModes {
    bodies: Vec<Arc<Body>>,
    /// Modes of all structures on the surface of each body; `None` unless another structure has the same meshes.
    joined: Option<Vec<DMatrix<f32>>>,
    /// Bodies with other meshes of the same outer surface.
    others: Vec<Arc<Body>>,
}

impl JoinedModes {
    /// The surfaces of the bodies with their modes, then those of bodies with other meshes.
    pub fn surfaces(&self) -> Vec<MovingSurface<'_>> {
        let own = self.bodies.iter().map(|body| body.moving_surface());
        let others = self.others.iter().map(|body| body.moving_surface());
        match &self.joined {
            None => own.chain(others).collect(),
            Some(joined) => own
                .zip(joined)
                .map(|(surface, modes)| MovingSurface { modes, ..surface })
                .chain(others)
                .collect(),
        }
    }
}
