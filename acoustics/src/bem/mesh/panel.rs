use nailnoise_meshes::{FaceKind, Surface};
use nalgebra::{Point3, Vector3};

/// Largest number of nodes of a panel.
pub(crate) const MOST_NODES: usize = 9;

/// Values and gradients (with respect to natural coordinates) of a panel's shape functions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    pub(crate) n: [f64; MOST_NODES],
    pub(crate) dn: [[f64; 2]; MOST_NODES],
}

/// Shape functions of a face.
pub(crate) trait PanelShape {
    /// The straight-sided face with the same corners, whose shape functions interpolate pressure and normal velocity.
    fn linear(self) -> FaceKind;

    /// The shape functions at natural coordinates; zero beyond the face's nodes.
    fn at(self, xi: [f64; 2]) -> Shape;
}

impl PanelShape for FaceKind {
    fn linear(self) -> FaceKind {
        if self.corners() == 3 {
            FaceKind::Tri3
        } else {
            FaceKind::Quad4
        }
    }

    fn at(self, xi: [f64; 2]) -> Shape {
        let mut shape = Shape {
            n: [0.0; MOST_NODES],
            dn: [[0.0; 2]; MOST_NODES],
        };
        self.shape(xi, &mut shape.n, &mut shape.dn);
        shape
    }
}

/// A boundary element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Panel {
    kind: FaceKind,
    nodes: [usize; MOST_NODES],
    /// Its patch, an index into [`BoundaryMesh::patches`].
    pub patch: usize,
}

impl Panel {
    /// Creates a panel of the given kind; `nodes` are indices into [`BoundaryMesh::points`], as many as the kind has.
    pub fn new(kind: FaceKind, nodes: &[usize], patch: usize) -> Option<Self> {
        let mut all = [0; MOST_NODES];
        if nodes.len() != kind.nodes() {
            return None;
        }
        all[..nodes.len()].copy_from_slice(nodes);
        Some(Self {
            kind,
            nodes: all,
            patch,
        })
    }

    /// Its shape.
    pub fn kind(&self) -> FaceKind {
        self.kind
    }

    /// Its nodes: corners, mid-side nodes, centre.
    pub fn nodes(&self) -> &[usize] {
        &self.nodes[..self.kind.nodes()]
    }

    /// Its corners.
    pub fn corners(&self) -> &[usize] {
        &self.nodes[..self.kind.corners()]
    }

    /// Reverses the normal.
    pub(crate) fn flip(&mut self) {
        let c = self.kind.corners();
        self.nodes[1..c].reverse();
        if self.kind.nodes() >= 2 * c {
            self.nodes[c..2 * c].reverse();
        }
    }
}

/// The radiating surface: panels with normals into the air.
#[derive(Clone, Debug, Default)]
pub struct BoundaryMesh {
    /// Positions \[m\].
    pub points: Vec<Point3<f64>>,
    /// The panels.
    pub panels: Vec<Panel>,
    /// Names of the patches.
    pub patches: Vec<String>,
}

/// A point on a panel.
#[derive(Clone, Copy, Debug)]
pub struct PanelPoint {
    /// Position \[m\].
    pub position: Point3<f64>,
    /// Tangents dx/dxi and dx/deta.
    pub tangents: [Vector3<f64>; 2],
}

impl PanelPoint {
    /// Normal times the area factor, t_1 x t_2.
    pub fn area_vector(&self) -> Vector3<f64> {
        self.tangents[0].cross(&self.tangents[1])
    }
}

impl BoundaryMesh {
    /// Converts the skin of a volume mesh; points and patches keep their indices.
    pub fn of_skin(skin: &Surface) -> Self {
        let panel = |f: &nailnoise_meshes::SurfaceFace| {
            let mut nodes = [0; MOST_NODES];
            nodes[..f.nodes.len()].copy_from_slice(&f.nodes);
            Panel {
                kind: f.kind,
                nodes,
                patch: f.patch,
            }
        };
        Self {
            points: skin.points.clone(),
            panels: skin.faces.iter().map(panel).collect(),
            patches: skin.patches.clone(),
        }
    }

    /// The point of a panel at natural coordinates.
    pub fn point_at(&self, panel: usize, xi: [f64; 2]) -> PanelPoint {
        let p = &self.panels[panel];
        let shape = p.kind.at(xi);
        let (mut x, mut t) = (Vector3::zeros(), [Vector3::zeros(); 2]);
        for (a, &node) in p.nodes().iter().enumerate() {
            let c = self.points[node].coords;
            x += shape.n[a] * c;
            t[0] += shape.dn[a][0] * c;
            t[1] += shape.dn[a][1] * c;
        }
        PanelPoint {
            position: Point3::from(x),
            tangents: t,
        }
    }

    /// Area of one panel \[m²\].
    pub fn panel_area(&self, panel: usize) -> f64 {
        let kind = self.panels[panel].kind;
        crate::bem::mesh::rules::fine(kind)
            .iter()
            .map(|&(xi, w)| w * self.point_at(panel, xi).area_vector().norm())
            .sum()
    }

    /// Area \[m²\].
    pub fn area(&self) -> f64 {
        (0..self.panels.len()).map(|p| self.panel_area(p)).sum()
    }

    /// Largest distance between adjacent corners of a panel \[m\].
    pub fn longest_edge(&self) -> f64 {
        let edge = |p: &Panel| {
            let c = p.corners();
            (0..c.len())
                .map(|k| (self.points[c[k]] - self.points[c[(k + 1) % c.len()]]).norm())
                .fold(0.0, f64::max)
        };
        self.panels.iter().map(edge).fold(0.0, f64::max)
    }
}
