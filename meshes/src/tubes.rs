//! The steel worktable: a plate on hollow legs, meshed separately and then tied.

use crate::worktable::{checked, legs, lines};
use crate::{Grid, Mesh, MeshError, Worktable, subdivide};

/// Meshes a worktable with legs of square tube of the given `wall` \[m\]. There is one element through the wall,
/// elements are no longer than `leg_element_size` along and across it, and the tubes are open at both ends.
///
/// The plate and the legs share no nodes, so that the mesh lines of the walls do not extend across the plate. The legs'
/// upper ends, group `weld_slave`, must be tied to the plate's underside, `weld_master`. The plate's mesh lines follow
/// the legs' outlines; otherwise the first plate mode is 2 % too high. The parts are `top` and `leg`; the other groups
/// are `top`, `sides`, `leg_sides` (including the inside) and `floor`.
///
/// # Errors
/// Same as [`worktable`](crate::worktable()); also [`MeshError::DoesNotFit`] if two walls fill a leg.
pub fn tube_worktable(spec: &Worktable, wall: f64) -> Result<Mesh, MeshError> {
    checked(spec)?;
    if !(wall.is_finite() && wall > 0.0) {
        return Err(MeshError::Dimension {
            what: "the wall of the legs",
            value: wall,
        });
    }
    for leg in spec.leg {
        if 2.0 * wall >= leg {
            return Err(MeshError::DoesNotFit {
                what: "two walls of a hollow leg",
                inner: 2.0 * wall,
                outer: leg,
            });
        }
    }
    let [floor, underside] = legs(spec);
    let mut through = vec![underside];
    through.extend(subdivide(
        underside,
        underside + spec.thickness,
        spec.thickness / spec.top_layers as f64,
    )?);
    let plate = Grid::new(lines(spec, 0)?, lines(spec, 1)?, through)?;
    let mut mesh = plate.mesh(
        &["top"],
        |_| Some(0),
        |_, axis, upper, _| match (axis, upper) {
            (2, true) => "top",
            (2, false) => "weld_master",
            _ => "sides",
        },
    );
    let mut z = vec![floor];
    z.extend(subdivide(floor, underside, spec.leg_element_size)?);
    let corners = |k: usize| [spec.origin[k], spec.origin[k] + spec.top[k] - spec.leg[k]];
    for y in corners(1) {
        for x in corners(0) {
            let across = |from: f64, width: f64| -> Result<Vec<f64>, MeshError> {
                let mut line = vec![from, from + wall];
                line.extend(subdivide(from + wall, from + width - wall, spec.leg_element_size)?);
                line.push(from + width);
                Ok(line)
            };
            let grid = Grid::new(across(x, spec.leg[0])?, across(y, spec.leg[1])?, z.clone())?;
            let [nx, ny, _] = grid.cells();
            let hollow = |[i, j, _]: [usize; 3]| (1..nx - 1).contains(&i) && (1..ny - 1).contains(&j);
            mesh.join(&grid.mesh(
                &["leg"],
                |cell| (!hollow(cell)).then_some(0),
                |_, axis, upper, _| match (axis, upper) {
                    (2, true) => "weld_slave",
                    (2, false) => "floor",
                    _ => "leg_sides",
                },
            ));
        }
    }
    Ok(mesh)
}
