//! Boundary-element surfaces with known exterior fields.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use nailnoise_acoustics::bem::{BoundaryMesh, Panel};
use nailnoise_meshes::FaceKind;
use nalgebra::{Point3, Vector3};

/// Points merged by position.
#[derive(Default)]
struct Points {
    points: Vec<Point3<f64>>,
    index: HashMap<[i64; 3], usize>,
}

impl Points {
    fn at(&mut self, p: Vector3<f64>) -> usize {
        let key = [p.x, p.y, p.z].map(|c| (c * 1e8).round() as i64);
        *self.index.entry(key).or_insert_with(|| {
            self.points.push(Point3::from(p));
            self.points.len() - 1
        })
    }

    fn mesh(self, panels: Vec<Panel>) -> BoundaryMesh {
        BoundaryMesh {
            points: self.points,
            panels,
            patches: vec!["surface".to_owned()],
        }
    }
}

/// A unit sphere of curved panels between circles of latitude, `rings` from pole to pole and `around` on each.
pub(super) fn sphere(rings: usize, around: usize) -> BoundaryMesh {
    let mut points = Points::default();
    let mut at = |[i, j]: [usize; 2]| {
        let (theta, phi) = (PI * i as f64 / (2 * rings) as f64, TAU * j as f64 / (2 * around) as f64);
        let (radius, height) = theta.sin_cos();
        points.at(Vector3::new(radius * phi.cos(), radius * phi.sin(), height))
    };
    let mut panels = Vec::new();
    for ring in 0..rings {
        for sector in 0..around {
            let (i, j) = (2 * ring, 2 * sector);
            let (kind, lattice) = match ring {
                0 => (
                    FaceKind::Tri6,
                    [[0, 0], [2, 0], [2, 2], [1, 0], [2, 1], [1, 2]].to_vec(),
                ),
                _ if ring + 1 == rings => (
                    FaceKind::Tri6,
                    [[0, 0], [2, 0], [0, 2], [1, 0], [1, 2], [0, 1]].to_vec(),
                ),
                _ => (
                    FaceKind::Quad9,
                    [[0, 0], [2, 0], [2, 2], [0, 2], [1, 0], [2, 1], [1, 2], [0, 1], [1, 1]].to_vec(),
                ),
            };
            let nodes: Vec<usize> = lattice.iter().map(|[a, b]| at([i + a, j + b])).collect();
            panels.extend(Panel::new(kind, &nodes, 0));
        }
    }
    points.mesh(panels)
}

/// A quarter of a unit disc in the plane z = 0 between the planes x = 0 and y = 0, normals along z. Its n² curved
/// triangles become narrow towards the rim, where the velocity of the fluid has a root singularity.
pub(super) fn quarter_disc(n: usize) -> BoundaryMesh {
    let mut points = Points::default();
    let mut at = |[u, v]: [usize; 2]| {
        let r = (u + v) as f64;
        let angle = if u + v == 0 { 0.0 } else { 0.5 * PI * v as f64 / r };
        points.at(Vector3::new(angle.cos(), angle.sin(), 0.0) * (0.5 * PI * r / (2 * n) as f64).sin())
    };
    let mut panels = Vec::new();
    let mut push = |p: [[usize; 2]; 3]| {
        let mut nodes: Vec<usize> = p.iter().map(|[u, v]| at([2 * u, 2 * v])).collect();
        for m in 0..3 {
            let (q, r) = (p[m], p[(m + 1) % 3]);
            nodes.push(at([q[0] + r[0], q[1] + r[1]]));
        }
        panels.extend(Panel::new(FaceKind::Tri6, &nodes, 0));
    };
    for u in 0..n {
        for v in 0..n - u {
            push([[u, v], [u + 1, v], [u, v + 1]]);
            if u + v + 1 < n {
                push([[u + 1, v], [u + 1, v + 1], [u, v + 1]]);
            }
        }
    }
    points.mesh(panels)
}
