//! Smooth faces of a skin: recovers the faces of the original geometry from a mesh.

use std::collections::HashMap;

use nalgebra::{Point3, Vector3};

use crate::locate::project;
use crate::quality::root;
use crate::{FaceKind, MeshError, Surface};

/// A smooth face of a skin: element faces joined at edges across which the normal changes little.
#[derive(Clone, Debug, PartialEq)]
pub struct SmoothFace {
    /// Its faces, indices into [`Surface::faces`], ascending.
    pub faces: Vec<usize>,
    /// Its area \[m2\].
    pub area: f64,
    /// Its centroid \[m\].
    pub centroid: Point3<f64>,
    /// Area-weighted mean of its outward unit normals: of length 1 for a plane, 0 for a closed cylinder.
    pub normal: Vector3<f64>,
}

impl Surface {
    /// Finds the smooth faces of the skin: element faces are joined at edges where the normals on both sides differ by
    /// less than `angle` \[rad\]. Normals are those of the curved faces at the edge's midpoint.
    ///
    /// # Errors
    /// [`MeshError::GaussPoints`]; does not occur for the existing kinds of faces.
    pub fn smooth_faces(&self, angle: f64) -> Result<Vec<SmoothFace>, MeshError> {
        let mut edges: HashMap<(usize, usize), Vec<EdgeSide>> = HashMap::new();
        for (index, face) in self.faces.iter().enumerate() {
            let corners = face.kind.corners();
            for k in 0..corners {
                let (a, b) = (face.nodes[k], face.nodes[(k + 1) % corners]);
                let normal = self.point_at(index, middle_of_edge(face.kind, k)).normal;
                edges.entry((a.min(b), a.max(b))).or_default().push((index, normal));
            }
        }
        let mut parent: Vec<usize> = (0..self.faces.len()).collect();
        for sides in edges.values() {
            // Four faces meet where solids touch along an edge.
            if let &[(a, normal_a), (b, normal_b)] = &sides[..]
                && normal_a.dot(&normal_b) > angle.cos()
            {
                let (a, b) = (root(&mut parent, a), root(&mut parent, b));
                parent[a.max(b)] = a.min(b);
            }
        }
        let mut number: HashMap<usize, usize> = HashMap::new();
        let mut smooth: Vec<SmoothFace> = Vec::new();
        let mut smooth_of = Vec::with_capacity(self.faces.len());
        for index in 0..self.faces.len() {
            let own = *number.entry(root(&mut parent, index)).or_insert_with(|| {
                smooth.push(SmoothFace {
                    faces: Vec::new(),
                    area: 0.0,
                    centroid: Point3::origin(),
                    normal: Vector3::zeros(),
                });
                smooth.len() - 1
            });
            smooth[own].faces.push(index);
            smooth_of.push(own);
        }
        for point in self.quadrature(3)? {
            let own = &mut smooth[smooth_of[point.face]];
            own.area += point.weight;
            own.centroid += point.weight * point.position.coords;
            own.normal += point.weight * point.normal;
        }
        for own in &mut smooth {
            own.centroid /= own.area;
            own.normal /= own.area;
        }
        Ok(smooth)
    }

    /// The face nearest to a point among those for which `wanted` is true, and its distance \[m\].
    pub fn nearest_face(&self, point: Point3<f64>, wanted: impl Fn(usize) -> bool) -> Option<(usize, f64)> {
        let distance = |index: usize| {
            let face = &self.faces[index];
            let nodes: Vec<Point3<f64>> = face.nodes.iter().map(|&n| self.points[n]).collect();
            let (xi, _) = project(face.kind, &nodes, point);
            let foot = self.point_at(index, clamped(face.kind, xi.into())).position;
            // Newton's method may fail for a distant face; the distance to its nodes is then the better estimate.
            let of_nodes = nodes.iter().map(|node| (node - point).norm());
            of_nodes.fold((foot - point).norm(), f64::min)
        };
        let each = (0..self.faces.len()).filter(|&index| wanted(index));
        each.map(|index| (index, distance(index)))
            .min_by(|(_, a), (_, b)| a.total_cmp(b))
    }
}

/// A face adjacent to an edge, with its normal at the edge's midpoint.
type EdgeSide = (usize, Vector3<f64>);

/// Natural coordinates of the midpoint of an edge, which starts at the corner with the same number.
fn middle_of_edge(kind: FaceKind, edge: usize) -> [f64; 2] {
    let corners = kind.natural_nodes();
    let (a, b) = (corners[edge], corners[(edge + 1) % kind.corners()]);
    [0, 1].map(|axis| 0.5 * (a[axis] + b[axis]))
}

/// Natural coordinates clamped to the face.
fn clamped(kind: FaceKind, xi: [f64; 2]) -> [f64; 2] {
    if kind.corners() == 4 {
        return xi.map(|v| v.clamp(-1.0, 1.0));
    }
    let inside = xi.map(|v| v.max(0.0));
    let sum = (inside[0] + inside[1]).max(1.0);
    inside.map(|v| v / sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Block, block};
    use std::f64::consts::{PI, TAU};

    fn rounded(points: usize) -> Surface {
        // A strip bent to half a cylinder with radii 1 and 1.2, so that it has both curved and flat faces.
        let mut mesh = block(&Block {
            size: [1.0, 0.2, 0.5],
            divisions: [points, 1, 2],
            origin: [0.0, 1.0, 0.0],
        })
        .unwrap();
        for p in &mut mesh.nodes {
            let (angle, r) = (PI * p.x, p.y);
            (p.x, p.y) = (r * angle.sin(), r * angle.cos());
        }
        Surface::of(&mesh)
    }

    #[test]
    fn a_bent_bar_has_the_six_faces_of_its_drawing_on_any_mesh() {
        for divisions in [4, 12] {
            let smooth = rounded(divisions).smooth_faces(PI / 6.0).unwrap();
            assert_eq!(smooth.len(), 6);
            let mut areas: Vec<f64> = smooth.iter().map(|face| face.area).collect();
            areas.sort_by(f64::total_cmp);
            let ring = 0.5 * PI * (1.2_f64.powi(2) - 1.0);
            let expected = [0.1, 0.1, ring, ring, 0.25 * TAU, 0.25 * TAU * 1.2];
            for (found, expected) in areas.iter().zip(expected) {
                assert!((found / expected - 1.0).abs() < 1e-3, "{divisions}: {found} {expected}");
            }
        }
    }

    #[test]
    fn the_normal_of_a_plane_has_length_1_and_that_of_a_bend_is_shorter() {
        let smooth = rounded(8).smooth_faces(PI / 6.0).unwrap();
        let plane = |face: &&SmoothFace| (face.normal.norm() - 1.0).abs() < 1e-9;
        assert_eq!(smooth.iter().filter(plane).count(), 4);
        // The mean of the normals over half a turn is 2/pi.
        let bent: Vec<f64> = smooth
            .iter()
            .map(|face| face.normal.norm())
            .filter(|n| *n < 0.9)
            .collect();
        assert!(
            bent.len() == 2 && bent.iter().all(|n| (n - 2.0 / PI).abs() < 2e-3),
            "{bent:?}"
        );
    }

    #[test]
    fn the_nearest_face_is_found_with_its_distance() {
        let surface = rounded(8);
        let (face, distance) = surface.nearest_face(Point3::new(1.5, 0.0, 0.25), |_| true).unwrap();
        assert!((distance - 0.3).abs() < 1e-3, "{distance}");
        assert!(surface.point_at(face, surface.faces[face].kind.centre()).normal.x > 0.9);
    }
}
