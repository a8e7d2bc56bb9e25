//! The workpiece: a rectangular block of one piece, or of two pieces in contact.

use nalgebra::Point3;

use crate::{Grid, Mesh, MeshError};

/// A rectangular block of one material.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Block {
    /// Side lengths along x, y and z \[m\].
    pub size: [f64; 3],
    /// Number of elements along x, y and z.
    pub divisions: [usize; 3],
    /// Corner with the smallest coordinates \[m\].
    pub origin: [f64; 3],
}

impl Block {
    /// Creates a block with elements no longer than `element_size` \[m\] and its smallest corner at `origin`.
    ///
    /// # Errors
    /// [`MeshError::Dimension`] unless every length is positive and finite.
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

/// Face groups of the contact between the pieces of [`jointed_block`]: the top of the lower piece and the underside of
/// the upper one.
pub const JOINT: [&str; 2] = ["joint_lower", "joint_upper"];

/// Meshes a block of two pieces that are in contact at `height` \[m\] above its underside and share no nodes. Its parts
/// are `block` and `board`; its face groups are those of [`block`] and [`JOINT`].
///
/// # Errors
/// Same as [`block`]; also if the height is not within the block.
pub fn jointed_block(size: [f64; 3], element_size: f64, origin: [f64; 3], height: f64) -> Result<Mesh, MeshError> {
    let piece = |thickness: f64, from: f64, joint: [&str; 2]| {
        let [x, y, z] = origin;
        let spec = Block::with_element_size([size[0], size[1], thickness], element_size, [x, y, z + from])?;
        let mut mesh = block(&spec)?;
        let touching = mesh.groups.iter_mut().find(|group| group.name == joint[0]);
        touching
            .into_iter()
            .for_each(|group| joint[1].clone_into(&mut group.name));
        Ok::<_, MeshError>(mesh)
    };
    let mut mesh = piece(height, 0.0, ["top", JOINT[0]])?;
    let mut board = piece(size[2] - height, height, ["bottom", JOINT[1]])?;
    board.part_names = vec!["board".to_owned()];
    mesh.join(&board);
    Ok(mesh)
}

/// Meshes a block with 20-node hexahedra. The part is `block`; the face groups are `x_min`, `x_max`, `y_min`, `y_max`,
/// `bottom` and `top`.
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
