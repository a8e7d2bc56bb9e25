//! The workpiece: a rectangular block.

use nalgebra::Point3;

use crate::{Grid, Mesh, MeshError};

/// A rectangular block of one material.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Block {
    /// Lengths along x, y and z \[m\].
    pub size: [f64; 3],
    /// Elements along x, y and z.
    pub divisions: [usize; 3],
    /// Corner with the smallest coordinates \[m\].
    pub origin: [f64; 3],
}

impl Block {
    /// A block with elements no longer than `element_size` \[m\], its smallest corner at `origin`.
    ///
    /// # Errors
    /// [`MeshError::Dimension`] when a length is not positive and finite.
    pub fn with_element_size(size: [f64; 3], element_size: f64, origin: [f64; 3]) -> Result<Self, MeshError> {
        let mut divisions = [0; 3];
        for k in 0..3 {
            divisions[k] = crate::subdivide(0.0, size[k], element_size)?.len();
        }
        Ok(Self {
            size,
            divisions,
            origin,
        })
    }
}

/// Meshes a block with 20-node hexahedra; part `block`, face groups `x_min`, `x_max`, `y_min`, `y_max`, `bottom`, `top`.
///
/// # Errors
/// [`MeshError::Dimension`] or [`MeshError::NoElements`].
pub fn block(spec: &Block) -> Result<Mesh, MeshError> {
    let mut lines: [Vec<f64>; 3] = Default::default();
    for (k, what) in [
        "the block's length along x",
        "the block's length along y",
        "the block's length along z",
    ]
    .into_iter()
    .enumerate()
    {
        let (length, n, from) = (spec.size[k], spec.divisions[k], spec.origin[k]);
        if !(length.is_finite() && length > 0.0) {
            return Err(MeshError::Dimension { what, value: length });
        }
        if n == 0 {
            return Err(MeshError::NoElements { what });
        }
        lines[k] = (0..=n).map(|i| from + length * i as f64 / n as f64).collect();
    }
    let [x, y, z] = lines;
    Ok(Grid::new(x, y, z)?.mesh(
        &["block"],
        |_| Some(0),
        |_, axis, upper, _: Point3<f64>| match (axis, upper) {
            (0, false) => "x_min",
            (0, true) => "x_max",
            (1, false) => "y_min",
            (1, true) => "y_max",
            (_, false) => "bottom",
            (_, true) => "top",
        },
    ))
}
