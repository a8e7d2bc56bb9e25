//! Quadrature points of the far rule on the panels around a cluster's unknowns.

use super::clusters::{Cluster, ClusterTree};
use crate::bem::mesh::boundary::Boundary;
use crate::bem::mesh::panel::PanelShape;
use crate::bem::mesh::rules;
use faer::{Mat, MatRef};
use nalgebra::{Complex, Vector3};

/// Arrays of points are padded to a multiple of the vector width.
pub(super) const LANES: usize = 16;

/// Number of arrays: position, unit normal, area times weight.
pub(super) const FIELDS: usize = 7;

/// The points of all panels in the order of the leaves that own them, and the relation between panels and unknowns.
#[derive(Debug)]
pub(super) struct PanelPoints {
    /// Panels in order.
    panels: Vec<usize>,
    /// Index of the first point of each panel in order, followed by the total number of points.
    first: Vec<usize>,
    /// `FIELDS` consecutive arrays; positions are relative to the centre of the body.
    data: Vec<f32>,
    /// Values of the corner functions at each point.
    corner_values: Vec<[f32; 4]>,
    /// Positions of the unknowns at each panel's corners (panels in order).
    places: Vec<[usize; 4]>,
    /// For each position, the panels that carry its unknown, as indices in `panels`.
    around: Vec<Vec<u32>>,
    /// For each leaf, the index in `panels` of the first panel that it owns, followed by the number of panels.
    owned: Vec<usize>,
    /// Centre of the body, the origin of the positions.
    pub(super) middle: Vector3<f64>,
}

impl PanelPoints {
    /// A panel belongs to the leaf of its first corner.
    pub(super) fn new(boundary: &Boundary, tree: &ClusterTree) -> Self {
        let mesh = boundary.mesh();
        let places = tree.places();
        let corners_of = |p: usize| {
            let mut at = [usize::MAX; 4];
            for (at, &c) in at.iter_mut().zip(mesh.panels[p].corners()) {
                *at = boundary.node_of(c).map_or(usize::MAX, |node| places[node]);
            }
            at
        };
        let leaf_of = |p: usize| tree.leaf_of[tree.order[corners_of(p)[0]]];
        let mut panels: Vec<usize> = (0..mesh.panels.len()).collect();
        panels.sort_by_key(|&p| (leaf_of(p), p));
        let mut owned = vec![0; tree.leaves.len() + 1];
        for &p in &panels {
            owned[leaf_of(p) + 1] += 1;
        }
        for leaf in 0..tree.leaves.len() {
            owned[leaf + 1] += owned[leaf];
        }
        let points = panels.iter().map(|&p| mesh.panels[p].corners().len()).sum();
        let mut low = Vector3::repeat(f64::INFINITY);
        let mut high = -low;
        for &n in mesh.panels.iter().flat_map(|p| p.corners()) {
            low = low.inf(&mesh.points[n].coords);
            high = high.sup(&mesh.points[n].coords);
        }
        let mut all = Self {
            first: Vec::with_capacity(panels.len() + 1),
            data: vec![0.0; FIELDS * points],
            corner_values: Vec::with_capacity(points),
            places: panels.iter().map(|&p| corners_of(p)).collect(),
            around: vec![Vec::new(); tree.order.len()],
            owned,
            middle: (low + high) * 0.5,
            panels,
        };
        let mut number = 0;
        for (q, &p) in all.panels.iter().enumerate() {
            let kind = mesh.panels[p].kind();
            all.first.push(number);
            for (xi, w) in rules::far(kind.corners()) {
                let point = mesh.point_at(p, xi);
                let area = point.area_vector();
                let normal = area.normalize();
                let position = point.position.coords - all.middle;
                let fields = position.iter().chain(&normal).copied().chain([area.norm() * w]);
                for (field, value) in fields.enumerate() {
                    all.data[field * points + number] = value as f32;
                }
                let shape = kind.linear().at(xi);
                all.corner_values.push([0, 1, 2, 3].map(|j| shape.n[j] as f32));
                number += 1;
            }
            for &place in all.places[q].iter().filter(|&&place| place != usize::MAX) {
                all.around[place].push(q as u32);
            }
        }
        all.first.push(number);
        all
    }

    /// Number of points.
    pub(super) fn len(&self) -> usize {
        self.corner_values.len()
    }

    /// Evaluates patterns at all points (points x patterns), given corner values of every panel of the mesh x patterns;
    /// `first_value` is the index of the first corner value of each panel.
    pub(super) fn of_patterns(&self, first_value: &[usize], values: &nalgebra::DMatrix<f64>) -> Mat<f32> {
        let mut at = Mat::zeros(self.len(), values.ncols());
        for (q, &p) in self.panels.iter().enumerate() {
            let points = self.first[q]..self.first[q + 1];
            let corners = points.len();
            for point in points {
                for m in 0..values.ncols() {
                    let corner = |j: usize| f64::from(self.corner_values[point][j]) * values[(first_value[p] + j, m)];
                    at[(point, m)] = (0..corners).map(corner).sum::<f64>() as f32;
                }
            }
        }
        at
    }

    /// For each panel of the mesh, the leaf (an index into [`ClusterTree::leaves`]) that owns it.
    pub(super) fn owners(&self) -> Vec<usize> {
        let mut owners = vec![0; self.panels.len()];
        for leaf in 0..self.owned.len() - 1 {
            for &p in &self.panels[self.owned[leaf]..self.owned[leaf + 1]] {
                owners[p] = leaf;
            }
        }
        owners
    }

    /// The points around a cluster's unknowns.
    pub(super) fn of_cluster(&self, tree: &ClusterTree, cluster: &Cluster) -> ClusterPoints {
        let leaf = |place: usize| tree.leaf_of[tree.order[place]];
        let own = self.owned[leaf(cluster.first)]..self.owned[leaf(cluster.end - 1) + 1];
        let mut rest: Vec<usize> = (cluster.first..cluster.end)
            .flat_map(|place| &self.around[place])
            .map(|&q| q as usize)
            .filter(|q| !own.contains(q))
            .collect();
        rest.sort_unstable();
        rest.dedup();
        let first_point = self.first[own.start];
        let own_points = self.first[own.end] - first_point;
        let panels: Vec<usize> = own.chain(rest).collect();
        let count: usize = panels.iter().map(|&q| self.first[q + 1] - self.first[q]).sum();
        let padded = count.next_multiple_of(LANES);
        let mut points = ClusterPoints {
            count,
            padded,
            own: own_points,
            own_padded: own_points.next_multiple_of(LANES),
            first_point,
            data: vec![0.0; FIELDS * padded],
            to_unknowns: Vec::with_capacity(4 * count),
            unknowns: cluster.len(),
        };
        let mut at = 0;
        for q in panels {
            for point in self.first[q]..self.first[q + 1] {
                for field in 0..FIELDS {
                    points.data[field * padded + at] = self.data[field * self.len() + point];
                }
                for (place, value) in self.places[q].iter().zip(self.corner_values[point]) {
                    if (cluster.first..cluster.end).contains(place) {
                        let unknown = (place - cluster.first) as u32;
                        points.to_unknowns.push((at as u32, unknown, value));
                    }
                }
                at += 1;
            }
        }
        points
    }
}

/// The points on all panels that carry an unknown of a cluster, beginning with the panels that it owns.
#[derive(Debug)]
pub(super) struct ClusterPoints {
    pub(super) count: usize,
    /// Padded length of an array.
    pub(super) padded: usize,
    /// Number of points on the panels that the cluster owns, contiguous from `first_point` in [`PanelPoints`].
    pub(super) own: usize,
    /// The same number, padded.
    pub(super) own_padded: usize,
    pub(super) first_point: usize,
    /// `FIELDS` consecutive arrays, padded with points of zero area.
    pub(super) data: Vec<f32>,
    /// Point, unknown of the cluster, and value of the unknown's function at the point.
    to_unknowns: Vec<(u32, u32, f32)>,
    unknowns: usize,
}

impl ClusterPoints {
    /// Position and unit normal of a point.
    pub(super) fn point(&self, i: usize) -> [f32; 6] {
        std::array::from_fn(|field| self.data[field * self.padded + i])
    }

    /// Area of a point times its weight.
    pub(super) fn weight(&self, i: usize) -> f32 {
        self.data[(FIELDS - 1) * self.padded + i]
    }

    /// Tests with the functions of the unknowns: maps vectors of values at the points, with stride `length` and
    /// imaginary parts `padded` after the real parts, to unknowns x vectors.
    pub(super) fn test(&self, vectors: &[f32], length: usize) -> Mat<Complex<f32>> {
        let mut tested = Mat::zeros(self.unknowns, vectors.len() / length);
        for (column, vector) in vectors.chunks_exact(length).enumerate() {
            let (re, im) = vector.split_at(self.padded);
            let to: &mut [Complex<f32>] = tested.col_as_slice_mut(column);
            for &(point, unknown, value) in &self.to_unknowns {
                let (point, to) = (point as usize, &mut to[unknown as usize]);
                to.re += value * re[point];
                to.im += value * im[point];
            }
        }
        tested
    }

    /// The rows of the points that the cluster owns.
    pub(super) fn own_rows<'a>(&self, of_all: MatRef<'a, f32>) -> MatRef<'a, f32> {
        of_all.subrows(self.first_point, self.own)
    }
}
