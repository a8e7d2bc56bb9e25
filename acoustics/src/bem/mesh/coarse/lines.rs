//! Feature lines that a coarser surface must preserve: sharp edges, borders of patches, and boundaries of the surface.

use super::curved::Curved;
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// Cosine of the smallest angle between normals across a sharp edge: 30 degrees.
const SHARP: f64 = 0.866;

/// Cosine of the change in direction of a line at which its vertex becomes fixed: 45 degrees.
const TURN: f64 = 0.707;

/// Number of segments into which a curved edge is divided to follow a line.
const PIECES: usize = 8;

/// A triangle of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    pub(super) corners: [usize; 3],
    /// Normals of the original surface at the corners, on the triangle's side of each line.
    pub(super) normals: [Vector3<f64>; 3],
    pub(super) patch: usize,
}

/// How a vertex may move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Anywhere on the surface.
    Smooth,
    /// Along a line.
    Line,
    /// Not at all.
    Fixed,
}

/// Edges on lines, identified by their ends with the lower index first, and the points along them from there.
pub(super) type Lines = BTreeMap<(usize, usize), Vec<Vector3<f64>>>;

/// The triangles of a surface with normals at their corners, its lines, and the degree of freedom of each vertex.
pub(super) fn lines(
    points: &[Vector3<f64>],
    of: &[([usize; 3], Curved)],
    patch: &[usize],
) -> (Vec<Triangle>, Lines, Vec<Kind>) {
    let mut edges: BTreeMap<(usize, usize), Vec<(usize, usize)>> = BTreeMap::new();
    for (t, (corners, _)) in of.iter().enumerate() {
        for k in 0..3 {
            edges
                .entry(key(corners[k], corners[(k + 1) % 3]))
                .or_default()
                .push((t, k));
        }
    }
    let normal = |t: usize, xi: [f64; 2]| of[t].1.normal(xi);
    let mut lines = Lines::new();
    // Triangle corners that share a vertex and lie on the same side of all lines.
    let mut sectors: Vec<usize> = (0..3 * of.len()).collect();
    let mut fans: Vec<usize> = sectors.clone();
    for (&(a, b), users) in &edges {
        let smooth = match users[..] {
            [(t, k), (q, l)] => {
                join(&mut fans, of, (t, q), [a, b]);
                patch[t] == patch[q] && normal(t, MIDDLES[k]).dot(&normal(q, MIDDLES[l])) > SHARP
            }
            _ => false,
        };
        if smooth {
            join(&mut sectors, of, (users[0].0, users[1].0), [a, b]);
        } else {
            lines.insert((a, b), along(&of[users[0].0], users[0].1, a));
        }
    }
    let mut sums = vec![Vector3::zeros(); 3 * of.len()];
    for t in 0..of.len() {
        for k in 0..3 {
            sums[root(&mut sectors, 3 * t + k)] += normal(t, CORNERS[k]);
        }
    }
    let triangles = (0..of.len()).map(|t| Triangle {
        corners: of[t].0,
        normals: [0, 1, 2].map(|k| sums[root(&mut sectors, 3 * t + k)].normalize()),
        patch: patch[t],
    });
    let triangles: Vec<Triangle> = triangles.collect();
    let mut fan: Vec<Option<usize>> = vec![None; points.len()];
    let mut kinds = vec![Kind::Smooth; points.len()];
    for (t, triangle) in triangles.iter().enumerate() {
        for (k, &vertex) in triangle.corners.iter().enumerate() {
            let own = root(&mut fans, 3 * t + k);
            // Two parts of the surface meet only at this point.
            if *fan[vertex].get_or_insert(own) != own {
                kinds[vertex] = Kind::Fixed;
            }
        }
    }
    let mut ends: Vec<Vec<usize>> = vec![Vec::new(); points.len()];
    for &(a, b) in lines.keys() {
        ends[a].push(b);
        ends[b].push(a);
    }
    for (vertex, ends) in ends.iter().enumerate() {
        let away = |to: usize| (points[to] - points[vertex]).normalize();
        kinds[vertex] = match (kinds[vertex], &ends[..]) {
            (Kind::Smooth, []) => Kind::Smooth,
            (Kind::Smooth, &[a, b]) if -away(a).dot(&away(b)) > TURN => Kind::Line,
            _ => Kind::Fixed,
        };
    }
    (triangles, lines, kinds)
}

const CORNERS: [[f64; 2]; 3] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
const MIDDLES: [[f64; 2]; 3] = [[0.5, 0.0], [0.5, 0.5], [0.0, 0.5]];

/// Identifies an edge by its ends.
pub(super) fn key(a: usize, b: usize) -> (usize, usize) {
    (a.min(b), a.max(b))
}

/// Points along the edge that follows corner `k`, starting at the vertex `first`.
fn along((corners, curved): &([usize; 3], Curved), k: usize, first: usize) -> Vec<Vector3<f64>> {
    let (from, to) = (CORNERS[k], CORNERS[(k + 1) % 3]);
    let at = |i: usize| {
        let s = i as f64 / PIECES as f64;
        curved
            .at([from[0] + s * (to[0] - from[0]), from[1] + s * (to[1] - from[1])])
            .0
    };
    let mut points: Vec<Vector3<f64>> = (0..=PIECES).map(at).collect();
    if corners[k] != first {
        points.reverse();
    }
    points
}

/// Joins the corners of two triangles at both ends of their common edge.
fn join(sets: &mut [usize], of: &[([usize; 3], Curved)], (t, q): (usize, usize), ends: [usize; 2]) {
    for end in ends {
        let place = |t: usize| of[t].0.iter().position(|&c| c == end).map(|k| 3 * t + k);
        if let (Some(a), Some(b)) = (place(t), place(q)) {
            let (a, b) = (root(sets, a), root(sets, b));
            sets[a.max(b)] = a.min(b);
        }
    }
}

fn root(sets: &mut [usize], mut i: usize) -> usize {
    while sets[i] != i {
        sets[i] = sets[sets[i]];
        i = sets[i];
    }
    i
}
