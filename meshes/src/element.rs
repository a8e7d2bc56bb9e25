//! Element kinds: node numbering, faces and shape functions.
//!
//! Node order is VTK's: for the 20-node hexahedron the corners of the lower face counter-clockwise, those of the upper
//! face, then the mid-side nodes of the lower face, of the upper face, and of the vertical edges.

/// The shape of an element and its order of interpolation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize)]
#[non_exhaustive]
pub enum ElementKind {
    /// 20-node serendipity hexahedron, VTK cell type 25.
    Hex20,
}

/// The shape of an element face.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize)]
#[non_exhaustive]
pub enum FaceKind {
    /// 8-node serendipity quadrilateral, VTK cell type 23.
    Quad8,
}

/// Natural coordinates of the nodes of [`ElementKind::Hex20`].
const HEX20_NODES: [[f64; 3]; 20] = [
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
];

/// Faces of the hexahedron, outward by the right-hand rule: corners, then mid-sides following each corner.
/// In order: -x, +x, -y, +y, -z, +z in natural coordinates.
const HEX20_FACES: [[usize; 8]; 6] = [
    [0, 4, 7, 3, 16, 15, 19, 11],
    [1, 2, 6, 5, 9, 18, 13, 17],
    [0, 1, 5, 4, 8, 17, 12, 16],
    [3, 7, 6, 2, 19, 14, 18, 10],
    [0, 3, 2, 1, 11, 10, 9, 8],
    [4, 5, 6, 7, 12, 13, 14, 15],
];

/// Natural coordinates of the nodes of [`FaceKind::Quad8`].
const QUAD8_NODES: [[f64; 2]; 8] = [
    [-1.0, -1.0],
    [1.0, -1.0],
    [1.0, 1.0],
    [-1.0, 1.0],
    [0.0, -1.0],
    [1.0, 0.0],
    [0.0, 1.0],
    [-1.0, 0.0],
];

impl ElementKind {
    /// Number of nodes.
    pub const fn nodes(self) -> usize {
        match self {
            Self::Hex20 => 20,
        }
    }

    /// Number of corner nodes, which come first.
    pub const fn corners(self) -> usize {
        match self {
            Self::Hex20 => 8,
        }
    }

    /// Local node numbers of each face, ordered so that the normal points out of the element.
    pub const fn faces(self) -> &'static [[usize; 8]] {
        match self {
            Self::Hex20 => &HEX20_FACES,
        }
    }

    /// Shape of the faces.
    pub const fn face_kind(self) -> FaceKind {
        match self {
            Self::Hex20 => FaceKind::Quad8,
        }
    }

    /// The VTK cell type number.
    pub const fn vtk_type(self) -> u8 {
        match self {
            Self::Hex20 => 25,
        }
    }

    /// Natural coordinates of the nodes.
    pub const fn natural_nodes(self) -> &'static [[f64; 3]] {
        match self {
            Self::Hex20 => &HEX20_NODES,
        }
    }

    /// Shape functions N_a and their gradients with respect to natural coordinates at `xi`.
    ///
    /// With s = xi . xi_a (sum over components), the serendipity functions are (Zienkiewicz & Taylor, *The Finite
    /// Element Method*, vol. 1, section 8.7)
    /// corner:  N = (1 + x)(1 + y)(1 + z)(x + y + z - 2) / 8,  mid-side with xi_a = 0:  N = (1 - xi^2)(1 + y)(1 + z) / 4,
    /// where x, y, z stand for xi xi_a, eta eta_a, zeta zeta_a.
    pub fn shape(self, xi: [f64; 3], n: &mut [f64], dn: &mut [[f64; 3]]) {
        match self {
            Self::Hex20 => {
                for (a, c) in HEX20_NODES.iter().enumerate() {
                    let (value, gradient) = hex20_function(xi, *c);
                    n[a] = value;
                    dn[a] = gradient;
                }
            }
        }
    }
}

fn hex20_function(xi: [f64; 3], c: [f64; 3]) -> (f64, [f64; 3]) {
    // One-dimensional factor of each direction and its derivative: 1 + xi xi_a at a corner, 1 - xi^2 at a mid-side.
    let mut f = [0.0; 3];
    let mut df = [0.0; 3];
    let mut mid_side = false;
    for k in 0..3 {
        if c[k] == 0.0 {
            mid_side = true;
            f[k] = 1.0 - xi[k] * xi[k];
            df[k] = -2.0 * xi[k];
        } else {
            f[k] = 1.0 + xi[k] * c[k];
            df[k] = c[k];
        }
    }
    let product = f[0] * f[1] * f[2];
    let slope = [df[0] * f[1] * f[2], f[0] * df[1] * f[2], f[0] * f[1] * df[2]];
    if mid_side {
        (product / 4.0, slope.map(|d| d / 4.0))
    } else {
        let s = xi[0] * c[0] + xi[1] * c[1] + xi[2] * c[2] - 2.0;
        (
            product * s / 8.0,
            std::array::from_fn(|k| (slope[k] * s + product * c[k]) / 8.0),
        )
    }
}

impl FaceKind {
    /// Number of nodes.
    pub const fn nodes(self) -> usize {
        match self {
            Self::Quad8 => 8,
        }
    }

    /// The VTK cell type number.
    pub const fn vtk_type(self) -> u8 {
        match self {
            Self::Quad8 => 23,
        }
    }

    /// Shape functions and their gradients with respect to the two natural coordinates at `xi`; entries beyond
    /// [`Self::nodes`] are left as they are.
    ///
    /// corner:  N = (1 + x)(1 + y)(x + y - 1) / 4,  mid-side with xi_a = 0:  N = (1 - xi^2)(1 + y) / 2.
    pub fn shape(self, xi: [f64; 2], n: &mut [f64], dn: &mut [[f64; 2]]) {
        match self {
            Self::Quad8 => {
                for (a, c) in QUAD8_NODES.iter().enumerate() {
                    let (x, y) = (xi[0] * c[0], xi[1] * c[1]);
                    if c[0] == 0.0 {
                        n[a] = (1.0 - xi[0] * xi[0]) * (1.0 + y) / 2.0;
                        dn[a] = [-xi[0] * (1.0 + y), (1.0 - xi[0] * xi[0]) * c[1] / 2.0];
                    } else if c[1] == 0.0 {
                        n[a] = (1.0 + x) * (1.0 - xi[1] * xi[1]) / 2.0;
                        dn[a] = [c[0] * (1.0 - xi[1] * xi[1]) / 2.0, -xi[1] * (1.0 + x)];
                    } else {
                        n[a] = (1.0 + x) * (1.0 + y) * (x + y - 1.0) / 4.0;
                        dn[a] = [
                            c[0] * (1.0 + y) * (2.0 * x + y) / 4.0,
                            c[1] * (1.0 + x) * (x + 2.0 * y) / 4.0,
                        ];
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shape_functions_are_one_at_their_node_and_zero_at_the_others() {
        let (mut n, mut dn) = ([0.0; 20], [[0.0; 3]; 20]);
        for (a, c) in HEX20_NODES.iter().enumerate() {
            ElementKind::Hex20.shape(*c, &mut n, &mut dn);
            for (b, value) in n.iter().enumerate() {
                assert!((value - f64::from(u8::from(a == b))).abs() < 1e-15);
            }
        }
        let (mut n, mut dn) = ([0.0; 8], [[0.0; 2]; 8]);
        for (a, c) in QUAD8_NODES.iter().enumerate() {
            FaceKind::Quad8.shape(*c, &mut n, &mut dn);
            for (b, value) in n.iter().enumerate() {
                assert!((value - f64::from(u8::from(a == b))).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn gradients_agree_with_differences() {
        let (xi, h) = ([0.3, -0.4, 0.7], 1e-6);
        let (mut n, mut dn) = ([0.0; 20], [[0.0; 3]; 20]);
        ElementKind::Hex20.shape(xi, &mut n, &mut dn);
        for k in 0..3 {
            let (mut up, mut down, mut skip) = ([0.0; 20], [0.0; 20], [[0.0; 3]; 20]);
            let mut at = xi;
            at[k] += h;
            ElementKind::Hex20.shape(at, &mut up, &mut skip);
            at[k] -= 2.0 * h;
            ElementKind::Hex20.shape(at, &mut down, &mut skip);
            for a in 0..20 {
                assert!(((up[a] - down[a]) / (2.0 * h) - dn[a][k]).abs() < 1e-9);
            }
        }
        let xi = [0.3, -0.6];
        let (mut n, mut dn) = ([0.0; 8], [[0.0; 2]; 8]);
        FaceKind::Quad8.shape(xi, &mut n, &mut dn);
        for k in 0..2 {
            let (mut up, mut down, mut skip) = ([0.0; 8], [0.0; 8], [[0.0; 2]; 8]);
            let mut at = xi;
            at[k] += h;
            FaceKind::Quad8.shape(at, &mut up, &mut skip);
            at[k] -= 2.0 * h;
            FaceKind::Quad8.shape(at, &mut down, &mut skip);
            for a in 0..8 {
                assert!(((up[a] - down[a]) / (2.0 * h) - dn[a][k]).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn mid_sides_of_each_face_lie_between_its_corners() {
        for face in HEX20_FACES {
            for k in 0..4 {
                let (p, q, m) = (
                    HEX20_NODES[face[k]],
                    HEX20_NODES[face[(k + 1) % 4]],
                    HEX20_NODES[face[k + 4]],
                );
                for i in 0..3 {
                    assert_eq!((p[i] + q[i]) / 2.0, m[i]);
                }
            }
        }
    }
}
