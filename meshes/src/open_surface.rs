//! Finds the faces of a body that are exposed to the open air: those of its outer surface, not of internal cavities.

use std::f64::consts::PI;

use nalgebra::{Point3, Vector3};

use crate::{MeshError, Surface};

/// Fraction of the full solid angle above which a point counts as inside a closed surface.
const INSIDE: f64 = 0.5;

/// Tolerance for a face to count as lying on the floor, as a fraction of the body's size.
const ON_FLOOR: f64 = 1e-6;

/// For each face of a skin, whether it is exposed to the open air. The body is in free space or above a rigid floor at
/// the given height \[m\].
///
/// The skin consists of closed pieces that share no points. The normals of a piece around a cavity point inwards, so
/// that its volume, the closed integral of z n_z dS, is negative. For a body within the cavity of another, the outer
/// surface of the latter subtends the full solid angle. Neither radiates into the open air. The floor covers faces that
/// lie on it and closes bores that open onto it.
///
/// # Errors
/// [`MeshError::GaussPoints`] if a face has no quadrature rule.
pub fn open_faces(surface: &Surface, floor: Option<f64>) -> Result<Vec<bool>, MeshError> {
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
            // Heights are measured from the floor plane, because the piece may be open there.
            volume[piece[point.face]] += (point.position.z - floor.unwrap_or(0.0)) * point.normal.z * point.weight;
        }
    }
    let mut outline: Vec<bool> = volume.iter().map(|&v| v > 0.0).collect();
    for (inner, open) in outline.iter_mut().enumerate() {
        let extremes = extremes(surface, &piece, inner);
        // If a piece touches another one from outside, some of its extreme points do not lie on the shared faces.
        let within = |outer: usize| {
            outer != inner
                && volume[outer] > 0.0
                && extremes
                    .iter()
                    .all(|at| solid_angle(surface, &piece, outer, *at) > INSIDE * 4.0 * PI)
        };
        *open &= !(0..count).any(within);
    }
    Ok(piece
        .iter()
        .zip(covered)
        .map(|(&p, covered)| outline[p] && !covered)
        .collect())
}

/// The piece of each face: faces of one piece are connected through common points, but not through covered faces.
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

/// The extreme points of a piece in both directions of each axis.
fn extremes(surface: &Surface, piece: &[usize], wanted: usize) -> Vec<Point3<f64>> {
    let faces = surface.faces.iter().zip(piece).filter(|&(_, &p)| p == wanted);
    let points: Vec<Point3<f64>> = faces
        .flat_map(|(face, _)| face.nodes.iter().map(|&node| surface.points[node]))
        .collect();
    let along = |axis: usize, sign: f64| {
        let farther = |a: &&Point3<f64>, b: &&Point3<f64>| (sign * a[axis]).total_cmp(&(sign * b[axis]));
        points.iter().max_by(farther).copied()
    };
    (0..3)
        .flat_map(|axis| [-1.0, 1.0].map(|sign| along(axis, sign)))
        .flatten()
        .collect()
}

/// Solid angle subtended by a piece at a point: 4 pi inside and 0 outside. Faces are treated as flat triangles:
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
mod tests {
    use super::*;
    use crate::{Block, Grid, Mesh, block};

    fn cube(size: f64, centre: f64) -> Mesh {
        block(&Block {
            size: [size; 3],
            divisions: [2; 3],
            origin: [centre - 0.5 * size; 3],
        })
        .unwrap()
    }

    /// A cube of n x n x n elements, some of them empty, with its underside at z = `low`.
    fn hollow(n: usize, side: f64, low: f64, empty: &[[usize; 3]]) -> Mesh {
        let line = |from: f64| -> Vec<f64> { (0..=n).map(|i| from + side * i as f64 / n as f64).collect() };
        let grid = Grid::new(line(-0.5 * side), line(-0.5 * side), line(low)).unwrap();
        grid.mesh(
            &["cube"],
            |cell| (!empty.contains(&cell)).then_some(0),
            |_, _, _, _| "all",
        )
    }

    fn open_area(surface: &Surface, floor: Option<f64>) -> f64 {
        let open = open_faces(surface, floor).unwrap();
        let points = surface.quadrature(2).unwrap();
        points.iter().filter(|p| open[p.face]).map(|p| p.weight).sum()
    }

    #[test]
    fn the_outline_is_open_a_cavity_and_what_floats_in_it_are_not() {
        let mut mesh = hollow(5, 1.0, -0.5, &[[2, 2, 2]]);
        mesh.join(&cube(0.1, 0.0)); // inside the cavity
        mesh.join(&cube(0.3, 2.0)); // outside, separate
        let surface = Surface::of(&mesh);
        let area = open_area(&surface, None);
        assert!((area - (6.0 + 6.0 * 0.09)).abs() < 1e-12, "{area}");
        assert!((surface.area() - area - 6.0 * 0.04 - 6.0 * 0.01).abs() < 1e-12);
    }

    /// Seen from a point on a plane face, the body fills half of the full solid angle, up to rounding.
    #[test]
    fn a_piece_that_touches_another_one_is_open() {
        let mut mesh = cube(1.0, 0.0);
        let mut board = block(&Block {
            size: [0.5, 0.5, 0.1],
            divisions: [1; 3],
            origin: [-0.25, -0.25, 0.5],
        })
        .unwrap();
        for turned in [false, true] {
            if turned {
                board.nodes.iter_mut().for_each(|p| p.z = 1.1 - p.z);
                board.nodes.iter_mut().for_each(|p| p.x = -p.x);
            }
            let mut both = mesh.clone();
            both.join(&board);
            let area = open_area(&Surface::of(&both), None);
            assert!((area - (6.0 + 0.5 + 0.2)).abs() < 1e-12, "{area}");
        }
        mesh.join(&cube(0.3, 0.65));
        let area = open_area(&Surface::of(&mesh), None);
        assert!((area - (6.0 + 6.0 * 0.09)).abs() < 1e-12, "{area}");
    }

    #[test]
    fn a_floor_closes_the_bores_that_open_towards_it() {
        let surface = Surface::of(&hollow(3, 3.0, 0.0, &[[1, 1, 0], [1, 1, 1]]));
        assert!((open_area(&surface, None) - (54.0 + 8.0)).abs() < 1e-12);
        assert!((open_area(&surface, Some(-0.1)) - (54.0 + 8.0)).abs() < 1e-12);
        assert!((open_area(&surface, Some(0.0)) - 45.0).abs() < 1e-12);
    }
}
