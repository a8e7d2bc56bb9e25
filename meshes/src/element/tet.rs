//! Tetrahedra on r, s, t >= 0, r + s + t <= 1 with 4 and 10 nodes.
//!
//! The nodes are the corners at the origin and at the ends of r, s, t, then the mid-sides of the edges 01, 12, 20, 03,
//! 13, 23.

/// Natural coordinates of the nodes: the first 4 or all of them.
pub(super) const NODES: [[f64; 3]; 10] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.5, 0.0, 0.0],
    [0.5, 0.5, 0.0],
    [0.0, 0.5, 0.0],
    [0.0, 0.0, 0.5],
    [0.5, 0.0, 0.5],
    [0.0, 0.5, 0.5],
];

/// Corners of each edge; mid-side 4 + i lies on edge i.
pub(super) const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// Faces of the 4-node tetrahedron.
pub(super) const FACES_4: [&[usize]; 4] = [&[0, 1, 3], &[1, 2, 3], &[2, 0, 3], &[0, 2, 1]];

/// Faces of the 10-node tetrahedron.
pub(super) const FACES_10: [&[usize]; 4] = [
    &[0, 1, 3, 4, 8, 7],
    &[1, 2, 3, 5, 9, 8],
    &[2, 0, 3, 6, 7, 9],
    &[0, 2, 1, 6, 5, 4],
];

/// Gradients of the barycentric coordinates L_0 = 1 - r - s - t, L_1 = r, L_2 = s, L_3 = t.
const SLOPES: [[f64; 3]; 4] = [[-1.0, -1.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn barycentric(xi: [f64; 3]) -> [f64; 4] {
    [1.0 - xi[0] - xi[1] - xi[2], xi[0], xi[1], xi[2]]
}

/// N = L_a.
pub(super) fn shape_4(xi: [f64; 3], n: &mut [f64], dn: &mut [[f64; 3]]) {
    n[..4].copy_from_slice(&barycentric(xi));
    dn[..4].copy_from_slice(&SLOPES);
}

/// Corner  N = L_a (2 L_a - 1),  mid-side of edge ab  N = 4 L_a L_b.
pub(super) fn shape_10(xi: [f64; 3], n: &mut [f64], dn: &mut [[f64; 3]]) {
    let l = barycentric(xi);
    for a in 0..4 {
        n[a] = l[a] * (2.0 * l[a] - 1.0);
        dn[a] = SLOPES[a].map(|d| (4.0 * l[a] - 1.0) * d);
    }
    for (i, [a, b]) in EDGES.into_iter().enumerate() {
        n[4 + i] = 4.0 * l[a] * l[b];
        dn[4 + i] = [0, 1, 2].map(|k| 4.0 * (SLOPES[a][k] * l[b] + l[a] * SLOPES[b][k]));
    }
}
