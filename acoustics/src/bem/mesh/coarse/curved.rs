//! Six-node triangles, and their points nearest to a given position.

use crate::bem::mesh::panel::{BoundaryMesh, PanelShape};
use nailnoise_meshes::FaceKind;
use nalgebra::Vector3;
use std::collections::HashMap;

/// Steps of Newton's method for the nearest point of a curved triangle, which is almost flat.
const STEPS: usize = 6;

/// A triangle: corners, then the mid-side node that follows each corner.
#[derive(Clone, Copy, Debug)]
pub(super) struct Curved {
    pub(super) nodes: [Vector3<f64>; 6],
}

impl Curved {
    /// A panel as triangles (one, or two for a quadrilateral) with the indices of their corners.
    pub(super) fn of(mesh: &BoundaryMesh, panel: usize) -> Vec<([usize; 3], Self)> {
        let of = &mesh.panels[panel];
        let natural = of.kind().natural_nodes();
        let corners = of.corners();
        let halves: &[[usize; 3]] = if corners.len() == 3 {
            &[[0, 1, 2]]
        } else {
            &[[0, 1, 2], [0, 2, 3]]
        };
        let half = |own: &[usize; 3]| {
            let at = |a: usize, b: usize| {
                let (a, b) = (natural[own[a % 3]], natural[own[b % 3]]);
                let xi = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
                mesh.point_at(panel, xi).position.coords
            };
            let nodes = [at(0, 0), at(1, 1), at(2, 2), at(0, 1), at(1, 2), at(2, 0)];
            (own.map(|corner| corners[corner]), Self { nodes })
        };
        halves.iter().map(half).collect()
    }

    /// Position, and its derivatives with respect to the natural coordinates.
    pub(super) fn at(&self, xi: [f64; 2]) -> (Vector3<f64>, [Vector3<f64>; 2]) {
        let shape = FaceKind::Tri6.at(xi);
        let (mut x, mut t) = (Vector3::zeros(), [Vector3::zeros(); 2]);
        for (a, node) in self.nodes.iter().enumerate() {
            x += shape.n[a] * node;
            t[0] += shape.dn[a][0] * node;
            t[1] += shape.dn[a][1] * node;
        }
        (x, t)
    }

    /// The point of the triangle with straight sides.
    fn flat(&self, [r, s]: [f64; 2]) -> Vector3<f64> {
        let [a, b, c, ..] = self.nodes;
        a + (b - a) * r + (c - a) * s
    }

    /// Unit normal.
    pub(super) fn normal(&self, xi: [f64; 2]) -> Vector3<f64> {
        let (_, t) = self.at(xi);
        t[0].cross(&t[1]).normalize()
    }

    /// Bound on its distance from the straight-sided triangle: sum 4 L_a L_b d_ab <= 4/3 max d, where d are the offsets
    /// of the midpoints of its sides from their chords.
    fn bulge(&self) -> f64 {
        let off = |k: usize| (self.nodes[3 + k] - 0.5 * (self.nodes[k] + self.nodes[(k + 1) % 3])).norm();
        4.0 / 3.0 * (0..3).map(off).fold(0.0, f64::max)
    }

    /// Centre and radius of a sphere that encloses it.
    fn sphere(&self) -> (Vector3<f64>, f64) {
        let [a, b, c, ..] = self.nodes;
        let centre = (a + b + c) / 3.0;
        let radius = [a, b, c].map(|x| (x - centre).norm()).into_iter().fold(0.0, f64::max);
        (centre, radius + self.bulge())
    }

    /// Natural coordinates of the point nearest to `p`, by Gauss-Newton iteration from `xi` of the flat triangle.
    fn nearest(&self, p: &Vector3<f64>, mut xi: [f64; 2]) -> [f64; 2] {
        for _ in 0..STEPS {
            let (x, [t, u]) = self.at(xi);
            let rest = p - x;
            let (a, b, c) = (t.dot(&t), t.dot(&u), u.dot(&u));
            let (f, g) = (t.dot(&rest), u.dot(&rest));
            let det = a * c - b * b;
            let mut to = [xi[0] + (c * f - b * g) / det, xi[1] + (a * g - b * f) / det];
            if to[0] < 0.0 {
                to = [0.0, xi[1] + (g + xi[0] * b) / c];
            } else if to[1] < 0.0 {
                to = [xi[0] + (f + xi[1] * b) / a, 0.0];
            } else if to[0] + to[1] > 1.0 {
                // If the point lies beyond the third side, move to the nearest point on that side in these coordinates.
                let over = 0.5 * (1.0 - xi[0] - xi[1]);
                let (start, along) = ([xi[0] + over, xi[1] + over], u - t);
                let step = along.dot(&(rest - (t + u) * over)) / along.norm_squared();
                to = [start[0] - step, start[1] + step];
                to[0] = to[0].clamp(0.0, 1.0);
                to[1] = 1.0 - to[0];
            }
            let to = [to[0].clamp(0.0, 1.0), to[1].clamp(0.0, 1.0)];
            let moved = (to[0] - xi[0]).abs() + (to[1] - xi[1]).abs();
            xi = to;
            if moved < 1e-10 {
                break;
            }
        }
        xi
    }

    /// The same for the straight-sided triangle (Ericson, *Real-Time Collision Detection*, 2005, section 5.1.5).
    fn nearest_flat(&self, p: &Vector3<f64>) -> [f64; 2] {
        let [a, b, c, ..] = self.nodes;
        let (ab, ac, ap) = (b - a, c - a, p - a);
        let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
        if d1 <= 0.0 && d2 <= 0.0 {
            return [0.0, 0.0];
        }
        let bp = p - b;
        let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
        if d3 >= 0.0 && d4 <= d3 {
            return [1.0, 0.0];
        }
        let vc = d1 * d4 - d3 * d2;
        if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
            return [d1 / (d1 - d3), 0.0];
        }
        let cp = p - c;
        let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
        if d6 >= 0.0 && d5 <= d6 {
            return [0.0, 1.0];
        }
        let vb = d5 * d2 - d1 * d6;
        if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
            return [0.0, d2 / (d2 - d6)];
        }
        let va = d3 * d6 - d5 * d4;
        if va <= 0.0 && d4 >= d3 && d5 >= d6 {
            let s = (d4 - d3) / ((d4 - d3) + (d5 - d6));
            return [1.0 - s, s];
        }
        let sum = va + vb + vc;
        [vb / sum, vc / sum]
    }
}

/// Triangles sorted into the cells of a grid.
pub(super) struct Nearest {
    triangles: Vec<Curved>,
    /// Centre and radius of a sphere around each.
    spheres: Vec<(Vector3<f64>, f64)>,
    cells: HashMap<[i64; 3], Vec<u32>>,
    cell: f64,
    rings: i64,
}

/// The nearest point of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub(super) triangle: usize,
    pub(super) xi: [f64; 2],
    pub(super) position: Vector3<f64>,
}

impl Nearest {
    pub(super) fn new(triangles: Vec<Curved>) -> Self {
        let bounds = |t: &Curved| {
            let first = (t.nodes[0], t.nodes[0]);
            t.nodes.iter().fold(first, |(low, high), x| (low.inf(x), high.sup(x)))
        };
        let boxes: Vec<_> = triangles.iter().map(bounds).collect();
        let mean = boxes.iter().map(|(low, high)| (high - low).norm()).sum::<f64>() / boxes.len().max(1) as f64;
        let cell = mean.max(f64::MIN_POSITIVE);
        let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
        let (mut least, mut most) = ([i64::MAX; 3], [i64::MIN; 3]);
        for (number, (low, high)) in boxes.iter().enumerate() {
            let (from, to) = (place(low, cell), place(high, cell));
            for i in from[0]..=to[0] {
                for j in from[1]..=to[1] {
                    for k in from[2]..=to[2] {
                        cells.entry([i, j, k]).or_default().push(number as u32);
                    }
                }
            }
            for axis in 0..3 {
                least[axis] = least[axis].min(from[axis]);
                most[axis] = most[axis].max(to[axis]);
            }
        }
        let rings = (0..3)
            .map(|axis| most[axis].saturating_sub(least[axis]))
            .max()
            .unwrap_or(0)
            + 1;
        Self {
            spheres: triangles.iter().map(Curved::sphere).collect(),
            triangles,
            cells,
            cell,
            rings,
        }
    }

    /// The nearest point whose normal is accepted, searched at least within the bounding box of the surface.
    pub(super) fn find(&self, p: &Vector3<f64>, accept: impl Fn(&Vector3<f64>) -> bool) -> Option<Found> {
        let middle = place(p, self.cell);
        let mut best: Option<(f64, Found)> = None;
        let mut seen: Vec<u32> = Vec::new();
        for ring in 0..=self.rings {
            for number in self.ring(middle, ring) {
                let (centre, radius) = self.spheres[number as usize];
                let known = best.as_ref().map_or(f64::INFINITY, |(known, _)| *known);
                // Few triangles pass this test, so the search in `seen` is short.
                if (p - centre).norm_squared() > (known + radius).powi(2) || seen.contains(&number) {
                    continue;
                }
                seen.push(number);
                let triangle = &self.triangles[number as usize];
                let flat = triangle.nearest_flat(p);
                if (p - triangle.flat(flat)).norm() > known + triangle.bulge() {
                    continue;
                }
                let xi = triangle.nearest(p, flat);
                let (position, tangents) = triangle.at(xi);
                let distance = (p - position).norm();
                let nearer = best.as_ref().is_none_or(|(known, _)| distance < *known);
                if nearer && accept(&tangents[0].cross(&tangents[1]).normalize()) {
                    let triangle = number as usize;
                    best = Some((distance, Found { triangle, xi, position }));
                }
            }
            if best.is_some_and(|(distance, _)| distance <= ring as f64 * self.cell) {
                break;
            }
        }
        best.map(|(_, found)| found)
    }

    /// Triangles in the cells at a distance of `ring` cells from the middle.
    fn ring(&self, middle: [i64; 3], ring: i64) -> impl Iterator<Item = u32> {
        let around = -ring..=ring;
        let cells = around
            .clone()
            .flat_map(move |i| (-ring..=ring).flat_map(move |j| (-ring..=ring).map(move |k| [i, j, k])));
        cells
            .filter(move |at| at.iter().any(|c| c.abs() == ring))
            .filter_map(move |at| {
                self.cells
                    .get(&[middle[0] + at[0], middle[1] + at[1], middle[2] + at[2]])
            })
            .flatten()
            .copied()
    }
}

fn place(x: &Vector3<f64>, cell: f64) -> [i64; 3] {
    [0, 1, 2].map(|axis| (x[axis] / cell).floor() as i64)
}
