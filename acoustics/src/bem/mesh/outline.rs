use std::collections::BTreeMap;

use nailnoise_meshes::{FaceKind, MeshError, Surface, open_faces};
use nalgebra::{DMatrix, Point3, Vector3};

use super::panel::{BoundaryMesh, Panel};

/// Height of the nose's tip in the body's coordinates \[m\].
const TIP: f64 = 0.0;

/// Tolerance for a point in the plane of the tip, as a fraction of the body's size.
const IN_PLANE: f64 = 1e-6;

/// The outer surface of a tool, with a cover over the mouth of its nose.
///
/// Until the tool lifts off, the workpiece closes the mouth of the nose. With an open mouth, the bore would be an
/// undamped organ pipe: that of the N80CB would resonate at 737 Hz.
#[derive(Debug, Clone)]
pub struct ClosedOutline {
    /// The points of the skin and of the cover, and the panels exposed to the open air.
    pub mesh: BoundaryMesh,
    /// For each point of the cover, the points of the skin whose mean motion it follows.
    cover: Vec<Vec<usize>>,
}

impl ClosedOutline {
    /// The faces exposed to the open air, with a flat cover over the mouth of the nose. The cover moves with the rim of
    /// the mouth. A nose that touches the floor, at the height `floor` \[m\], needs no cover. The mouth stays open if
    /// the nose does not end in the plane z = 0 with a single simple rim; this may occur in a user's mesh.
    ///
    /// # Errors
    /// [`MeshError`] of the surface.
    pub fn new(skin: &Surface, floor: Option<f64>) -> Result<Self, MeshError> {
        let open = open_faces(skin, floor)?;
        let of_skin = BoundaryMesh::of_skin(skin);
        let panels = |kept: &[bool]| -> Vec<Panel> {
            let each = of_skin.panels.iter().zip(kept);
            each.filter(|(_, kept)| **kept).map(|(panel, _)| *panel).collect()
        };
        let size = of_skin.points.iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
        let covered = panels(&open_faces(skin, Some(TIP))?);
        let flat = |p: &Panel| {
            p.nodes()
                .iter()
                .all(|&n| (of_skin.points[n].z - TIP).abs() <= IN_PLANE * size)
        };
        let tip = of_skin
            .panels
            .iter()
            .zip(&open)
            .find(|(panel, open)| **open && flat(panel));
        let lowest = covered.iter().flat_map(|p| p.nodes()).map(|&n| of_skin.points[n].z);
        let stands = lowest.fold(f64::INFINITY, f64::min) >= TIP - IN_PLANE * size;
        let mouth = match tip {
            Some((tip, _)) if stands && floor.is_none_or(|floor| floor < TIP - IN_PLANE * size) => {
                mouth(&of_skin.points, &covered).map(|rims| (tip.patch, rims))
            }
            _ => None,
        };
        let mut closed = Self {
            mesh: BoundaryMesh {
                panels: panels(&open),
                ..of_skin
            },
            cover: Vec::new(),
        };
        if let Some((patch, rims)) = mouth {
            closed.mesh.panels = covered;
            rims.iter().for_each(|rim| closed.close(rim, patch));
        }
        Ok(closed)
    }

    /// Closes a rim with a fan of triangles around its centre.
    fn close(&mut self, rim: &[Side], patch: usize) {
        let corners: Vec<usize> = rim.iter().map(|side| side.ends[0]).collect();
        let middle = self.add(corners.clone());
        let spokes: BTreeMap<usize, usize> = corners.iter().map(|&c| (c, self.half_way(c, middle))).collect();
        for &Side { ends: [a, b], between } in rim {
            // The rim is traversed in the opposite direction, so that the normals point out of the body.
            let panel = match between {
                Some(mid) => Panel::new(FaceKind::Tri6, &[b, a, middle, mid, spokes[&a], spokes[&b]], patch),
                None => Panel::new(FaceKind::Tri3, &[b, a, middle], patch),
            };
            self.mesh.panels.extend(panel);
        }
    }

    /// Adds a point at the mean of points of the skin.
    fn add(&mut self, of: Vec<usize>) -> usize {
        let sum: Vector3<f64> = of.iter().map(|&n| self.mesh.points[n].coords).sum();
        self.mesh.points.push(Point3::from(sum / of.len() as f64));
        self.cover.push(of);
        self.mesh.points.len() - 1
    }

    /// Adds the midpoint between a point of the skin and one of the cover; it follows the motion of the rim likewise.
    fn half_way(&mut self, corner: usize, middle: usize) -> usize {
        let at = nalgebra::center(&self.mesh.points[corner], &self.mesh.points[middle]);
        let place = self.add(vec![corner]);
        self.mesh.points[place] = at;
        place
    }

    /// Maps modal displacements from the skin's points to all points, both (3 x points) x modes.
    pub fn motion(&self, skin: &Surface, modes: &DMatrix<f32>) -> DMatrix<f64> {
        let known = skin.points.len();
        DMatrix::from_fn(3 * self.mesh.points.len(), modes.ncols(), |row, mode| {
            let (point, axis) = (row / 3, row % 3);
            let of_skin = |n: usize| f64::from(modes[(3 * n + axis, mode)]);
            match point.checked_sub(known) {
                None => of_skin(point),
                Some(added) => {
                    let of = &self.cover[added];
                    of.iter().map(|&n| of_skin(n)).sum::<f64>() / of.len() as f64
                }
            }
        })
    }
}

/// A side of a rim: its ends, and the mid-side node if there is one.
#[derive(Clone, Copy, Debug)]
struct Side {
    ends: [usize; 2],
    between: Option<usize>,
}

/// The rims along which panels end, if each is a simple closed line that is star-shaped about its centre.
fn mouth(points: &[Point3<f64>], panels: &[Panel]) -> Option<Vec<Vec<Side>>> {
    let mut sides: BTreeMap<(usize, usize), Vec<Side>> = BTreeMap::new();
    for panel in panels {
        let (c, nodes) = (panel.corners(), panel.nodes());
        for k in 0..c.len() {
            let ends = [c[k], c[(k + 1) % c.len()]];
            let between = nodes.get(c.len() + k).copied();
            let key = (ends[0].min(ends[1]), ends[0].max(ends[1]));
            sides.entry(key).or_default().push(Side { ends, between });
        }
    }
    let mut from: BTreeMap<usize, Side> = BTreeMap::new();
    for side in sides.into_values().filter(|users| users.len() == 1).flatten() {
        if from.insert(side.ends[0], side).is_some() {
            return None;
        }
    }
    let mut rims = Vec::new();
    while let Some((&start, _)) = from.iter().next() {
        let (mut rim, mut at) = (Vec::new(), start);
        while let Some(side) = from.remove(&at) {
            at = side.ends[1];
            rim.push(side);
        }
        let middle = rim.iter().map(|side| points[side.ends[0]].coords).sum::<Vector3<f64>>() / rim.len() as f64;
        let seen = |side: &Side| {
            let [a, b] = side.ends.map(|n| points[n].coords);
            (a - b).cross(&(middle - b)).z < 0.0
        };
        if at != start || !rim.iter().all(seen) {
            return None;
        }
        rims.push(rim);
    }
    (!rims.is_empty()).then_some(rims)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bem::Boundary;
    use nailnoise_meshes::{Grid, Mesh};

    /// A cube of 3 x 3 x 3 elements with a bore of depth two elements from below; its underside is at the given height.
    fn bored(height: f64) -> Mesh {
        let line = |from: f64| -> Vec<f64> { (0..4).map(|i| from + f64::from(i)).collect() };
        let grid = Grid::new(line(-1.5), line(-1.5), line(height)).unwrap();
        let bore = |[x, y, z]: [usize; 3]| x == 1 && y == 1 && z < 2;
        grid.mesh(&["cube"], |cell| (!bore(cell)).then_some(0), |_, _, _, _| "all")
    }

    #[test]
    fn the_mouth_of_the_nose_is_closed_by_a_cover_that_moves_with_it() {
        let mesh = bored(0.0);
        let skin = Surface::of(&mesh);
        // Translations along x and z, and a uniform expansion of the outline.
        let modes = DMatrix::from_fn(3 * skin.points.len(), 3, |row, mode| match (mode, row % 3) {
            (0, 0) | (1, 2) => 1.0,
            (2, axis) => skin.points[row / 3][axis] as f32,
            _ => 0.0,
        });
        for floor in [None, Some(-0.5)] {
            let outline = ClosedOutline::new(&skin, floor).unwrap();
            let motion = outline.motion(&skin, &modes);
            let boundary = Boundary::new(outline.mesh, floor).unwrap();
            assert_eq!(boundary.repairs().flipped, 0);
            assert!(
                (boundary.mesh().area() - 54.0).abs() < 1e-9,
                "{}",
                boundary.mesh().area()
            );
            let v = boundary.project_displacements(&motion).unwrap();
            let flows = [0, 1, 2].map(|mode| {
                let (mut row, mut flow) = (0, 0.0);
                for (p, panel) in boundary.mesh().panels.iter().enumerate() {
                    let corners = panel.corners().len();
                    let mean = (row..row + corners).map(|r| v[(r, mode)]).sum::<f64>() / corners as f64;
                    flow += mean * boundary.mesh().panel_area(p);
                    row += corners;
                }
                flow
            });
            assert!(
                flows[0].abs() + flows[1].abs() < 1e-9 && (flows[2] - 81.0).abs() < 1e-9,
                "{flows:?}"
            );
        }
        // If the nose touches the floor, the floor closes its mouth. If the tip is not at z = 0, the mouth remains
        // open.
        let area = |skin: &Surface, floor| ClosedOutline::new(skin, floor).unwrap().mesh.area();
        assert!((area(&skin, Some(0.0)) - 45.0).abs() < 1e-9);
        assert!((area(&Surface::of(&bored(-0.5)), None) - 62.0).abs() < 1e-9);
    }
}
