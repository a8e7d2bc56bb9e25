//! Which faces of a body meet the open air: those of its outline, not those of cavities within it.

use std::f64::consts::PI;

use nailnoise_meshes::{MeshError, Surface};
use nalgebra::{Point3, Vector3};

/// Share of the full solid angle above which a point counts as inside a closed surface.
const INSIDE: f64 = 0.5;

/// How far from the floor a face on it may be, as a share of the body's size.
const ON_FLOOR: f64 = 1e-6;

/// Whether each face of a skin meets the open air.
///
/// The skin falls into closed pieces that share no point. A piece around a cavity has its normals inwards, so that the
/// volume, the closed integral of z n_z dS, is negative; a body within another one's cavity has points at which that one's
/// outline fills the whole solid angle. Neither is heard.
pub(crate) fn open_air(surface: &Surface) -> Result<Vec<bool>, MeshError> {
    open_air_above(surface, None)
}

/// The same for a body that may stand on a rigid floor at a height \[m\]: what lies on it is covered, and it closes the
/// bores that open towards it.
pub(crate) fn open_air_above(surface: &Surface, floor: Option<f64>) -> Result<Vec<bool>, MeshError> {
    let size = surface.points.iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
    let covered: Vec<bool> = surface
        .faces
        .iter()
        .map(|face| {
            floor.is_some_and(|floor| {
                face.nodes
                    .iter()
                    .all(|&n| (surface.points[n].z - floor).abs() <= ON_FLOOR * size)
            })
        })
        .collect();
    let piece = pieces(surface, &covered);
    let count = piece.iter().max().map_or(0, |last| last + 1);
    let mut volume = vec![0.0; count];
    let points = surface.quadrature(3)?;
    for point in &points {
        if !covered[point.face] {
            // Measured from the floor, in whose plane the piece may be open.
            volume[piece[point.face]] += (point.position.z - floor.unwrap_or(0.0)) * point.normal.z * point.weight;
        }
    }
    let mut outline: Vec<bool> = volume.iter().map(|&v| v > 0.0).collect();
    for (inner, heard) in outline.iter_mut().enumerate() {
        let Some(at) = (0..piece.len()).find(|&f| piece[f] == inner) else {
            continue;
        };
        let at = surface.points[surface.faces[at].nodes[0]];
        let within = |outer: usize| {
            outer != inner && volume[outer] > 0.0 && solid_angle(surface, &piece, outer, at) > INSIDE * 4.0 * PI
        };
        *heard &= !(0..count).any(within);
    }
    Ok(piece
        .iter()
        .zip(covered)
        .map(|(&p, covered)| outline[p] && !covered)
        .collect())
}

/// The piece of each face: faces of one piece are joined through common points, but not through covered faces.
fn pieces(surface: &Surface, covered: &[bool]) -> Vec<usize> {
    let mut root: Vec<usize> = (0..surface.points.len()).collect();
    fn find(root: &mut [usize], mut i: usize) -> usize {
        while root[i] != i {
            root[i] = root[root[i]];
            i = root[i];
        }
        i
    }
    for (face, _) in surface.faces.iter().zip(covered).filter(|(_, covered)| !**covered) {
        let first = find(&mut root, face.nodes[0]);
        for &node in face.nodes.iter() {
            let other = find(&mut root, node);
            root[other] = first;
        }
    }
    let mut numbers = vec![usize::MAX; root.len()];
    let mut next = 0;
    surface
        .faces
        .iter()
        .map(|face| {
            let piece = find(&mut root, face.nodes[0]);
            if numbers[piece] == usize::MAX {
                numbers[piece] = next;
                next += 1;
            }
            numbers[piece]
        })
        .collect()
}

/// Solid angle of a piece from a point, 4 pi inside and 0 outside, its faces taken as flat triangles:
/// tan(omega/2) = a . (b x c) / (abc + (a . b) c + (b . c) a + (c . a) b) (van Oosterom and Strackee, 1983).
fn solid_angle(surface: &Surface, piece: &[usize], wanted: usize, from: Point3<f64>) -> f64 {
    let mut sum = 0.0;
    for (face, _) in surface.faces.iter().zip(piece).filter(|&(_, &p)| p == wanted) {
        let at = |corner: usize| -> Vector3<f64> { surface.points[face.nodes[corner]] - from };
        for k in 1..face.kind.corners() - 1 {
            let (a, b, c) = (at(0), at(k), at(k + 1));
            let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
            let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
            sum += 2.0 * a.dot(&b.cross(&c)).atan2(below);
        }
    }
    sum
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use nailnoise_meshes::{Block, Mesh, block};

    fn cube(size: f64, centre: f64) -> Mesh {
        block(&Block {
            size: [size; 3],
            divisions: [2; 3],
            origin: [centre - 0.5 * size; 3],
        })
        .unwrap()
    }

    #[test]
    fn the_outline_is_heard_a_cavity_and_what_floats_in_it_are_not() {
        // A cube with a cubic hole: of 5 x 5 x 5 elements the one in the middle is taken out.
        let mut mesh = block(&Block {
            size: [1.0; 3],
            divisions: [5; 3],
            origin: [-0.5; 3],
        })
        .unwrap();
        let centre = mesh.elements().position(|e| {
            let mean: Vector3<f64> = e.nodes[..8].iter().map(|&n| mesh.nodes[n].coords).sum::<Vector3<f64>>() / 8.0;
            mean.norm() < 1e-9
        });
        mesh = without(&mesh, centre.unwrap());
        mesh.join(&cube(0.1, 0.0)); // floats in the hole
        mesh.join(&cube(0.3, 2.0)); // stands beside
        let surface = Surface::of(&mesh);
        let open = open_air(&surface).unwrap();
        let mut area = 0.0;
        for point in surface.quadrature(2).unwrap() {
            if open[point.face] {
                area += point.weight;
            }
        }
        assert!((area - (6.0 + 6.0 * 0.09)).abs() < 1e-12, "{area}");
        assert!((surface.area() - area - 6.0 * 0.04 - 6.0 * 0.01).abs() < 1e-12);
    }

    #[test]
    fn a_floor_closes_the_bores_that_open_towards_it() {
        // A cube with a bore from below: of 3 x 3 x 3 elements the two lower ones in the middle are taken out.
        let mut mesh = block(&Block {
            size: [3.0; 3],
            divisions: [3; 3],
            origin: [-1.5, -1.5, 0.0],
        })
        .unwrap();
        for height in [1.5, 0.5] {
            let bored = mesh.elements().position(|e| {
                let mean = e.nodes[..8].iter().map(|&n| mesh.nodes[n].coords).sum::<Vector3<f64>>() / 8.0;
                (mean - Vector3::new(0.0, 0.0, height)).norm() < 1e-9
            });
            mesh = without(&mesh, bored.unwrap());
        }
        let surface = Surface::of(&mesh);
        let heard = |floor: Option<f64>| -> f64 {
            let open = open_air_above(&surface, floor).unwrap();
            surface
                .quadrature(2)
                .unwrap()
                .iter()
                .filter(|p| open[p.face])
                .map(|p| p.weight)
                .sum()
        };
        assert!((heard(None) - (54.0 + 8.0)).abs() < 1e-12);
        assert!((heard(Some(-0.1)) - (54.0 + 8.0)).abs() < 1e-12);
        assert!((heard(Some(0.0)) - 45.0).abs() < 1e-12);
    }

    pub(in crate::pipeline) fn without(mesh: &Mesh, element: usize) -> Mesh {
        let mut kept = mesh.clone();
        let nodes = mesh.offsets[element]..mesh.offsets[element + 1];
        let gone = nodes.len();
        kept.connectivity.drain(nodes);
        kept.kinds.remove(element);
        kept.parts.remove(element);
        kept.offsets.remove(element);
        kept.offsets[element..].iter_mut().for_each(|o| *o -= gone);
        kept.groups.clear(); // they name elements by their old numbers
        kept
    }
}
