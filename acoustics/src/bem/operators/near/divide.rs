//! Subdivides panels that are close without touching, until each part is far enough from the other panel.

use super::choice::RATIOS;
use super::tables::{Sampled, product_weights};
use crate::bem::mesh::panel::{MOST_NODES, PanelShape};
use crate::bem::mesh::rules::{self, Node};
use nailnoise_meshes::FaceKind;
use nalgebra::Vector3;

/// Largest number of subdivisions.
pub(super) const DEPTH: usize = 16;
/// Halves of a quadrilateral, by corners; the first is also the full triangle.
pub(super) const HALVES: [[u8; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

/// A triangle in the natural coordinates of a panel.
pub(super) type Part = (FaceKind, [[f64; 2]; 3]);

/// Halves the longest side of the larger triangle until the two are far enough apart for the 12-point rule, so that
/// slender triangles are shortened first.
pub(super) fn divide(
    parts: [Part; 2],
    nodes: [&[[f64; 3]; MOST_NODES]; 2],
    depth: usize,
    run: &mut impl FnMut(&Sampled, &Sampled, &[f64]),
) {
    let place = |(kind, _): Part, nodes: &[[f64; 3]; MOST_NODES], xi: [f64; 2]| {
        let shape = kind.at(xi);
        let mut x = Vector3::zeros();
        for (n, p) in shape.n.iter().zip(nodes).take(kind.nodes()) {
            x += Vector3::from(*p) * *n;
        }
        x
    };
    let sphere = |side: usize| {
        let v = parts[side].1;
        let middle = [0, 1].map(|d| (v[0][d] + v[1][d] + v[2][d]) / 3.0);
        let centre = place(parts[side], nodes[side], middle);
        let reach = v.map(|xi| (place(parts[side], nodes[side], xi) - centre).norm());
        (centre, reach.into_iter().fold(0.0, f64::max))
    };
    let ((c, r), (d, s)) = (sphere(0), sphere(1));
    if depth == 0 || (c - d).norm() > RATIOS[2] * (r + s) {
        let rule = |(_, v): Part| -> Vec<Node> {
            let area = (v[1][0] - v[0][0]) * (v[2][1] - v[0][1]) - (v[2][0] - v[0][0]) * (v[1][1] - v[0][1]);
            let map = |(l, w): Node| {
                let at = |d: usize| v[0][d] + l[0] * (v[1][d] - v[0][d]) + l[1] * (v[2][d] - v[0][d]);
                ([at(0), at(1)], w * area.abs())
            };
            rules::triangle(12).into_iter().map(map).collect()
        };
        let rules = parts.map(rule);
        let points = |side: usize| -> Vec<[f64; 2]> { rules[side].iter().map(|&(xi, _)| xi).collect() };
        let [m, n] = [0, 1].map(|side| rules[side].len());
        let tables = [
            Sampled::repeated(parts[0].0, &points(0), n, m * n),
            Sampled::repeated(parts[1].0, &points(1), 1, m * n),
        ];
        run(&tables[0], &tables[1], &product_weights(&rules));
        return;
    }
    let side = usize::from(s > r);
    let v = parts[side].1;
    let corners = v.map(|xi| place(parts[side], nodes[side], xi));
    let length = |k: usize| (corners[(k + 1) % 3] - corners[k]).norm();
    let longest = (1..3).fold(0, |best, k| if length(k) > length(best) { k } else { best });
    let (a, b, opposite) = (v[longest], v[(longest + 1) % 3], v[(longest + 2) % 3]);
    let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
    for piece in [[a, middle, opposite], [middle, b, opposite]] {
        let mut next = parts;
        next[side].1 = piece;
        divide(next, nodes, depth - 1, run);
    }
}
