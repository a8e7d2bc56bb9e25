//! Faces of elements: their shapes, shape functions and node lists.

use std::ops::Deref;

use vtkio::model::CellType;

use super::hex::quadratic;

/// The largest number of nodes on a face.
const MOST: usize = 9;

/// The shape of an element face.
///
/// Triangles lie on r, s >= 0, r + s <= 1, quadrilaterals on \[-1, 1\]^2. Corners come first, then the mid-side node
/// that follows each corner, then the centre.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub enum FaceKind {
    /// 3-node triangle, VTK cell type 5.
    Tri3,
    /// 6-node triangle, VTK cell type 22.
    Tri6,
    /// 4-node quadrilateral, VTK cell type 9.
    Quad4,
    /// 8-node serendipity quadrilateral, VTK cell type 23.
    Quad8,
    /// 9-node quadrilateral, VTK cell type 28.
    Quad9,
}

const TRIANGLE: [[f64; 2]; 6] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]];

const QUADRILATERAL: [[f64; 2]; 9] = [
    [-1.0, -1.0],
    [1.0, -1.0],
    [1.0, 1.0],
    [-1.0, 1.0],
    [0.0, -1.0],
    [1.0, 0.0],
    [0.0, 1.0],
    [-1.0, 0.0],
    [0.0, 0.0],
];

impl FaceKind {
    /// All kinds.
    pub const ALL: [Self; 5] = [Self::Tri3, Self::Tri6, Self::Quad4, Self::Quad8, Self::Quad9];

    /// Number of nodes.
    pub const fn nodes(self) -> usize {
        match self {
            Self::Tri3 => 3,
            Self::Tri6 => 6,
            Self::Quad4 => 4,
            Self::Quad8 => 8,
            Self::Quad9 => 9,
        }
    }

    /// Number of corner nodes, which come first and equal the number of edges.
    pub const fn corners(self) -> usize {
        match self {
            Self::Tri3 | Self::Tri6 => 3,
            Self::Quad4 | Self::Quad8 | Self::Quad9 => 4,
        }
    }

    /// The VTK cell type.
    pub(crate) const fn vtk_type(self) -> CellType {
        match self {
            Self::Tri3 => CellType::Triangle,
            Self::Tri6 => CellType::QuadraticTriangle,
            Self::Quad4 => CellType::Quad,
            Self::Quad8 => CellType::QuadraticQuad,
            Self::Quad9 => CellType::BiquadraticQuad,
        }
    }

    /// Natural coordinates of the nodes.
    pub fn natural_nodes(self) -> &'static [[f64; 2]] {
        match self.corners() {
            3 => &TRIANGLE[..self.nodes()],
            _ => &QUADRILATERAL[..self.nodes()],
        }
    }

    /// Natural coordinates of the centroid.
    pub const fn centre(self) -> [f64; 2] {
        match self.corners() {
            3 => [1.0 / 3.0; 2],
            _ => [0.0; 2],
        }
    }

    /// Distance by which natural coordinates lie outside the face: 0 or less inside.
    pub fn outside(self, xi: [f64; 2]) -> f64 {
        match self.corners() {
            3 => (-xi[0]).max(-xi[1]).max(xi[0] + xi[1] - 1.0),
            _ => xi[0].abs().max(xi[1].abs()) - 1.0,
        }
    }

    /// Shape functions and their gradients with respect to the two natural coordinates at `xi`; entries beyond
    /// [`Self::nodes`] are left unchanged.
    ///
    /// With L_0 = 1 - r - s, L_1 = r, L_2 = s and x = xi xi_a, y = eta eta_a:
    /// Tri3 L_a;  Tri6 L_a (2 L_a - 1) and 4 L_a L_b;  Quad4 (1 + x)(1 + y) / 4;
    /// Quad8 (1 + x)(1 + y)(x + y - 1) / 4 and, where xi_a = 0, (1 - xi^2)(1 + y) / 2;
    /// Quad9 products of the quadratic functions of one coordinate.
    pub fn shape(self, xi: [f64; 2], n: &mut [f64], dn: &mut [[f64; 2]]) {
        match self {
            Self::Tri3 | Self::Tri6 => triangle(self, xi, n, dn),
            Self::Quad4 => {
                for (a, c) in QUADRILATERAL[..4].iter().enumerate() {
                    let (x, y) = (1.0 + xi[0] * c[0], 1.0 + xi[1] * c[1]);
                    n[a] = x * y / 4.0;
                    dn[a] = [c[0] * y / 4.0, c[1] * x / 4.0];
                }
            }
            Self::Quad8 => serendipity(xi, n, dn),
            Self::Quad9 => {
                for (a, c) in QUADRILATERAL.iter().enumerate() {
                    let ((f, df), (g, dg)) = (quadratic(xi[0], c[0]), quadratic(xi[1], c[1]));
                    n[a] = f * g;
                    dn[a] = [df * g, f * dg];
                }
            }
        }
    }
}

fn triangle(kind: FaceKind, xi: [f64; 2], n: &mut [f64], dn: &mut [[f64; 2]]) {
    const SLOPES: [[f64; 2]; 3] = [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]];
    let l = [1.0 - xi[0] - xi[1], xi[0], xi[1]];
    if kind == FaceKind::Tri3 {
        n[..3].copy_from_slice(&l);
        dn[..3].copy_from_slice(&SLOPES);
        return;
    }
    for a in 0..3 {
        let b = (a + 1) % 3;
        n[a] = l[a] * (2.0 * l[a] - 1.0);
        dn[a] = SLOPES[a].map(|d| (4.0 * l[a] - 1.0) * d);
        n[3 + a] = 4.0 * l[a] * l[b];
        dn[3 + a] = [0, 1].map(|k| 4.0 * (SLOPES[a][k] * l[b] + l[a] * SLOPES[b][k]));
    }
}

fn serendipity(xi: [f64; 2], n: &mut [f64], dn: &mut [[f64; 2]]) {
    for (a, c) in QUADRILATERAL[..8].iter().enumerate() {
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

/// The nodes of one face, at most nine, without allocation: corners outward by the right-hand rule, then mid-sides,
/// then the centre.
#[derive(Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub struct FaceNodes {
    // Unused entries are zero, so that equality can be derived.
    nodes: [usize; MOST],
    len: usize,
}

impl FaceNodes {
    /// Collects the nodes of a face from an iterator; excess nodes beyond nine are dropped.
    pub(crate) fn of(nodes: impl Iterator<Item = usize>) -> Self {
        let mut list = Self {
            nodes: [0; MOST],
            len: 0,
        };
        for (place, node) in list.nodes.iter_mut().zip(nodes) {
            *place = node;
            list.len += 1;
        }
        list
    }

    /// Applies a function to every node.
    #[must_use]
    pub fn map(self, node: impl FnMut(usize) -> usize) -> Self {
        Self::of(self.into_iter().map(node))
    }
}

impl Deref for FaceNodes {
    type Target = [usize];

    fn deref(&self) -> &[usize] {
        &self.nodes[..self.len]
    }
}

impl std::fmt::Debug for FaceNodes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}

impl IntoIterator for FaceNodes {
    type Item = usize;
    type IntoIter = std::iter::Take<std::array::IntoIter<usize, MOST>>;

    fn into_iter(self) -> Self::IntoIter {
        self.nodes.into_iter().take(self.len)
    }
}

impl<'a> IntoIterator for &'a FaceNodes {
    type Item = &'a usize;
    type IntoIter = std::slice::Iter<'a, usize>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}
