//! Curves the sides of panels to follow the finer surface.

use super::collapse::Collapse;
use super::curved::{Curved, Nearest};
use super::lines::{Triangle, key};
use crate::bem::mesh::panel::{BoundaryMesh, Panel};
use crate::bem::mesh::rules;
use nailnoise_meshes::FaceKind;
use nalgebra::{Point3, Vector3};
use std::collections::{BTreeMap, BTreeSet};

/// Largest offset of a side's midpoint from its chord, relative to the chord's length; 0.16 corresponds to 70 degrees
/// of a circle.
const BULGE: f64 = 0.25;

/// Relative offset below which a side counts as straight.
const STRAIGHT: f64 = 1e-9;

/// Smallest ratio of a curved triangle's area factor to that of the flat one.
const SQUEEZED: f64 = 0.3;

/// Cosine of the largest angle between normals on the same sheet.
const SHEET: f64 = 0.5;

/// Midpoints of curved edges, identified by their ends.
type Middles = BTreeMap<(usize, usize), Vector3<f64>>;

/// The reduced surface as curved triangles, or flat ones if their sides are straight.
pub(super) fn curved_panels(fewer: &Collapse<'_>, surface: &Nearest, patches: &[String]) -> BoundaryMesh {
    let triangles: Vec<Triangle> = fewer.triangles.iter().flatten().copied().collect();
    let mut middles = middles(fewer, &triangles, surface);
    loop {
        let squeezed = |t: &&Triangle| !well_shaped(&nodes(fewer.points, &middles, &t.corners));
        let sides = |t: &Triangle| [0, 1, 2].map(|k| key(t.corners[k], t.corners[(k + 1) % 3]));
        let bad: BTreeSet<(usize, usize)> = triangles.iter().filter(squeezed).flat_map(sides).collect();
        let before = middles.len();
        middles.retain(|side, _| !bad.contains(side));
        if middles.len() == before {
            break;
        }
    }
    let mut points: Vec<Point3<f64>> = Vec::new();
    let (mut vertices, mut sides) = (BTreeMap::new(), BTreeMap::new());
    let mut panels = Vec::new();
    for triangle in &triangles {
        let c = triangle.corners;
        let all = nodes(fewer.points, &middles, &c);
        let mut add = |x: Vector3<f64>| {
            points.push(Point3::from(x));
            points.len() - 1
        };
        let mut own: Vec<usize> = (0..3)
            .map(|k| *vertices.entry(c[k]).or_insert_with(|| add(all[k])))
            .collect();
        let side = |k: usize| key(c[k], c[(k + 1) % 3]);
        let mut kind = FaceKind::Tri3;
        if (0..3).any(|k| middles.contains_key(&side(k))) {
            own.extend((0..3).map(|k| *sides.entry(side(k)).or_insert_with(|| add(all[3 + k]))));
            kind = FaceKind::Tri6;
        }
        panels.extend(Panel::new(kind, &own, triangle.patch));
    }
    BoundaryMesh {
        points,
        panels,
        patches: patches.to_vec(),
    }
}

/// Midpoints where the surface deviates from the chords of the triangles' sides: half way along a line, or on the
/// surface elsewhere.
fn middles(fewer: &Collapse<'_>, triangles: &[Triangle], surface: &Nearest) -> Middles {
    let mut normals: BTreeMap<(usize, usize), Vector3<f64>> = BTreeMap::new();
    for t in triangles {
        for k in 0..3 {
            let l = (k + 1) % 3;
            *normals.entry(key(t.corners[k], t.corners[l])).or_default() += t.normals[k] + t.normals[l];
        }
    }
    let bulge = |((a, b), normal): ((usize, usize), Vector3<f64>)| {
        let (x, y) = (fewer.points[a], fewer.points[b]);
        let chord = 0.5 * (x + y);
        let middle = match fewer.line(a, b) {
            Some(line) => half_way(&line),
            None => {
                let sheet = normal.normalize();
                surface.find(&chord, |n| n.dot(&sheet) > SHEET)?.position
            }
        };
        let off = (middle - chord).norm() / (y - x).norm();
        (off > STRAIGHT && off < BULGE).then_some(((a, b), middle))
    };
    normals.into_iter().filter_map(bulge).collect()
}

/// The point of a line equidistant from both ends.
fn half_way(line: &[Vector3<f64>]) -> Vector3<f64> {
    let length: f64 = line.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum();
    let mut left = 0.5 * length;
    for ends in line.windows(2) {
        let step = (ends[1] - ends[0]).norm();
        if left <= step {
            return ends[0] + (ends[1] - ends[0]) * (left / step.max(f64::MIN_POSITIVE));
        }
        left -= step;
    }
    line[line.len() - 1]
}

fn nodes(points: &[Vector3<f64>], middles: &Middles, corners: &[usize; 3]) -> [Vector3<f64>; 6] {
    let vertex = |k: usize| points[corners[k % 3]];
    let middle = |k: usize| {
        let known = middles.get(&key(corners[k], corners[(k + 1) % 3]));
        known.copied().unwrap_or_else(|| 0.5 * (vertex(k) + vertex(k + 1)))
    };
    [vertex(0), vertex(1), vertex(2), middle(0), middle(1), middle(2)]
}

/// Whether a curved triangle covers the plane of the flat one without folding.
fn well_shaped(nodes: &[Vector3<f64>; 6]) -> bool {
    let curved = Curved { nodes: *nodes };
    let flat = (nodes[1] - nodes[0]).cross(&(nodes[2] - nodes[0]));
    let places = rules::triangle(12).into_iter().map(|(xi, _)| xi);
    let mut all = places.chain(FaceKind::Tri6.natural_nodes().iter().copied());
    all.all(|xi| {
        let (_, [t, u]) = curved.at(xi);
        t.cross(&u).dot(&flat) >= SQUEEZED * flat.norm_squared()
    })
}
