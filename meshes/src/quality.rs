//! Mesh quality: Jacobians, closedness, orientation, connectivity, and element size for a frequency.

use nalgebra::{Matrix3, Point3, Vector3};

use crate::{ElementRef, Mesh, MeshError, Surface};

/// Results of [`Mesh::quality`].
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Quality {
    /// The element with the smallest ratio of Jacobians.
    pub worst: Jacobian,
    /// Number of elements whose Jacobian is not positive everywhere.
    pub inverted: usize,
    /// Number of elements whose ratio of Jacobians is below [`POOR`].
    pub poor: usize,
    /// Number of edges of the skin that do not join two faces of consistent orientation: 0 for a closed, consistently
    /// oriented skin.
    pub open_edges: usize,
    /// Volume enclosed by the skin, from the divergence theorem \[m3\]; negative if it is inside out.
    pub skin_volume: f64,
    /// Volume of all elements \[m3\].
    pub volume: f64,
    /// Area of the skin \[m2\].
    pub skin_area: f64,
    /// Number of connected pieces, which share no nodes.
    pub pieces: usize,
    /// Number of nodes that coincide with another node within 1e-6 of the size of the mesh.
    pub coincident_nodes: usize,
    /// Shortest distance between two corners of one element \[m\].
    pub shortest_edge: f64,
    /// Longest edge of an element \[m\].
    pub longest_edge: f64,
}

/// The Jacobian determinant of an element, evaluated at its nodes and centre.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Jacobian {
    /// Index of the element.
    pub element: usize,
    /// Smallest determinant of dx/dxi \[m3\].
    pub determinant: f64,
    /// Smallest over largest determinant: 1 for a parallelepiped or a straight-sided tetrahedron, 0 or less for an
    /// element that is inverted somewhere.
    pub ratio: f64,
}

impl Jacobian {
    /// Whether the element is inverted or degenerate somewhere; true for NaN.
    fn is_inverted(&self) -> bool {
        self.determinant.is_nan() || self.determinant <= 0.0
    }
}

/// Ratio of Jacobians below which an element counts as poor; strains at its worst corner are then wrong.
pub const POOR: f64 = 0.1;

impl Mesh {
    /// Smallest Jacobian determinant of an element over its nodes and its centre.
    pub fn jacobian(&self, element: usize) -> Jacobian {
        let view = self.element(element);
        let mut low = f64::INFINITY;
        let mut high = f64::NEG_INFINITY;
        let places = view.kind.natural_nodes().iter().copied().chain([view.kind.centre()]);
        for xi in places {
            let j = self.gradient(view, xi).determinant();
            low = low.min(j);
            high = high.max(j);
        }
        Jacobian {
            element,
            determinant: low,
            ratio: if high > 0.0 { low / high } else { -1.0 },
        }
    }

    /// Number of inverted or degenerate elements.
    pub(crate) fn inverted(&self) -> usize {
        (0..self.element_count())
            .filter(|&element| self.jacobian(element).is_inverted())
            .count()
    }

    /// dx/dxi of an element.
    fn gradient(&self, view: ElementRef<'_>, xi: [f64; 3]) -> Matrix3<f64> {
        let (mut n, mut dn) = ([0.0; 27], [[0.0; 3]; 27]);
        view.kind.shape(xi, &mut n, &mut dn);
        view.nodes
            .iter()
            .zip(&dn)
            .map(|(&node, slope)| self.nodes[node].coords * Vector3::from(*slope).transpose())
            .sum()
    }

    /// Volume of one element \[m3\], from its quadrature rule.
    ///
    /// # Errors
    /// [`MeshError::GaussPoints`]; does not occur for the existing kinds.
    pub fn volume_of(&self, element: usize) -> Result<f64, MeshError> {
        let view = self.element(element);
        Ok(view
            .kind
            .rule()?
            .into_iter()
            .map(|(xi, weight)| weight * self.gradient(view, xi).determinant())
            .sum())
    }

    /// Volume of each part \[m3\].
    ///
    /// # Errors
    /// Same as [`Self::volume_of`].
    pub fn part_volumes(&self) -> Result<Vec<f64>, MeshError> {
        let mut volumes = vec![0.0; self.part_names.len()];
        for element in 0..self.element_count() {
            volumes[self.parts[element]] += self.volume_of(element)?;
        }
        Ok(volumes)
    }

    /// Examines every element and the skin.
    ///
    /// # Errors
    /// [`MeshError::NoElements`] if the mesh is empty.
    pub fn quality(&self) -> Result<Quality, MeshError> {
        let jacobians = (0..self.element_count()).map(|element| self.jacobian(element));
        let (mut worst, mut inverted, mut poor) = (None::<Jacobian>, 0, 0);
        for j in jacobians {
            inverted += usize::from(j.is_inverted());
            poor += usize::from(j.ratio.is_nan() || j.ratio < POOR);
            if worst.is_none_or(|w| j.ratio.is_nan() || j.ratio < w.ratio) {
                worst = Some(j);
            }
        }
        let worst = worst.ok_or(MeshError::NoElements { what: "the mesh" })?;
        let skin = Surface::of(self);
        let edges = || self.elements().flat_map(|view| self.edge_lengths(view));
        Ok(Quality {
            worst,
            inverted,
            poor,
            open_edges: skin.open_edges(),
            skin_volume: skin.volume(),
            volume: self.part_volumes()?.iter().sum(),
            skin_area: skin.area(),
            pieces: self.pieces(),
            coincident_nodes: self.coincident_nodes(),
            shortest_edge: edges().fold(f64::INFINITY, f64::min),
            longest_edge: edges().fold(0.0, f64::max),
        })
    }

    /// Lengths of the element's edges, corner to corner \[m\].
    fn edge_lengths(&self, view: ElementRef<'_>) -> impl Iterator<Item = f64> {
        view.kind
            .edges()
            .iter()
            .map(move |&[a, b]| (self.nodes[view.nodes[a]] - self.nodes[view.nodes[b]]).norm())
    }

    /// Longest edge of the elements of each part \[m\].
    pub fn longest_edges(&self) -> Vec<f64> {
        let mut longest = vec![0.0; self.part_names.len()];
        for view in self.elements() {
            let edge = self.edge_lengths(view).fold(0.0, f64::max);
            longest[view.part] = f64::max(longest[view.part], edge);
        }
        longest
    }

    /// Number of connected pieces, which share no nodes.
    pub fn pieces(&self) -> usize {
        let mut pieces: Vec<usize> = self.piece_of_nodes().into_iter().flatten().collect();
        pieces.sort_unstable();
        pieces.dedup();
        pieces.len()
    }

    /// For each node, the first node of its connected piece; none for a node without an element.
    pub fn piece_of_nodes(&self) -> Vec<Option<usize>> {
        let mut parent: Vec<usize> = (0..self.nodes.len()).collect();
        let mut used = vec![false; self.nodes.len()];
        for view in self.elements() {
            for &node in view.nodes {
                used[node] = true;
                let (a, b) = (root(&mut parent, view.nodes[0]), root(&mut parent, node));
                parent[a.max(b)] = a.min(b);
            }
        }
        (0..parent.len())
            .map(|node| used[node].then(|| root(&mut parent, node)))
            .collect()
    }

    /// Number of nodes that coincide with another node within 1e-6 of the size of the mesh. They form a crack unless a
    /// tie joins them.
    fn coincident_nodes(&self) -> usize {
        let (low, high) = self.bounds();
        let tolerance = 1e-6 * (high - low).norm();
        let mut order: Vec<usize> = (0..self.nodes.len()).collect();
        order.sort_by(|&a, &b| self.nodes[a].x.total_cmp(&self.nodes[b].x));
        let close = |a: &Point3<f64>, b: &Point3<f64>| (a - b).norm() <= tolerance;
        let mut found = 0;
        for (rank, &node) in order.iter().enumerate() {
            let p = &self.nodes[node];
            let twin = order[rank + 1..]
                .iter()
                .map(|&other| &self.nodes[other])
                .take_while(|q| q.x - p.x <= tolerance)
                .any(|q| close(p, q));
            found += usize::from(twin);
        }
        found
    }

    /// Checks a mesh for damage before it is used; `number` gives the element numbers of the file for messages.
    ///
    /// # Errors
    /// [`MeshError::Inverted`] for the worst element whose Jacobian is not positive at one of its nodes;
    /// [`MeshError::OpenSkin`] if elements overlap.
    pub fn validate(&self, number: impl Fn(usize) -> u64) -> Result<(), MeshError> {
        let mut inverted = 0;
        let mut worst = None::<Jacobian>;
        for element in 0..self.element_count() {
            let j = self.jacobian(element);
            if j.is_inverted() {
                inverted += 1;
                if worst.is_none_or(|w| j.determinant.is_nan() || j.determinant < w.determinant) {
                    worst = Some(j);
                }
            }
        }
        if let Some(j) = worst {
            return Err(MeshError::Inverted {
                element: number(j.element),
                determinant: j.determinant,
                inverted,
                of: self.element_count(),
            });
        }
        match Surface::of(self).open_edges() {
            0 => Ok(()),
            edges => Err(MeshError::OpenSkin { edges }),
        }
    }
}

/// The first index of the set that contains an index.
pub(crate) fn root(parent: &mut [usize], mut node: usize) -> usize {
    while parent[node] != node {
        parent[node] = parent[parent[node]];
        node = parent[node];
    }
    node
}
