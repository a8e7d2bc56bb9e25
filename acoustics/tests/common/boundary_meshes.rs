//! Surfaces with known exterior fields.
#![allow(dead_code, unreachable_pub, clippy::unwrap_used)]

use nailnoise_acoustics::bem::{BoundaryMesh, Panel};
use nailnoise_meshes::FaceKind;
use nalgebra::{Complex, Point3, Vector3};
use std::collections::HashMap;
use std::f64::consts::PI;

/// Points merged by position.
#[derive(Default)]
pub struct Points {
    pub points: Vec<Point3<f64>>,
    at: HashMap<[i64; 3], usize>,
}

impl Points {
    pub fn index(&mut self, p: Point3<f64>) -> usize {
        let key = [p.x, p.y, p.z].map(|c| (c * 1e8).round() as i64);
        *self.at.entry(key).or_insert_with(|| {
            self.points.push(p);
            self.points.len() - 1
        })
    }
}

const GOLDEN: f64 = 1.618_033_988_749_895;

/// Each face of the icosahedron cut into n² triangles, projected onto a sphere: 20 n² panels.
pub fn sphere(radius: f64, n: usize, quadratic: bool) -> BoundaryMesh {
    let mut corners = Vec::new();
    for a in [-1.0, 1.0] {
        for b in [-GOLDEN, GOLDEN] {
            corners.extend([
                Vector3::new(0.0, a, b),
                Vector3::new(a, b, 0.0),
                Vector3::new(b, 0.0, a),
            ]);
        }
    }
    let mut points = Points::default();
    let mut panels = Vec::new();
    let close = |a: Vector3<f64>, b: Vector3<f64>| (a - b).norm() < 2.1;
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                let (a, mut b, mut c) = (corners[i], corners[j], corners[k]);
                if !(close(a, b) && close(b, c) && close(a, c)) {
                    continue;
                }
                if a.cross(&b).dot(&c) < 0.0 {
                    std::mem::swap(&mut b, &mut c);
                }
                // Lattice of half steps: even numbers are corners, odd ones mid-sides.
                let mut at = |u: usize, v: usize| {
                    let (s, t) = (u as f64 / (2 * n) as f64, v as f64 / (2 * n) as f64);
                    let x = a * (1.0 - s - t) + b * s + c * t;
                    points.index(Point3::from(x.normalize() * radius))
                };
                let mut push = |p: [[usize; 2]; 3]| {
                    let mut nodes: Vec<usize> = p.iter().map(|q| at(2 * q[0], 2 * q[1])).collect();
                    if quadratic {
                        for m in 0..3 {
                            let (q, r) = (p[m], p[(m + 1) % 3]);
                            nodes.push(at(q[0] + r[0], q[1] + r[1]));
                        }
                    }
                    let kind = if quadratic { FaceKind::Tri6 } else { FaceKind::Tri3 };
                    panels.push(Panel::new(kind, &nodes, 0).unwrap());
                };
                for u in 0..n {
                    for v in 0..n - u {
                        push([[u, v], [u + 1, v], [u, v + 1]]);
                        if u + v + 1 < n {
                            push([[u + 1, v], [u + 1, v + 1], [u, v + 1]]);
                        }
                    }
                }
            }
        }
    }
    BoundaryMesh {
        points: points.points,
        panels,
        patches: vec!["sphere".to_owned()],
    }
}

/// A box of the given corners with panels of at most `edge` \[m\]; triangles or quadrilaterals; patches -x +x -y +y -z
/// +z.
pub fn cuboid(low: [f64; 3], high: [f64; 3], edge: f64, quads: bool) -> BoundaryMesh {
    let divisions = [0, 1, 2].map(|c| ((high[c] - low[c]) / edge - 1e-9).ceil().max(1.0) as usize);
    let mut points = Points::default();
    let mut panels = Vec::new();
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for (side, at) in [(0, low[axis]), (1, high[axis])] {
            let mut node = |i: usize, j: usize| {
                let mut p = [at; 3];
                p[u] = low[u] + (high[u] - low[u]) * i as f64 / divisions[u] as f64;
                p[v] = low[v] + (high[v] - low[v]) * j as f64 / divisions[v] as f64;
                points.index(Point3::from(p))
            };
            for i in 0..divisions[u] {
                for j in 0..divisions[v] {
                    let mut c = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
                    if side == 0 {
                        c.reverse();
                    }
                    let patch = 2 * axis + side;
                    let mut push = |kind, nodes: &[usize]| panels.push(Panel::new(kind, nodes, patch).unwrap());
                    if quads {
                        push(FaceKind::Quad4, &c);
                    } else {
                        let (a, b) = if (i + j) % 2 == 0 {
                            ([0, 1, 2], [0, 2, 3])
                        } else {
                            ([0, 1, 3], [1, 2, 3])
                        };
                        push(FaceKind::Tri3, &a.map(|k| c[k]));
                        push(FaceKind::Tri3, &b.map(|k| c[k]));
                    }
                }
            }
        }
    }
    BoundaryMesh {
        points: points.points,
        panels,
        patches: ["-x", "+x", "-y", "+y", "-z", "+z"].map(str::to_owned).to_vec(),
    }
}

/// Normal derivative at x of the field e^{-jkr}/(4 pi r) of a point source.
pub fn monopole_slope(k: f64, source: Point3<f64>, x: Point3<f64>, normal: Vector3<f64>) -> Complex<f64> {
    let d = x - source;
    let r = d.norm();
    let g = Complex::from_polar(1.0 / (4.0 * PI * r), -k * r);
    -g * Complex::new(1.0, k * r) * (d.dot(&normal) / (r * r))
}

/// Octants of the unit sphere by the signs of their axes, n² curved triangles each; with `quarters` also the three
/// quarter disks that close the sphere where the octant (+, +, +) is missing.
pub fn octants(signs: &[[i32; 3]], n: usize, quarters: bool) -> BoundaryMesh {
    let mut points = Points::default();
    let mut panels = Vec::new();
    let mut patch = |points: &mut Points, place: &dyn Fn(usize, usize) -> Vector3<f64>, number: usize| {
        let mut push = |p: [[usize; 2]; 3]| {
            let mut nodes: Vec<usize> = p
                .iter()
                .map(|q| points.index(Point3::from(place(2 * q[0], 2 * q[1]))))
                .collect();
            for m in 0..3 {
                let (q, r) = (p[m], p[(m + 1) % 3]);
                nodes.push(points.index(Point3::from(place(q[0] + r[0], q[1] + r[1]))));
            }
            panels.push(Panel::new(FaceKind::Tri6, &nodes, number).unwrap());
        };
        for u in 0..n {
            for v in 0..n - u {
                push([[u, v], [u + 1, v], [u, v + 1]]);
                if u + v + 1 < n {
                    push([[u + 1, v], [u + 1, v + 1], [u, v + 1]]);
                }
            }
        }
    };
    let full = 2 * n;
    for sign in signs {
        let axes = [0, 1, 2].map(|c| {
            let mut e = Vector3::zeros();
            e[c] = f64::from(sign[c]);
            e
        });
        let place = |u: usize, v: usize| {
            let w = full - u - v;
            (axes[0] * w as f64 + axes[1] * u as f64 + axes[2] * v as f64).normalize()
        };
        patch(&mut points, &place, 0);
    }
    if quarters {
        for c in 0..3 {
            let (mut a, mut b) = (Vector3::<f64>::zeros(), Vector3::<f64>::zeros());
            a[c] = 1.0;
            b[(c + 1) % 3] = 1.0;
            let place = |u: usize, v: usize| {
                let r = (u + v) as f64;
                if u + v == 0 {
                    Vector3::zeros()
                } else {
                    (a * u as f64 + b * v as f64).normalize() * (r / full as f64)
                }
            };
            patch(&mut points, &place, 1);
        }
    }
    BoundaryMesh {
        points: points.points,
        panels,
        patches: vec!["sphere".to_owned(), "cut".to_owned()],
    }
}

/// A rectangle in the plane z = 0 of panels with nine nodes, normals along z; the lines of their nodes, corners and
/// mid-sides in turn.
pub fn rectangle(x: &[f64], y: &[f64]) -> BoundaryMesh {
    let node = |i: usize, j: usize| j * x.len() + i;
    let cells = (0..y.len() / 2).flat_map(|j| (0..x.len() / 2).map(move |i| [2 * i, 2 * j]));
    let panel = |[i, j]: [usize; 2]| {
        let corners = [[0, 0], [2, 0], [2, 2], [0, 2]];
        let others = [[1, 0], [2, 1], [1, 2], [0, 1], [1, 1]];
        let nodes: Vec<usize> = corners.iter().chain(&others).map(|[a, b]| node(i + a, j + b)).collect();
        Panel::new(FaceKind::Quad9, &nodes, 0).unwrap()
    };
    let row = |&y: &f64| x.iter().map(move |&x| Point3::new(x, y, 0.0)).collect::<Vec<_>>();
    BoundaryMesh {
        points: y.iter().flat_map(row).collect(),
        panels: cells.map(panel).collect(),
        patches: vec!["plate".to_owned()],
    }
}

/// Lines of the nodes of `count` equal panels from 0 to `length`.
pub fn even(length: f64, count: usize) -> Vec<f64> {
    (0..=2 * count)
        .map(|n| length * n as f64 / (2 * count) as f64)
        .collect()
}

/// Lines of the nodes of `count` panels from 0 to `length` that become narrow at both ends, as the cosine does: a
/// function that is linear in the panel at the end rises with the root of the distance.
pub fn graded(length: f64, count: usize) -> Vec<f64> {
    let at = |n: usize| 0.5 * length * (1.0 - (PI * n as f64 / (2 * count) as f64).cos());
    (0..=2 * count).map(at).collect()
}

/// A quarter of a disk in the plane z = 0 between the planes x = 0 and y = 0, normals along z: n² curved triangles,
/// whose vertices lie at the radii that `place` gives for 0 to 1.
pub fn quarter_disk(n: usize, place: impl Fn(f64) -> f64) -> BoundaryMesh {
    let mut points = Points::default();
    let mut panels = Vec::new();
    let at = |u: usize, v: usize| {
        let r = (u + v) as f64;
        if u + v == 0 {
            return Point3::origin();
        }
        // Equal angles on every ring.
        let angle = 0.5 * PI * v as f64 / r;
        Point3::from(Vector3::new(angle.cos(), angle.sin(), 0.0) * place(r / (2 * n) as f64))
    };
    let mut push = |p: [[usize; 2]; 3]| {
        let mut nodes: Vec<usize> = p.iter().map(|q| points.index(at(2 * q[0], 2 * q[1]))).collect();
        for m in 0..3 {
            let (q, r) = (p[m], p[(m + 1) % 3]);
            nodes.push(points.index(at(q[0] + r[0], q[1] + r[1])));
        }
        panels.push(Panel::new(FaceKind::Tri6, &nodes, 0).unwrap());
    };
    for u in 0..n {
        for v in 0..n - u {
            push([[u, v], [u + 1, v], [u, v + 1]]);
            if u + v + 1 < n {
                push([[u + 1, v], [u + 1, v + 1], [u, v + 1]]);
            }
        }
    }
    BoundaryMesh {
        points: points.points,
        panels,
        patches: vec!["disk".to_owned()],
    }
}
