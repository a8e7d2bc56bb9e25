//! Clusters of neighbouring pressure unknowns; pairs of clusters divide the matrix into blocks.

use crate::bem::mesh::boundary::Boundary;
use crate::bem::operators::near::{FAR_RATIO, sphere};
use nalgebra::Vector3;

/// Largest number of unknowns in a cluster that is not divided.
const LEAF: usize = 64;
/// Two clusters are distant if the diameter of the smaller one is at most eta times the distance between them.
const ETA: f64 = 2.0;

/// A set of unknowns that are close in space and contiguous in [`ClusterTree::order`].
#[derive(Debug)]
pub(super) struct Cluster {
    /// First position in the order.
    pub(super) first: usize,
    /// Position after the last one.
    pub(super) end: usize,
    /// The two halves; none for a leaf.
    pub(super) halves: Option<[usize; 2]>,
    /// Bounding box of all panels that carry an unknown of the cluster.
    low: Vector3<f64>,
    high: Vector3<f64>,
    /// Half of the largest distance below which two panels are too close for the far rule \[m\]; each side contributes
    /// its half.
    reach: f64,
}

impl Cluster {
    pub(super) fn len(&self) -> usize {
        self.end - self.first
    }

    fn diameter(&self) -> f64 {
        (self.high - self.low).norm()
    }

    /// Distance between the boxes of two clusters \[m\].
    pub(super) fn distance(&self, other: &Self) -> f64 {
        let gap = |c: usize| (self.low[c] - other.high[c]).max(other.low[c] - self.high[c]).max(0.0);
        Vector3::from_fn(|c, _| gap(c)).norm()
    }

    /// Whether the operators between the two clusters have low rank and all their panels are far apart.
    ///
    /// A body lies on one side of its mirror planes, so the image of a cluster is at least as far from another one as
    /// the cluster itself. Distant clusters are therefore distant in all images.
    fn is_distant_from(&self, other: &Self) -> bool {
        let distance = self.distance(other);
        self.diameter().min(other.diameter()) <= ETA * distance && distance > self.reach + other.reach
    }
}

/// Clusters of the pressure unknowns, obtained by repeatedly halving along the longest side of the bounding box.
#[derive(Debug)]
pub(super) struct ClusterTree {
    /// All clusters, beginning with the root.
    pub(super) clusters: Vec<Cluster>,
    /// The unknown at each position; the unknowns of any cluster are contiguous.
    pub(super) order: Vec<usize>,
    /// The leaves in the order of their positions.
    pub(super) leaves: Vec<usize>,
    /// For each unknown, the number of its leaf (an index into `leaves`).
    pub(super) leaf_of: Vec<usize>,
}

impl ClusterTree {
    pub(super) fn new(boundary: &Boundary) -> Self {
        let mesh = boundary.mesh();
        let n = boundary.nodes();
        let infinite = Vector3::repeat(f64::INFINITY);
        let mut positions = vec![Vector3::zeros(); n];
        let mut supports = vec![(infinite, -infinite, 0.0f64); n];
        for (p, panel) in mesh.panels.iter().enumerate() {
            let points = || panel.nodes().iter().map(|&p| mesh.points[p].coords);
            let low = points().fold(infinite, |low, p| low.inf(&p));
            let high = points().fold(-infinite, |high, p| high.sup(&p));
            let reach = FAR_RATIO * sphere(mesh, p).1;
            for &corner in panel.corners() {
                let Some(node) = boundary.node_of(corner) else { continue };
                positions[node] = mesh.points[corner].coords;
                let support = &mut supports[node];
                *support = (support.0.inf(&low), support.1.sup(&high), support.2.max(reach));
            }
        }
        let mut tree = Self {
            clusters: Vec::new(),
            order: (0..n).collect(),
            leaves: Vec::new(),
            leaf_of: vec![0; n],
        };
        tree.divide(0, n, &positions, &supports);
        tree
    }

    /// Adds the cluster of these positions and all its subclusters; returns its number.
    fn divide(
        &mut self,
        first: usize,
        end: usize,
        positions: &[Vector3<f64>],
        supports: &[(Vector3<f64>, Vector3<f64>, f64)],
    ) -> usize {
        let number = self.clusters.len();
        let nodes = &mut self.order[first..end];
        let infinite = Vector3::repeat(f64::INFINITY);
        let mut cluster = Cluster {
            first,
            end,
            halves: None,
            low: infinite,
            high: -infinite,
            reach: 0.0,
        };
        let (mut low, mut high) = (infinite, -infinite);
        for &node in nodes.iter() {
            let (support_low, support_high, reach) = &supports[node];
            cluster.low = cluster.low.inf(support_low);
            cluster.high = cluster.high.sup(support_high);
            cluster.reach = cluster.reach.max(*reach);
            low = low.inf(&positions[node]);
            high = high.sup(&positions[node]);
        }
        self.clusters.push(cluster);
        if end - first <= LEAF {
            for &node in &self.order[first..end] {
                self.leaf_of[node] = self.leaves.len();
            }
            self.leaves.push(number);
            return number;
        }
        let axis = (high - low).imax();
        nodes.sort_by(|&a, &b| positions[a][axis].total_cmp(&positions[b][axis]).then(a.cmp(&b)));
        let middle = first + (end - first).div_ceil(2);
        let halves = [(first, middle), (middle, end)].map(|(a, b)| self.divide(a, b, positions, supports));
        self.clusters[number].halves = Some(halves);
        number
    }

    /// The position of each unknown.
    pub(super) fn places(&self) -> Vec<usize> {
        let mut places = vec![0; self.order.len()];
        for (place, &node) in self.order.iter().enumerate() {
            places[node] = place;
        }
        places
    }

    /// Partitions the matrix into blocks.
    pub(super) fn partition(&self) -> Partition {
        let mut partition = Partition::default();
        if !self.order.is_empty() {
            self.refine(0, 0, &mut partition);
        }
        partition
    }

    fn refine(&self, t: usize, s: usize, to: &mut Partition) {
        let [rows, columns] = [t, s].map(|c| &self.clusters[c]);
        if rows.is_distant_from(columns) {
            to.distant.push([t, s]);
            return;
        }
        match (rows.halves, columns.halves) {
            (None, None) => to.near.push([t, s]),
            (Some(halves), None) => halves.into_iter().for_each(|t| self.refine(t, s, to)),
            (None, Some(halves)) => halves.into_iter().for_each(|s| self.refine(t, s, to)),
            (Some(first), Some(second)) => {
                for t in first {
                    second.into_iter().for_each(|s| self.refine(t, s, to));
                }
            }
        }
    }
}

/// Pairs of clusters, rows and columns.
#[derive(Debug, Default)]
pub(super) struct Partition {
    /// Pairs of distant clusters, whose blocks have low rank.
    pub(super) distant: Vec<[usize; 2]>,
    /// Pairs of close leaves.
    pub(super) near: Vec<[usize; 2]>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bem::mesh::boxes::SolidBox;
    use crate::bem::mesh::panel::BoundaryMesh;

    fn tree() -> ClusterTree {
        let solid = SolidBox {
            low: [0.0; 3],
            high: [1.0, 0.6, 0.3],
            part: 0,
        };
        let mesh = BoundaryMesh::of_boxes(&[solid], [None; 3], 0.04, vec!["all".to_owned()], |_| 0).unwrap();
        ClusterTree::new(&Boundary::new(mesh, None).unwrap())
    }

    #[test]
    fn the_blocks_cover_every_entry_once() {
        let tree = tree();
        let n = tree.order.len();
        let partition = tree.partition();
        let mut covered = vec![0u8; n * n];
        for &[t, s] in partition.distant.iter().chain(&partition.near) {
            let [t, s] = [t, s].map(|c| &tree.clusters[c]);
            for i in t.first..t.end {
                covered[i * n + s.first..i * n + s.end].iter_mut().for_each(|c| *c += 1);
            }
        }
        assert!(covered.iter().all(|&c| c == 1));
        assert!(partition.distant.len() > 100 && partition.near.len() > 100);
    }

    #[test]
    fn every_unknown_has_one_place_and_one_leaf() {
        let tree = tree();
        let places = tree.places();
        for (node, &place) in places.iter().enumerate() {
            assert_eq!(tree.order[place], node);
            let leaf = &tree.clusters[tree.leaves[tree.leaf_of[node]]];
            assert!((leaf.first..leaf.end).contains(&place) && leaf.len() <= LEAF);
        }
    }
}
