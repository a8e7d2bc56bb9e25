//! The 15-node wedge: a triangle r, s >= 0, r + s <= 1 times \[-1, 1\] in t.
//!
//! The nodes are the corners of the lower triangle and those of the upper one. Then come the mid-sides of the lower
//! triangle 01, 12, 20, of the upper one 34, 45, 53, and of the edges between them 03, 14, 25. The normal of the
//! corners 0, 1, 2 points to 3, 4, 5, as in gmsh and in the parametric coordinates of VTK's quadratic wedge.

/// Natural coordinates of the nodes.
pub(super) const NODES: [[f64; 3]; 15] = [
    [0.0, 0.0, -1.0],
    [1.0, 0.0, -1.0],
    [0.0, 1.0, -1.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [0.0, 1.0, 1.0],
    [0.5, 0.0, -1.0],
    [0.5, 0.5, -1.0],
    [0.0, 0.5, -1.0],
    [0.5, 0.0, 1.0],
    [0.5, 0.5, 1.0],
    [0.0, 0.5, 1.0],
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
];

/// Corners of each edge; mid-side 6 + i lies on edge i.
pub(super) const EDGES: [[usize; 2]; 9] = [[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3], [0, 3], [1, 4], [2, 5]];

/// Faces: the two triangles, then the three quadrilaterals.
pub(super) const FACES: [&[usize]; 5] = [
    &[0, 2, 1, 8, 7, 6],
    &[3, 4, 5, 9, 10, 11],
    &[0, 1, 4, 3, 6, 13, 9, 12],
    &[1, 2, 5, 4, 7, 14, 10, 13],
    &[2, 0, 3, 5, 8, 12, 11, 14],
];

/// With the barycentric coordinates L of the triangle and c = t_a (Zienkiewicz & Taylor, vol. 1, section 8.9)
/// corner  N = L_a (1 + c t)(2 L_a - 2 + c t) / 2,  mid-side in a triangle  N = 2 L_a L_b (1 + c t),
/// mid-side between them  N = L_a (1 - t^2).
pub(super) fn shape(xi: [f64; 3], n: &mut [f64], dn: &mut [[f64; 3]]) {
    const SLOPES: [[f64; 2]; 3] = [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]];
    let [r, s, t] = xi;
    let l = [1.0 - r - s, r, s];
    for (level, c) in [-1.0, 1.0].into_iter().enumerate() {
        let up = 1.0 + c * t;
        for a in 0..3 {
            let rest = 2.0 * l[a] - 2.0 + c * t;
            let by_l = up * (rest + 2.0 * l[a]) / 2.0;
            let node = 3 * level + a;
            n[node] = l[a] * up * rest / 2.0;
            dn[node] = [by_l * SLOPES[a][0], by_l * SLOPES[a][1], l[a] * c * (rest + up) / 2.0];
            let b = (a + 1) % 3;
            let node = 6 + node;
            n[node] = 2.0 * l[a] * l[b] * up;
            let slope = |k: usize| 2.0 * up * (SLOPES[a][k] * l[b] + l[a] * SLOPES[b][k]);
            dn[node] = [slope(0), slope(1), 2.0 * l[a] * l[b] * c];
        }
    }
    for a in 0..3 {
        let middle = 1.0 - t * t;
        n[12 + a] = l[a] * middle;
        dn[12 + a] = [middle * SLOPES[a][0], middle * SLOPES[a][1], -2.0 * t * l[a]];
    }
}
