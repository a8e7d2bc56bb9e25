//! The worktable: a plate on four solid legs at its corners.

use crate::{Grid, Mesh, MeshError, subdivide};

/// A worktable as a single conforming solid; the legs are flush with the corners of the top.
///
/// The axes x and y run along the edges of the top, z up from the floor.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Worktable {
    /// Lengths of the top along x and y \[m\].
    pub top: [f64; 2],
    /// Thickness of the top \[m\].
    pub thickness: f64,
    /// Width of the legs along x and y \[m\].
    pub leg: [f64; 2],
    /// Height of the table's upper surface above the floor \[m\].
    pub height: f64,
    /// Largest element edge along x and y \[m\].
    pub element_size: f64,
    /// Largest element edge along the legs \[m\]; it may be longer because waves are faster along a leg's grain.
    pub leg_element_size: f64,
    /// Number of elements through the thickness of the top.
    pub top_layers: usize,
    /// Corner of the table's footprint with the smallest coordinates \[m\].
    pub origin: [f64; 3],
}

/// Meshes a worktable with 20-node hexahedra; the legs' outlines continue as grid lines through the top.
///
/// The parts are `top` and `leg`; the face groups are `top` (upper side), `underside`, `sides` (of the top),
/// `leg_sides` and `floor` (feet).
///
/// # Errors
/// [`MeshError::Dimension`], [`MeshError::NoElements`], or [`MeshError::DoesNotFit`] if legs overlap or have no length.
pub fn worktable(spec: &Worktable) -> Result<Mesh, MeshError> {
    checked(spec)?;
    let ([floor, underside], top) = (legs(spec), spec.origin[2] + spec.height);
    let mut z = vec![floor];
    z.extend(subdivide(floor, underside, spec.leg_element_size)?);
    let leg_layers = z.len() - 1;
    z.extend(subdivide(underside, top, spec.thickness / spec.top_layers as f64)?);
    let grid = Grid::new(lines(spec, 0)?, lines(spec, 1)?, z)?;
    let over_leg = |cell: [usize; 3]| {
        let centre = grid.centre(cell);
        (0..2).all(|k| {
            let at = centre[k] - spec.origin[k];
            at < spec.leg[k] || at > spec.top[k] - spec.leg[k]
        })
    };
    let part = |cell: [usize; 3]| match cell[2] >= leg_layers {
        true => Some(0),
        false => over_leg(cell).then_some(1),
    };
    Ok(grid.mesh(&["top", "leg"], part, |part, axis, upper, _| {
        match (part, axis, upper) {
            (0, 2, true) => "top",
            (0, 2, false) => "underside",
            (0, _, _) => "sides",
            (_, 2, _) => "floor",
            _ => "leg_sides",
        }
    }))
}

/// Grid lines through the top along an axis, including the legs' outlines \[m\].
pub(crate) fn lines(spec: &Worktable, axis: usize) -> Result<Vec<f64>, MeshError> {
    let (o, a, l) = (spec.origin[axis], spec.leg[axis], spec.top[axis]);
    let mut line = vec![o];
    for (from, to) in [(o, o + a), (o + a, o + l - a), (o + l - a, o + l)] {
        line.extend(subdivide(from, to, spec.element_size)?);
    }
    Ok(line)
}

/// Heights of the legs' lower and upper ends \[m\].
pub(crate) fn legs(spec: &Worktable) -> [f64; 2] {
    [spec.origin[2], spec.origin[2] + spec.height - spec.thickness]
}

/// Rejects dimensions that do not make a table.
pub(crate) fn checked(spec: &Worktable) -> Result<(), MeshError> {
    let lengths = [
        ("the top's length along x", spec.top[0]),
        ("the top's length along y", spec.top[1]),
        ("the top's thickness", spec.thickness),
        ("the leg's width along x", spec.leg[0]),
        ("the leg's width along y", spec.leg[1]),
        ("the table's height", spec.height),
        ("the element size", spec.element_size),
        ("the element size along the legs", spec.leg_element_size),
    ];
    for (what, value) in lengths {
        if !(value.is_finite() && value > 0.0) {
            return Err(MeshError::Dimension { what, value });
        }
    }
    for k in 0..2 {
        let (inner, outer) = (2.0 * spec.leg[k], spec.top[k]);
        if inner >= outer {
            return Err(MeshError::DoesNotFit {
                what: "two legs side by side under the top",
                inner,
                outer,
            });
        }
    }
    if spec.thickness >= spec.height {
        let (inner, outer) = (spec.thickness, spec.height);
        return Err(MeshError::DoesNotFit {
            what: "the top's thickness within the table's height",
            inner,
            outer,
        });
    }
    if spec.top_layers == 0 {
        return Err(MeshError::NoElements {
            what: "the thickness of the top",
        });
    }
    Ok(())
}
