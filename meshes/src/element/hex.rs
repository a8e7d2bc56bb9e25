//! Hexahedra on \[-1, 1\]^3 with 8, 20 and 27 nodes.
//!
//! The nodes are the corners of the lower face counter-clockwise and those of the upper face. Then come the mid-sides
//! of the lower face, of the upper face and of the vertical edges, then the centres of the faces -x, +x, -y, +y, -z, +z
//! and of the body.

/// Natural coordinates of the nodes: the first 8, 20 or all of them.
pub(super) const NODES: [[f64; 3]; 27] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
    [0.0, -1.0, -1.0],
    [1.0, 0.0, -1.0],
    [0.0, 1.0, -1.0],
    [-1.0, 0.0, -1.0],
    [0.0, -1.0, 1.0],
    [1.0, 0.0, 1.0],
    [0.0, 1.0, 1.0],
    [-1.0, 0.0, 1.0],
    [-1.0, -1.0, 0.0],
    [1.0, -1.0, 0.0],
    [1.0, 1.0, 0.0],
    [-1.0, 1.0, 0.0],
    [-1.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, -1.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, -1.0],
    [0.0, 0.0, 1.0],
    [0.0, 0.0, 0.0],
];

/// Corners of each edge.
pub(super) const EDGES: [[usize; 2]; 12] = [
    [0, 1],
    [1, 2],
    [2, 3],
    [3, 0],
    [4, 5],
    [5, 6],
    [6, 7],
    [7, 4],
    [0, 4],
    [1, 5],
    [2, 6],
    [3, 7],
];

/// Faces -x, +x, -y, +y, -z, +z of the 8-node hexahedron.
pub(super) const FACES_8: [&[usize]; 6] = [
    &[0, 4, 7, 3],
    &[1, 2, 6, 5],
    &[0, 1, 5, 4],
    &[3, 7, 6, 2],
    &[0, 3, 2, 1],
    &[4, 5, 6, 7],
];

/// Faces of the 20-node hexahedron.
pub(super) const FACES_20: [&[usize]; 6] = [
    &[0, 4, 7, 3, 16, 15, 19, 11],
    &[1, 2, 6, 5, 9, 18, 13, 17],
    &[0, 1, 5, 4, 8, 17, 12, 16],
    &[3, 7, 6, 2, 19, 14, 18, 10],
    &[0, 3, 2, 1, 11, 10, 9, 8],
    &[4, 5, 6, 7, 12, 13, 14, 15],
];

/// Faces of the 27-node hexahedron.
pub(super) const FACES_27: [&[usize]; 6] = [
    &[0, 4, 7, 3, 16, 15, 19, 11, 20],
    &[1, 2, 6, 5, 9, 18, 13, 17, 21],
    &[0, 1, 5, 4, 8, 17, 12, 16, 22],
    &[3, 7, 6, 2, 19, 14, 18, 10, 23],
    &[0, 3, 2, 1, 11, 10, 9, 8, 24],
    &[4, 5, 6, 7, 12, 13, 14, 15, 25],
];

/// The product of three factors and its gradient, from the factors and their derivatives.
fn product(f: [f64; 3], df: [f64; 3]) -> (f64, [f64; 3]) {
    (
        f[0] * f[1] * f[2],
        [df[0] * f[1] * f[2], f[0] * df[1] * f[2], f[0] * f[1] * df[2]],
    )
}

/// N = (1 + x)(1 + y)(1 + z) / 8 with x = xi xi_a and so on.
pub(super) fn shape_8(xi: [f64; 3], n: &mut [f64], dn: &mut [[f64; 3]]) {
    for (a, c) in NODES[..8].iter().enumerate() {
        let f = [0, 1, 2].map(|k| (1.0 + xi[k] * c[k]) / 2.0);
        (n[a], dn[a]) = product(f, c.map(|c| c / 2.0));
    }
}

/// The serendipity functions (Zienkiewicz & Taylor, *The Finite Element Method*, vol. 1, section 8.7):
/// corner  N = (1 + x)(1 + y)(1 + z)(x + y + z - 2) / 8,  mid-side with xi_a = 0  N = (1 - xi^2)(1 + y)(1 + z) / 4.
pub(super) fn shape_20(xi: [f64; 3], n: &mut [f64], dn: &mut [[f64; 3]]) {
    for (a, c) in NODES[..20].iter().enumerate() {
        // One-dimensional factor of each direction and its derivative: 1 + xi xi_a at a corner, 1 - xi^2 at a mid-side.
        let f = [0, 1, 2].map(|k| match c[k] {
            0.0 => 1.0 - xi[k] * xi[k],
            c => 1.0 + xi[k] * c,
        });
        let df = [0, 1, 2].map(|k| if c[k] == 0.0 { -2.0 * xi[k] } else { c[k] });
        let (value, slope) = product(f, df);
        if c.contains(&0.0) {
            (n[a], dn[a]) = (value / 4.0, slope.map(|d| d / 4.0));
        } else {
            let s = xi[0] * c[0] + xi[1] * c[1] + xi[2] * c[2] - 2.0;
            n[a] = value * s / 8.0;
            dn[a] = [0, 1, 2].map(|k| (slope[k] * s + value * c[k]) / 8.0);
        }
    }
}

/// Products of the one-dimensional functions x (x + 1) / 2 at an end and 1 - xi^2 in the middle.
pub(super) fn shape_27(xi: [f64; 3], n: &mut [f64], dn: &mut [[f64; 3]]) {
    for (a, c) in NODES.iter().enumerate() {
        let f = [0, 1, 2].map(|k| quadratic(xi[k], c[k]));
        (n[a], dn[a]) = product(f.map(|f| f.0), f.map(|f| f.1));
    }
}

/// The quadratic Lagrange function of the node at `c` in {-1, 0, 1} and its slope.
pub(super) fn quadratic(xi: f64, c: f64) -> (f64, f64) {
    if c == 0.0 {
        (1.0 - xi * xi, -2.0 * xi)
    } else {
        (xi * (xi + c) / 2.0, xi + c / 2.0)
    }
}
