//! The worktable of steel: a plate on hollow legs, meshed apart and to be tied.

use crate::worktable::{checked, legs};
use crate::{Block, Grid, Mesh, MeshError, Worktable, block, subdivide};

/// Meshes a worktable on square tubes of this `wall` \[m\], one element through the wall, open below and at the plate.
///
/// Plate and legs share no nodes: the legs' upper ends, the group `weld_slave`, are to be tied to the plate's underside,
/// `weld_master`. Apart, neither mesh carries the lines of the other, which a wall of 2 mm would draw across the whole
/// plate. Parts `top` and `leg`; the other groups are `top`, `sides`, `leg_sides` (inside too) and `floor`.
///
/// # Errors
/// As [`worktable`](crate::worktable()), and [`MeshError::DoesNotFit`] when two walls fill a leg.
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
    let mut divisions = [0, 0, spec.top_layers];
    for k in 0..2 {
        divisions[k] = subdivide(0.0, spec.top[k], spec.element_size)?.len();
    }
    let mut mesh = block(&Block {
        size: [spec.top[0], spec.top[1], spec.thickness],
        divisions,
        origin: [spec.origin[0], spec.origin[1], underside],
    })?;
    mesh.part_names = vec!["top".to_owned()];
    let mut sides = Vec::new();
    mesh.groups.retain_mut(|group| match group.name.as_str() {
        "top" => true,
        "bottom" => {
            "weld_master".clone_into(&mut group.name);
            true
        }
        _ => {
            sides.append(&mut group.faces);
            false
        }
    });
    mesh.groups.push(crate::FaceGroup {
        name: "sides".to_owned(),
        faces: sides,
    });
    let mut z = vec![floor];
    z.extend(subdivide(floor, underside, spec.leg_element_size)?);
    let corners = |k: usize| [spec.origin[k], spec.origin[k] + spec.top[k] - spec.leg[k]];
    for y in corners(1) {
        for x in corners(0) {
            let across = |from: f64, width: f64| -> Result<Vec<f64>, MeshError> {
                let mut line = vec![from, from + wall];
                line.extend(subdivide(from + wall, from + width - wall, spec.element_size)?);
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
