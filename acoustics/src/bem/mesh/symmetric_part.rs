//! The part of a symmetric surface that represents the complete surface. Even and odd motions are solved separately,
//! each only on this part.

use super::panel::{BoundaryMesh, Panel};
use super::symmetry::Parity;
use nalgebra::{DMatrix, Point3};
use rayon::prelude::*;
use std::collections::{HashMap, HashSet};

/// Distance along an axis within which a point and the image of another coincide, relative to the surface's largest
/// extent.
const SAME_POINT: f64 = 1e-8;

/// A surface, or its part above the symmetry planes of constant x and y.
#[derive(Clone, Debug)]
pub struct SymmetricPart {
    /// All points of the surface, and the panels of the part.
    pub mesh: BoundaryMesh,
    /// The planes of constant x and y \[m\].
    mirrors: [Option<f64>; 2],
    /// For each of these planes, the image of each point; unused points are their own images.
    images: [Vec<usize>; 2],
}

impl SymmetricPart {
    /// Finds the planes through the middle of the surface about which its points and panels are mirror images of each
    /// other, and retains only the part above them. A surface without such a plane remains complete.
    pub fn of(mesh: BoundaryMesh) -> Self {
        let mut part = Self {
            mesh,
            mirrors: [None; 2],
            images: [Vec::new(), Vec::new()],
        };
        for axis in 0..2 {
            let Some((plane, images)) = mirror(&part.mesh, axis) else {
                continue;
            };
            let middle = |points: &[Point3<f64>], corners: &[usize]| {
                corners.iter().map(|&corner| points[corner][axis]).sum::<f64>() / corners.len() as f64
            };
            let BoundaryMesh { points, panels, .. } = &mut part.mesh;
            panels.retain(|panel| middle(points, panel.corners()) > plane);
            part.mirrors[axis] = Some(plane);
            part.images[axis] = images;
        }
        part
    }

    /// The planes of constant x and y \[m\].
    pub fn mirrors(&self) -> [Option<f64>; 2] {
        self.mirrors
    }

    /// Decomposes the displacements of the part's points, (3 x points) x modes, into components of every parity. With
    /// the displacement u' of the image point and the reflection S, the even component is (u + S u')/2 and the odd
    /// component (u - S u')/2.
    pub fn by_parity(&self, displacements: DMatrix<f64>) -> Vec<(Parity, DMatrix<f64>)> {
        let mut parts = vec![(Parity::default(), displacements)];
        for axis in (0..2).filter(|&axis| self.mirrors[axis].is_some()) {
            let of_parity = |odd: bool, u: &DMatrix<f64>| {
                let mut part = DMatrix::zeros(u.nrows(), u.ncols());
                for (mut to, from) in part.column_iter_mut().zip(u.column_iter()) {
                    for row in 0..from.len() {
                        let (point, component) = (row / 3, row % 3);
                        let image = from[3 * self.images[axis][point] + component];
                        let opposite = odd != (component == axis);
                        to[row] = 0.5 * (from[row] + if opposite { -image } else { image });
                    }
                }
                part
            };
            let both = parts.par_iter().flat_map(|part| [(false, part), (true, part)]);
            parts = both
                .map(|(odd, (parity, u))| (parity.with(axis, odd), of_parity(odd, u)))
                .collect();
        }
        parts
    }
}

/// The plane perpendicular to an axis in the middle of the panels, and the image of every point. None if the panels are
/// not mirror images of each other, or if a panel lies on both sides of the plane.
fn mirror(mesh: &BoundaryMesh, axis: usize) -> Option<(f64, Vec<usize>)> {
    let used: HashSet<usize> = mesh.panels.iter().flat_map(|panel| panel.nodes()).copied().collect();
    let bounds = |axis: usize| {
        let along = used.iter().map(|&point| mesh.points[point][axis]);
        along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
            [low.min(x), high.max(x)]
        })
    };
    let extent = (0..3).map(bounds).map(|[low, high]| high - low).fold(0.0, f64::max);
    let [low, high] = bounds(axis);
    let (plane, unit) = (0.5 * (low + high), SAME_POINT * extent);
    let cell = |point: usize, sign: f64| {
        let mut at = mesh.points[point].coords;
        at[axis] = sign * (at[axis] - plane);
        [0, 1, 2].map(|k| (at[k] / unit).round() as i64)
    };
    let places: HashMap<[i64; 3], usize> = used.iter().map(|&point| (cell(point, 1.0), point)).collect();
    let mut images: Vec<usize> = (0..mesh.points.len()).collect();
    for &point in &used {
        images[point] = near(&places, cell(point, -1.0))?;
    }
    let sorted = |mut nodes: Vec<usize>, patch: usize| {
        nodes.sort_unstable();
        (patch, nodes)
    };
    let own = |panel: &Panel| sorted(panel.nodes().to_vec(), panel.patch);
    let panels: HashSet<(usize, Vec<usize>)> = mesh.panels.iter().map(own).collect();
    let symmetric = mesh.panels.iter().all(|panel| {
        let image = panel.nodes().iter().map(|&node| images[node]).collect();
        let side = |&node: &usize| mesh.points[node][axis] - plane;
        let on_one_side =
            panel.nodes().iter().all(|node| side(node) >= -unit) || panel.nodes().iter().all(|node| side(node) <= unit);
        on_one_side && panels.contains(&sorted(image, panel.patch))
    });
    symmetric.then_some((plane, images))
}

/// The point in a cell or a neighbouring one, because rounding may put coincident points into different cells.
fn near(places: &HashMap<[i64; 3], usize>, cell: [i64; 3]) -> Option<usize> {
    let beside = (0..27).map(|k| [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1]);
    let mut cells = std::iter::once([0; 3]).chain(beside);
    cells.find_map(|step| {
        let cell = [0, 1, 2].map(|axis| cell[axis] + step[axis]);
        places.get(&cell).copied()
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::Air;
    use crate::bem::{Boundary, Exterior, Patterns, SolidBox};
    use nailnoise_meshes::FaceKind;

    /// A box of 0.4 x 0.6 x 0.2 m at a given position, with panels of 0.1 m.
    fn solid(at: [f64; 2]) -> BoundaryMesh {
        let solid = SolidBox {
            part: 0,
            low: [at[0] - 0.2, at[1] - 0.3, 0.1],
            high: [at[0] + 0.2, at[1] + 0.3, 0.3],
        };
        BoundaryMesh::of_boxes(&[solid], [None; 3], 0.11, vec!["box".to_owned()], |_| 0).unwrap()
    }

    /// Displacements without any symmetry.
    fn motion(mesh: &BoundaryMesh) -> DMatrix<f64> {
        DMatrix::from_fn(3 * mesh.points.len(), 2, |row, mode| {
            let at = mesh.points[row / 3];
            (3.0 * at.x + 5.0 * at.y + 7.0 * at.z + (row % 3 + 2 * mode) as f64).sin()
        })
    }

    #[test]
    fn a_box_has_two_mirror_planes_wherever_it_is() {
        let whole = solid([1.0, -2.0]);
        let part = SymmetricPart::of(whole.clone());
        for (mirror, middle) in part.mirrors().into_iter().zip([1.0, -2.0]) {
            assert!((mirror.unwrap() - middle).abs() < 1e-12);
        }
        assert_eq!(4 * part.mesh.panels.len(), whole.panels.len());
    }

    #[test]
    fn a_surface_without_symmetry_stays_whole() {
        let mut whole = solid([0.0; 2]);
        let corner = whole.panels[0].corners()[0];
        whole.points[corner].x += 1e-3;
        whole.points[corner].y += 1e-3;
        let part = SymmetricPart::of(whole.clone());
        assert_eq!(
            (part.mirrors(), part.mesh.panels.len()),
            ([None; 2], whole.panels.len())
        );
    }

    #[test]
    fn each_part_of_the_displacements_has_its_parity() {
        let whole = solid([1.0, -2.0]);
        let part = SymmetricPart::of(whole.clone());
        let corner = |sign: [f64; 2]| {
            let there = |p: &&Point3<f64>| {
                (p.x - 1.0 - 0.2 * sign[0]).abs() < 1e-9 && (p.y + 2.0 - 0.3 * sign[1]).abs() < 1e-9 && p.z > 0.25
            };
            whole.points.iter().position(|p| there(&p)).unwrap()
        };
        let u = motion(&whole);
        for (parity, of_part) in part.by_parity(u.clone()) {
            // The mean over the four images of a corner, each reflected back with its sign.
            for component in 0..3 {
                let terms = [[1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]].map(|at| {
                    let sign = |axis: usize, odd: bool| {
                        let changes = (at[axis] < 0.0) && (odd != (component == axis));
                        if changes { -1.0 } else { 1.0 }
                    };
                    sign(0, parity.odd_x) * sign(1, parity.odd_y) * u[(3 * corner(at) + component, 1)]
                });
                let expected = terms.iter().sum::<f64>() / 4.0;
                let found = of_part[(3 * corner([1.0, 1.0]) + component, 1)];
                assert!((found - expected).abs() < 1e-15, "{parity:?}: {found} {expected}");
            }
        }
    }

    /// The panels of a box as triangles, arranged symmetrically only about its plane of constant y.
    fn triangles(quadrilaterals: BoundaryMesh, plane: f64) -> BoundaryMesh {
        let mut mesh = quadrilaterals;
        let cut = |panel: &Panel| {
            let corners = panel.corners();
            let key = |k: &usize| {
                let at = mesh.points[corners[*k]];
                at.x + 2.0 * (at.y - plane).abs() + 3.0 * at.z
            };
            let first = (0..4).min_by(|a, b| key(a).total_cmp(&key(b))).unwrap();
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| corners[(first + k) % 4]);
            [[a, b, c], [a, c, d]].map(|nodes| Panel::new(FaceKind::Tri3, &nodes, panel.patch).unwrap())
        };
        mesh.panels = mesh.panels.iter().flat_map(cut).collect();
        mesh
    }

    #[test]
    fn the_part_radiates_the_power_of_the_whole() {
        let lopsided = triangles(solid([1.0, -2.0]), -2.0);
        assert_eq!(SymmetricPart::of(lopsided.clone()).mirrors()[0], None);
        for (whole, floor) in [(solid([0.0; 2]), None), (lopsided.clone(), None), (lopsided, Some(0.0))] {
            let (hz, part) = (300.0, SymmetricPart::of(whole.clone()));
            assert!(part.mirrors()[1].is_some());
            let u = motion(&whole);
            let power = |boundary: Boundary, motions: Vec<(Parity, DMatrix<f64>)>| {
                let patterns: Vec<Patterns> = motions
                    .into_iter()
                    .map(|(parity, u)| Patterns {
                        parity,
                        velocities: boundary.project_displacements(&u).unwrap(),
                    })
                    .collect();
                let problem = Exterior::new(boundary, &Air::default());
                let found = problem.resistance_parities(hz, &patterns).unwrap();
                found.into_iter().map(|two| two.far_field).sum::<DMatrix<f64>>()
            };
            let whole = Boundary::new(whole, floor).unwrap();
            let of_whole = power(whole, vec![(Parity::default(), u.clone())]);
            let boundary = Boundary::symmetric(part.mesh.clone(), part.mirrors(), floor).unwrap();
            let of_part = power(boundary, part.by_parity(u));
            let error = (&of_part - &of_whole).amax() / of_whole.amax();
            println!("error of the part {error:.1e}");
            assert!(error < 1e-4);
        }
    }

    #[test]
    fn a_surface_with_panels_across_its_middle_stays_whole() {
        let solid = SolidBox {
            part: 0,
            low: [0.0, 0.0, 0.0],
            high: [0.3, 0.3, 0.3],
        };
        let whole = BoundaryMesh::of_boxes(&[solid], [None; 3], 0.11, vec!["box".to_owned()], |_| 0).unwrap();
        assert_eq!(SymmetricPart::of(whole).mirrors(), [None; 2]);
    }
}
