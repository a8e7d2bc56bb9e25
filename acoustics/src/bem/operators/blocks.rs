use crate::bem::mesh::boundary::Boundary;
use crate::bem::mesh::panel::{PanelShape, Shape};
use crate::bem::mesh::rules;
use faer::Mat;
use nailnoise_meshes::FaceKind;
use nalgebra::{DMatrix, Vector3};

/// Largest number of panels in a block.
const MOST: usize = 16;
/// Block widths are padded to a multiple of the widest vector.
const LANES: usize = 16;

/// Fields of a quadrature point that precede the surface curls: position, vector area times weight, area times weight.
pub(crate) const X: usize = 0;
pub(crate) const N: usize = 3;
pub(crate) const W: usize = 6;
pub(crate) const C: usize = 7;

/// Number of fields of a quadrature point of panels with this many corners. The curls of all corner functions except
/// the last are stored; the last is the negative of their sum.
pub(crate) const fn fields(corners: usize) -> usize {
    C + 3 * (corners - 1)
}

/// Neighbouring panels with equal numbers of corners; the points of the far rule are stored as separate arrays.
#[derive(Debug)]
pub(crate) struct Block {
    pub(crate) corners: usize,
    pub(crate) panels: Vec<usize>,
    /// Number of panels, padded.
    pub(crate) width: usize,
    /// Pressure unknowns of the block.
    pub(crate) nodes: Vec<usize>,
    /// Indices of each panel's corners in `nodes`.
    pub(crate) local: Vec<[usize; 4]>,
    /// Corners j of panels f, as j * width + f, grouped by node; those of node n end at `columns_end[n]`.
    pub(crate) columns: Vec<usize>,
    pub(crate) columns_end: Vec<usize>,
    /// First velocity value of each panel.
    pub(crate) first_value: Vec<usize>,
    /// `points[(b * fields + field) * width + panel]`.
    pub(crate) points: Vec<f64>,
    /// Centre of the panels, the origin of `single`.
    pub(crate) middle: [f64; 3],
    /// The points in single precision: position relative to `middle`, unit normal, area, curls divided by area.
    pub(crate) single: Vec<f32>,
}

/// Divides the surface into blocks, triangles first, and numbers the pressure unknowns block by block, so that the
/// contributions of a block are contiguous in memory.
pub(crate) fn blocks(boundary: &mut Boundary) -> Vec<Block> {
    let mesh = boundary.mesh();
    let centre = |p: usize| {
        let corners = mesh.panels[p].corners();
        corners.iter().map(|&n| mesh.points[n].coords).sum::<Vector3<f64>>() / corners.len() as f64
    };
    let centres: Vec<Vector3<f64>> = (0..mesh.panels.len()).map(centre).collect();
    let mut first_value = Vec::with_capacity(mesh.panels.len());
    let mut values = 0;
    for panel in &mesh.panels {
        first_value.push(values);
        values += panel.corners().len();
    }
    let mut groups = Vec::new();
    for corners in [3, 4] {
        let of_kind = |&p: &usize| mesh.panels[p].corners().len() == corners;
        let panels: Vec<usize> = (0..mesh.panels.len()).filter(of_kind).collect();
        bisect(panels, &centres, &mut groups);
    }
    boundary.number_nodes(groups.iter().flatten());
    let block = |group: Vec<usize>| Block::new(boundary, group, &first_value);
    groups.into_iter().map(block).collect()
}

fn bisect(mut panels: Vec<usize>, centres: &[Vector3<f64>], groups: &mut Vec<Vec<usize>>) {
    if panels.len() <= MOST {
        if !panels.is_empty() {
            groups.push(panels);
        }
        return;
    }
    let (mut low, mut high) = (centres[panels[0]], centres[panels[0]]);
    for &p in &panels {
        low = low.inf(&centres[p]);
        high = high.sup(&centres[p]);
    }
    let axis = (high - low).imax();
    panels.sort_by(|&a, &b| centres[a][axis].total_cmp(&centres[b][axis]).then(a.cmp(&b)));
    // Full blocks on the left confine the padding to the last block.
    let rest = panels.split_off(panels.len().div_ceil(MOST).div_ceil(2) * MOST);
    bisect(panels, centres, groups);
    bisect(rest, centres, groups);
}

impl Block {
    /// Patterns, given by corner values of each panel, evaluated at the points of the block's panels: patterns x
    /// points, with the panel index fastest.
    pub(crate) fn patterns(&self, velocities: &DMatrix<f64>) -> Mat<f32> {
        let kind = if self.corners == 3 {
            FaceKind::Tri3
        } else {
            FaceKind::Quad4
        };
        let shapes: Vec<Shape> = rules::far(self.corners).iter().map(|&(xi, _)| kind.at(xi)).collect();
        let mut m = Mat::zeros(velocities.ncols(), self.corners * self.width);
        for (mode, velocities) in velocities.column_iter().enumerate() {
            for (f, &first) in self.first_value.iter().enumerate() {
                let corners = &velocities.as_slice()[first..first + self.corners];
                for (point, shape) in shapes.iter().enumerate() {
                    let value: f64 = corners.iter().zip(&shape.n).map(|(v, n)| v * n).sum();
                    m[(mode, point * self.width + f)] = value as f32;
                }
            }
        }
        m
    }

    fn new(boundary: &Boundary, panels: Vec<usize>, first_value: &[usize]) -> Self {
        let mesh = boundary.mesh();
        let corners = mesh.panels[panels[0]].corners().len();
        let width = panels.len().next_multiple_of(LANES);
        let (mut nodes, mut local) = (Vec::new(), Vec::new());
        let rule = rules::far(corners);
        let fields = fields(corners);
        let mut points = vec![0.0; rule.len() * fields * width];
        for (f, &p) in panels.iter().enumerate() {
            let panel = &mesh.panels[p];
            let mut of_panel = [0; 4];
            for (slot, &c) in of_panel.iter_mut().zip(panel.corners()) {
                let node = boundary.node_of(c).unwrap_or(usize::MAX);
                *slot = nodes.iter().position(|&n| n == node).unwrap_or_else(|| {
                    nodes.push(node);
                    nodes.len() - 1
                });
            }
            local.push(of_panel);
            for (b, &(xi, w)) in rule.iter().enumerate() {
                let point = mesh.point_at(p, xi);
                let area = point.area_vector() * w;
                let shape = panel.kind().linear().at(xi);
                let mut set = |field: usize, v: &[f64]| {
                    for (k, v) in v.iter().enumerate() {
                        points[(b * fields + field + k) * width + f] = *v;
                    }
                };
                set(X, point.position.coords.as_slice());
                set(N, area.as_slice());
                set(W, &[area.norm()]);
                for j in 0..corners - 1 {
                    let curl = point.tangents[1] * shape.dn[j][0] - point.tangents[0] * shape.dn[j][1];
                    set(C + 3 * j, (curl * w).as_slice());
                }
            }
        }
        let mut columns_of: Vec<Vec<usize>> = vec![Vec::new(); nodes.len()];
        for j in 0..corners {
            for (f, of_panel) in local.iter().enumerate() {
                columns_of[of_panel[j]].push(j * width + f);
            }
        }
        let ends = columns_of.iter().scan(0, |end, columns| {
            *end += columns.len();
            Some(*end)
        });
        let at = |point: usize, field: usize, f: usize| points[(point * fields + field) * width + f];
        let middle = [0, 1, 2].map(|c| (0..panels.len()).map(|f| at(0, X + c, f)).sum::<f64>() / panels.len() as f64);
        let mut single = vec![0.0; points.len()];
        for point in 0..rule.len() {
            for field in 0..fields {
                for f in 0..panels.len() {
                    let value = match field {
                        N.. if field != W => at(point, field, f) / at(point, W, f),
                        W => at(point, W, f),
                        _ => at(point, field, f) - middle[field - X],
                    };
                    single[(point * fields + field) * width + f] = value as f32;
                }
            }
        }
        Self {
            corners,
            width,
            middle,
            single,
            nodes,
            columns_end: ends.collect(),
            columns: columns_of.concat(),
            local,
            first_value: panels.iter().map(|&p| first_value[p]).collect(),
            panels,
            points,
        }
    }
}
