//! Element kinds: node numbering, faces and shape functions. Node order is VTK's.

mod face;
mod hex;
mod rule;
mod tet;
mod wedge;

pub use face::{FaceKind, FaceNodes};
use vtkio::model::CellType;

/// The shape of an element and its order of interpolation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub enum ElementKind {
    /// 8-node hexahedron, VTK cell type 12.
    Hex8,
    /// 20-node serendipity hexahedron, VTK cell type 25.
    Hex20,
    /// 27-node hexahedron, VTK cell type 29.
    Hex27,
    /// 4-node tetrahedron, VTK cell type 10.
    Tet4,
    /// 10-node tetrahedron, VTK cell type 24.
    Tet10,
    /// 15-node serendipity wedge, VTK cell type 26.
    Wedge15,
}

/// A family of element kinds with common properties.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Family {
    Hex,
    Tet,
    Wedge,
}

impl ElementKind {
    /// All kinds.
    pub const ALL: [Self; 6] = [
        Self::Hex8,
        Self::Hex20,
        Self::Hex27,
        Self::Tet4,
        Self::Tet10,
        Self::Wedge15,
    ];

    const fn family(self) -> Family {
        match self {
            Self::Hex8 | Self::Hex20 | Self::Hex27 => Family::Hex,
            Self::Tet4 | Self::Tet10 => Family::Tet,
            Self::Wedge15 => Family::Wedge,
        }
    }

    /// Number of nodes.
    pub const fn nodes(self) -> usize {
        match self {
            Self::Hex8 => 8,
            Self::Hex20 => 20,
            Self::Hex27 => 27,
            Self::Tet4 => 4,
            Self::Tet10 => 10,
            Self::Wedge15 => 15,
        }
    }

    /// Number of corner nodes, which come first.
    pub const fn corners(self) -> usize {
        match self.family() {
            Family::Hex => 8,
            Family::Tet => 4,
            Family::Wedge => 6,
        }
    }

    /// Degree of the complete polynomials in the shape functions: 1 or 2.
    pub const fn order(self) -> usize {
        match self {
            Self::Hex8 | Self::Tet4 => 1,
            Self::Hex20 | Self::Hex27 | Self::Tet10 | Self::Wedge15 => 2,
        }
    }

    /// Local node numbers of each face, ordered so that the normal points out of the element: corners, then the
    /// mid-side node that follows each corner, then the centre.
    pub const fn faces(self) -> &'static [&'static [usize]] {
        match self {
            Self::Hex8 => &hex::FACES_8,
            Self::Hex20 => &hex::FACES_20,
            Self::Hex27 => &hex::FACES_27,
            Self::Tet4 => &tet::FACES_4,
            Self::Tet10 => &tet::FACES_10,
            Self::Wedge15 => &wedge::FACES,
        }
    }

    /// Shape of the face with this number.
    pub const fn face_kind(self, face: usize) -> FaceKind {
        match self {
            Self::Hex8 => FaceKind::Quad4,
            Self::Hex20 => FaceKind::Quad8,
            Self::Hex27 => FaceKind::Quad9,
            Self::Tet4 => FaceKind::Tri3,
            Self::Tet10 => FaceKind::Tri6,
            Self::Wedge15 if face < 2 => FaceKind::Tri6,
            Self::Wedge15 => FaceKind::Quad8,
        }
    }

    /// Local corner numbers of each edge; in the quadratic kinds the mid-side of edge i is node `corners() + i`.
    pub const fn edges(self) -> &'static [[usize; 2]] {
        match self.family() {
            Family::Hex => &hex::EDGES,
            Family::Tet => &tet::EDGES,
            Family::Wedge => &wedge::EDGES,
        }
    }

    /// The VTK cell type.
    pub(crate) const fn vtk_type(self) -> CellType {
        match self {
            Self::Hex8 => CellType::Hexahedron,
            Self::Hex20 => CellType::QuadraticHexahedron,
            Self::Hex27 => CellType::TriquadraticHexahedron,
            Self::Tet4 => CellType::Tetra,
            Self::Tet10 => CellType::QuadraticTetra,
            Self::Wedge15 => CellType::QuadraticWedge,
        }
    }

    /// Natural coordinates of the nodes.
    pub fn natural_nodes(self) -> &'static [[f64; 3]] {
        let all: &'static [[f64; 3]] = match self.family() {
            Family::Hex => &hex::NODES,
            Family::Tet => &tet::NODES,
            Family::Wedge => &wedge::NODES,
        };
        &all[..self.nodes()]
    }

    /// Natural coordinates of the centroid.
    pub const fn centre(self) -> [f64; 3] {
        match self.family() {
            Family::Hex => [0.0; 3],
            Family::Tet => [0.25; 3],
            Family::Wedge => [1.0 / 3.0, 1.0 / 3.0, 0.0],
        }
    }

    /// Distance by which natural coordinates lie outside the element: 0 or less inside.
    pub fn outside(self, xi: [f64; 3]) -> f64 {
        let [x, y, z] = xi;
        match self.family() {
            Family::Hex => x.abs().max(y.abs()).max(z.abs()) - 1.0,
            Family::Tet => (-x).max(-y).max(-z).max(x + y + z - 1.0),
            Family::Wedge => (-x).max(-y).max(x + y - 1.0).max(z.abs() - 1.0),
        }
    }

    /// Moves natural coordinates back into the element if they lie outside.
    pub fn clamped(self, xi: [f64; 3]) -> [f64; 3] {
        let square = |v: f64| v.clamp(-1.0, 1.0);
        // If the sum exceeds 1, all coordinates are scaled by the same factor.
        let simplex = |v: &mut [f64]| {
            v.iter_mut().for_each(|v| *v = v.max(0.0));
            let sum = v.iter().sum::<f64>().max(1.0);
            v.iter_mut().for_each(|v| *v /= sum);
        };
        let mut inside = xi;
        match self.family() {
            Family::Hex => inside = xi.map(square),
            Family::Tet => simplex(&mut inside),
            Family::Wedge => {
                simplex(&mut inside[..2]);
                inside[2] = square(xi[2]);
            }
        }
        inside
    }

    /// Shape functions N_a and their gradients with respect to natural coordinates at `xi`; entries beyond
    /// [`Self::nodes`] are left unchanged.
    pub fn shape(self, xi: [f64; 3], n: &mut [f64], dn: &mut [[f64; 3]]) {
        match self {
            Self::Hex8 => hex::shape_8(xi, n, dn),
            Self::Hex20 => hex::shape_20(xi, n, dn),
            Self::Hex27 => hex::shape_27(xi, n, dn),
            Self::Tet4 => tet::shape_4(xi, n, dn),
            Self::Tet10 => tet::shape_10(xi, n, dn),
            Self::Wedge15 => wedge::shape(xi, n, dn),
        }
    }
}

#[cfg(test)]
mod tests;
