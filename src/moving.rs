//! Surfaces of the bodies with their motion in each mode, for all that shows them.

use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::pipeline::{Driven, Vibration};

/// The surface of a body that moves in its modes.
pub struct MovingSurface<'a> {
    /// The body, and what the shot did to it.
    pub driven: Driven<'a>,
    /// Displacement of the surface's points, x, y and z of each, in each of the body's modes: 3 points x modes
    /// \[kg^-1/2\]. In single precision, which is that of the pictures.
    pub modes: DMatrix<f32>,
}

impl<'a> MovingSurface<'a> {
    /// Those of all bodies of a shot.
    pub fn all(vibration: &'a Vibration) -> Vec<Self> {
        vibration.driven().map(Self::of).collect()
    }

    fn of(driven: Driven<'a>) -> Self {
        let shapes = &driven.body.basis.shapes;
        let nodes = &driven.body.surface.volume_nodes;
        let rows = 3 * nodes.len();
        let mut modes = DMatrix::zeros(rows, shapes.ncols());
        let columns = shapes.as_slice().par_chunks(shapes.nrows().max(1));
        modes
            .as_mut_slice()
            .par_chunks_mut(rows.max(1))
            .zip(columns)
            .for_each(|(own, shape)| {
                for (own, &node) in own.chunks_exact_mut(3).zip(nodes) {
                    let volume = &shape[3 * node..3 * node + 3];
                    own.iter_mut().zip(volume).for_each(|(to, v)| *to = *v as f32);
                }
            });
        Self { driven, modes }
    }
}
