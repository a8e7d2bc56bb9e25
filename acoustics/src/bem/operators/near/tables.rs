//! Tables of shape functions at the points of pair rules, computed once for all pairs.

use crate::bem::mesh::panel::{PanelShape, Shape};
use crate::bem::mesh::rules::{self, Node};
use nailnoise_meshes::FaceKind;

/// Shape functions at the points of a pair rule on one side, as separate arrays padded to full vectors.
#[derive(Debug)]
pub(super) struct Sampled {
    pub(super) padded: usize,
    pub(super) nodes: usize,
    pub(super) corners: usize,
    /// N_a, dN_a/dxi, dN_a/deta of the geometry, followed by phi_i, dphi_i/dxi, dphi_i/deta of the corner functions.
    pub(super) values: Vec<f64>,
}

impl Sampled {
    pub(super) fn new(kind: FaceKind, points: &[[f64; 2]]) -> Self {
        Self::repeated(kind, points, 1, points.len())
    }

    /// Repeats each point `each` times, and the resulting sequence up to `total` points: one side of a product rule.
    pub(super) fn repeated(kind: FaceKind, points: &[[f64; 2]], each: usize, total: usize) -> Self {
        let padded = total.next_multiple_of(8);
        let (nodes, corners) = (kind.nodes(), kind.corners());
        let mut values = vec![0.0; 3 * (nodes + corners) * padded];
        let shapes: Vec<(Shape, Shape)> = points.iter().map(|&xi| (kind.at(xi), kind.linear().at(xi))).collect();
        for q in 0..padded {
            let (shape, linear) = &shapes[(q.min(total - 1) / each) % points.len()];
            for (count, s, start) in [(nodes, shape, 0), (corners, linear, 3 * nodes)] {
                for a in 0..count {
                    values[(start + a) * padded + q] = s.n[a];
                    values[(start + count + a) * padded + q] = s.dn[a][0];
                    values[(start + 2 * count + a) * padded + q] = s.dn[a][1];
                }
            }
        }
        Self {
            padded,
            nodes,
            corners,
            values,
        }
    }
}

/// The rule of the given level on a complete panel; the first level is the far rule.
pub(super) fn whole(kind: FaceKind, level: usize) -> Vec<Node> {
    match (kind.corners(), level) {
        (3, 0) => rules::triangle(3),
        (3, 1) => rules::triangle(7),
        (3, 2) => rules::triangle(12),
        (3, _) => rules::triangle(16),
        (_, level) => rules::square(level + 2),
    }
}

pub(super) fn product(rules: &[Vec<Node>; 2]) -> (Vec<[f64; 2]>, Vec<[f64; 2]>) {
    rules[0]
        .iter()
        .flat_map(|&(x, _)| rules[1].iter().map(move |&(y, _)| (x, y)))
        .unzip()
}

pub(super) fn product_weights(rules: &[Vec<Node>; 2]) -> Vec<f64> {
    padded(
        rules[0]
            .iter()
            .flat_map(|&(_, w)| rules[1].iter().map(move |&(_, v)| w * v)),
    )
}

pub(super) fn padded(weights: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut all: Vec<f64> = weights.collect();
    all.resize(all.len().next_multiple_of(8), 0.0);
    all
}
