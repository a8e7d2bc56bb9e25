use nalgebra::{Point3, Vector3};

/// The shape of a boundary element; its nodes are the corners, outward by the right-hand rule, then the mid-sides
/// following each corner, then the centre.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PanelKind {
    /// Flat triangle.
    Tri3,
    /// Triangle with quadratic sides.
    Tri6,
    /// Bilinear quadrilateral.
    Quad4,
    /// Serendipity quadrilateral.
    Quad8,
    /// Biquadratic quadrilateral.
    Quad9,
}

/// Most nodes of a panel.
pub(super) const MOST_NODES: usize = 9;

/// Natural coordinates of the triangle's nodes.
const TRIANGLE: [[f64; 2]; 6] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]];

/// Natural coordinates of the quadrilateral's nodes.
const SQUARE: [[f64; 2]; 9] = [
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

/// Values and gradients (with respect to natural coordinates) of a panel's shape functions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    pub(super) n: [f64; MOST_NODES],
    pub(super) dn: [[f64; 2]; MOST_NODES],
}

impl PanelKind {
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

    /// Number of corners: 3 or 4.
    pub const fn corners(self) -> usize {
        match self {
            Self::Tri3 | Self::Tri6 => 3,
            _ => 4,
        }
    }

    /// The panel of the same shape with straight sides, whose shape functions carry pressure and normal velocity.
    pub(super) const fn linear(self) -> Self {
        match self {
            Self::Tri3 | Self::Tri6 => Self::Tri3,
            _ => Self::Quad4,
        }
    }

    /// Natural coordinates of the nodes: the unit triangle, or the square from -1 to 1.
    pub fn natural_nodes(self) -> &'static [[f64; 2]] {
        match self.corners() {
            3 => &TRIANGLE[..self.nodes()],
            _ => &SQUARE[..self.nodes()],
        }
    }

    pub(super) fn shape(self, [x, y]: [f64; 2]) -> Shape {
        let mut s = Shape {
            n: [0.0; MOST_NODES],
            dn: [[0.0; 2]; MOST_NODES],
        };
        let mut set = |a: usize, n: f64, dx: f64, dy: f64| {
            s.n[a] = n;
            s.dn[a] = [dx, dy];
        };
        match self {
            Self::Tri3 => {
                set(0, 1.0 - x - y, -1.0, -1.0);
                set(1, x, 1.0, 0.0);
                set(2, y, 0.0, 1.0);
            }
            Self::Tri6 => {
                let z = 1.0 - x - y;
                set(0, z * (2.0 * z - 1.0), 1.0 - 4.0 * z, 1.0 - 4.0 * z);
                set(1, x * (2.0 * x - 1.0), 4.0 * x - 1.0, 0.0);
                set(2, y * (2.0 * y - 1.0), 0.0, 4.0 * y - 1.0);
                set(3, 4.0 * x * z, 4.0 * (z - x), -4.0 * x);
                set(4, 4.0 * x * y, 4.0 * y, 4.0 * x);
                set(5, 4.0 * y * z, -4.0 * y, 4.0 * (z - y));
            }
            Self::Quad4 => {
                for (a, [u, v]) in SQUARE[..4].iter().enumerate() {
                    let (f, g) = (1.0 + u * x, 1.0 + v * y);
                    set(a, 0.25 * f * g, 0.25 * u * g, 0.25 * v * f);
                }
            }
            Self::Quad8 => {
                for (a, [u, v]) in SQUARE[..4].iter().enumerate() {
                    let (f, g, e) = (1.0 + u * x, 1.0 + v * y, u * x + v * y - 1.0);
                    let (dx, dy) = (u * g * (e + f), v * f * (e + g));
                    set(a, 0.25 * f * g * e, 0.25 * dx, 0.25 * dy);
                }
                for (a, [u, v]) in SQUARE[..8].iter().enumerate().skip(4) {
                    if *u == 0.0 {
                        let (f, g) = (1.0 - x * x, 1.0 + v * y);
                        set(a, 0.5 * f * g, -x * g, 0.5 * v * f);
                    } else {
                        let (f, g) = (1.0 + u * x, 1.0 - y * y);
                        set(a, 0.5 * f * g, 0.5 * u * g, -y * f);
                    }
                }
            }
            Self::Quad9 => {
                // One-dimensional quadratic Lagrange functions at -1, 0, 1.
                let line = |t: f64, at: f64| match at {
                    0.0 => (1.0 - t * t, -2.0 * t),
                    at => (0.5 * t * (t + at), t + 0.5 * at),
                };
                for (a, [u, v]) in SQUARE.iter().enumerate() {
                    let ((f, df), (g, dg)) = (line(x, *u), line(y, *v));
                    set(a, f * g, df * g, f * dg);
                }
            }
        }
        s
    }
}

/// A boundary element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Panel {
    kind: PanelKind,
    nodes: [usize; MOST_NODES],
    /// Its patch, an index into [`BoundaryMesh::patches`].
    pub patch: usize,
}

impl Panel {
    /// A panel of the given kind; `nodes` index [`BoundaryMesh::points`] and there must be as many as the kind has.
    pub fn new(kind: PanelKind, nodes: &[usize], patch: usize) -> Option<Self> {
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
    pub fn kind(&self) -> PanelKind {
        self.kind
    }

    /// Its nodes: corners, mid-sides, centre.
    pub fn nodes(&self) -> &[usize] {
        &self.nodes[..self.kind.nodes()]
    }

    /// Its corners.
    pub fn corners(&self) -> &[usize] {
        &self.nodes[..self.kind.corners()]
    }

    /// Turns the normal round.
    pub(super) fn flip(&mut self) {
        let c = self.kind.corners();
        self.nodes[1..c].reverse();
        if self.kind.nodes() >= 2 * c {
            self.nodes[c..2 * c].reverse();
        }
    }
}

/// The surface that radiates: panels with normals into the air.
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
    /// The point of a panel at natural coordinates.
    pub fn point_at(&self, panel: usize, xi: [f64; 2]) -> PanelPoint {
        let p = &self.panels[panel];
        let shape = p.kind.shape(xi);
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
        super::rules::fine(kind)
            .iter()
            .map(|&(xi, w)| w * self.point_at(panel, xi).area_vector().norm())
            .sum()
    }

    /// Area \[m²\].
    pub fn area(&self) -> f64 {
        (0..self.panels.len()).map(|p| self.panel_area(p)).sum()
    }

    /// Longest distance between neighbouring corners of a panel \[m\].
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
