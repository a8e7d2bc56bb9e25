//! Dependent nodes: how attachments eliminate displacements and add mass and stiffness.
//!
//! Every node's displacement is u_a = sum of W_ap u_p over independent nodes p. With T the matrix of all W, the reduced
//! matrices are T^T K T and T^T M T, formed element by element. A rigidly attached mass adds two nodes: the translation
//! u_0 of its centre, and its rotation theta times a length l, with u_a = u_0 + theta x r_a.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use nailnoise_meshes::{Location, Mesh, MeshError};
use nalgebra::{Matrix3, Point3, Vector3};
use rayon::prelude::*;

use crate::{Attachments, Constraints, Coupling, FemError, LumpedMass, Place};

/// One term of a node's expansion: the independent node and its W.
pub(crate) type Term = (usize, Matrix3<f64>);

/// Largest number of substitution rounds for a chain of dependencies.
const LONGEST_CHAIN: usize = 8;

/// Smallest ratio of a group's second moments of area for which it counts as an area rather than a line.
const FLAT: f64 = 1e-9;

/// Matrices that attachments add between nodes.
#[derive(Default)]
pub(crate) struct Added {
    /// The independent nodes that they couple.
    pub(crate) nodes: Vec<usize>,
    /// Entries (row, column, K, M) between local nodes, in both triangles.
    pub(crate) blocks: Vec<(usize, usize, Matrix3<f64>, Matrix3<f64>)>,
}

/// The dependencies of a model's nodes, and the matrices that its attachments add.
#[derive(Default)]
pub(crate) struct Reduction {
    /// Number of nodes: those of the mesh, followed by those of rigid bodies.
    pub(crate) nodes: usize,
    expansions: BTreeMap<usize, Vec<Term>>,
    pub(crate) added: Vec<Added>,
    /// Nodes that represent rotations; their mass couples all axes of all their neighbours.
    pub(crate) rotations: Vec<usize>,
}

impl Attachments {
    /// Each dependent node of a mesh with the nodes that it depends on. Nothing is assembled, so attachments can be
    /// checked before a body is solved. Each slave node must reach its master, and no node may be both fixed and tied.
    ///
    /// # Errors
    /// Those errors of [`crate::assemble_with`] that concern attachments.
    pub fn followers(&self, mesh: &Mesh, constraints: &Constraints) -> Result<Vec<(usize, Vec<usize>)>, FemError> {
        let reduction = Reduction::new(mesh, self, constraints)?;
        let of_mesh = |&node: &usize| node < mesh.nodes.len();
        let dependent = reduction.dependent().filter(|(node, _)| of_mesh(node));
        Ok(dependent
            .map(|(node, terms)| {
                (
                    node,
                    terms.iter().map(|(followed, _)| *followed).filter(of_mesh).collect(),
                )
            })
            .collect())
    }
}

impl Reduction {
    /// # Errors
    /// See [`crate::assemble_with`].
    pub(crate) fn new(mesh: &Mesh, attachments: &Attachments, constraints: &Constraints) -> Result<Self, FemError> {
        let mut reduction = Self {
            nodes: mesh.nodes.len(),
            ..Self::default()
        };
        for tie in &attachments.ties {
            let nodes = mesh.group_nodes(&tie.slave)?;
            let locate = |&node: &usize| mesh.locate_near(&tie.master, mesh.nodes[node], tie.tolerance);
            let places: Vec<Result<Location, MeshError>> = nodes.par_iter().map(locate).collect();
            for (node, at) in nodes.into_iter().zip(places) {
                let at = at?;
                let terms = at.nodes.into_iter().zip(at.weights);
                let terms = terms.map(|(p, w)| (p, Matrix3::from_diagonal_element(w))).collect();
                reduction.depend(node, terms, &tie.slave)?;
            }
        }
        for mass in &attachments.masses {
            let patch = Patch::new(mesh, &mass.group)?;
            check(mass)?;
            match mass.coupling {
                Coupling::Rigid => reduction.rigid(mesh, mass, &patch)?,
                Coupling::Distributed => reduction.added.push(distributed(mesh, mass, &patch)),
            }
        }
        for spring in &attachments.springs {
            let total = spring.stiffness;
            let scale = total.amax();
            let asymmetry = (total - total.transpose()).amax();
            let lowest = ((total + total.transpose()) / 2.0).symmetric_eigenvalues().min();
            if !(asymmetry <= 1e-9 * scale && lowest >= -1e-9 * scale) {
                return Err(FemError::Spring { asymmetry, lowest });
            }
            match &spring.place {
                Place::Point(at) => reduction.added.push(spring_at(&at.nodes, &at.weights, total)),
                Place::Group(name) => {
                    let patch = Patch::new(mesh, name)?;
                    let points = patch.points.iter();
                    let springs = points.map(|p| spring_at(&p.nodes, &p.weights, total * (p.area / patch.area)));
                    reduction.added.extend(springs);
                }
            }
        }
        reduction.resolve()?;
        if let Some((node, axis)) = constraints
            .iter()
            .find(|(node, _)| reduction.expansions.contains_key(node))
        {
            return Err(FemError::HeldAndTied { node, axis });
        }
        reduction.expand_added();
        Ok(reduction)
    }

    /// The expansion of a dependent node, or none if the node is independent.
    pub(crate) fn expansion(&self, node: usize) -> Option<&[Term]> {
        self.expansions.get(&node).map(Vec::as_slice)
    }

    /// All dependent nodes, ascending.
    pub(crate) fn dependent(&self) -> impl Iterator<Item = (usize, &[Term])> {
        self.expansions.iter().map(|(&node, terms)| (node, terms.as_slice()))
    }

    fn depend(&mut self, node: usize, terms: Vec<Term>, group: &str) -> Result<(), FemError> {
        match self.expansions.insert(node, terms) {
            None => Ok(()),
            Some(_) => Err(FemError::TiedTwice {
                node,
                group: group.to_owned(),
            }),
        }
    }

    fn rigid(&mut self, mesh: &Mesh, mass: &LumpedMass, patch: &Patch) -> Result<(), FemError> {
        let (translation, rotation) = (self.nodes, self.nodes + 1);
        self.nodes += 2;
        self.rotations.push(rotation);
        // The rotation times a characteristic length of the group is a displacement, so that the matrices are uniformly
        // scaled.
        let length = (patch.moment.trace() / 2.0 / patch.area).sqrt();
        for node in mesh.group_nodes(&mass.group)? {
            let r = mesh.nodes[node] - mass.centre;
            let terms = vec![
                (translation, Matrix3::identity()),
                (rotation, -r.cross_matrix() / length),
            ];
            self.depend(node, terms, &mass.group)?;
        }
        let zero = Matrix3::zeros();
        self.added.push(Added {
            nodes: vec![translation, rotation],
            blocks: vec![
                (0, 0, zero, Matrix3::from_diagonal_element(mass.mass)),
                (1, 1, zero, mass.inertia / (length * length)),
            ],
        });
        Ok(())
    }

    /// Substitutes expansions until all refer to independent nodes only.
    fn resolve(&mut self) -> Result<(), FemError> {
        for _ in 0..LONGEST_CHAIN {
            let mut changed = None;
            let substituted: BTreeMap<usize, Vec<Term>> = self
                .expansions
                .iter()
                .map(|(&node, terms)| {
                    let (terms, any) = self.substitute(terms);
                    if any {
                        changed = Some(node);
                    }
                    (node, terms)
                })
                .collect();
            self.expansions = substituted;
            if changed.is_none() {
                return Ok(());
            }
        }
        let node = self.expansions.keys().next().copied().unwrap_or(0);
        Err(FemError::TieCycle { node })
    }

    fn substitute(&self, terms: &[Term]) -> (Vec<Term>, bool) {
        let mut result: Vec<Term> = Vec::with_capacity(terms.len());
        let mut any = false;
        let mut add = |p: usize, w: Matrix3<f64>| match result.iter_mut().find(|t| t.0 == p) {
            Some(term) => term.1 += w,
            None => result.push((p, w)),
        };
        for &(p, w) in terms {
            match self.expansions.get(&p) {
                None => add(p, w),
                Some(inner) => {
                    any = true;
                    inner.iter().for_each(|&(q, v)| add(q, w * v));
                }
            }
        }
        (result, any)
    }

    /// Transfers the matrices of attachments from dependent nodes to the independent ones.
    fn expand_added(&mut self) {
        let added = std::mem::take(&mut self.added);
        self.added = added.into_iter().map(|a| self.expand_one(a)).collect();
    }

    fn expand_one(&self, added: Added) -> Added {
        if added.nodes.iter().all(|&n| self.expansion(n).is_none()) {
            return added;
        }
        let mut nodes: Vec<usize> = Vec::new();
        let terms: Vec<Vec<Term>> = added
            .nodes
            .iter()
            .map(|&node| {
                let own = [(node, Matrix3::identity())];
                let terms = self.expansion(node).unwrap_or(&own);
                let local = terms.iter().map(|&(p, w)| {
                    let place = nodes.iter().position(|&n| n == p).unwrap_or_else(|| {
                        nodes.push(p);
                        nodes.len() - 1
                    });
                    (place, w)
                });
                local.collect()
            })
            .collect();
        let mut blocks = Vec::new();
        for (a, b, k, m) in added.blocks {
            for &(p, w) in &terms[a] {
                for &(q, v) in &terms[b] {
                    blocks.push((p, q, w.transpose() * k * v, w.transpose() * m * v));
                }
            }
        }
        Added { nodes, blocks }
    }
}

/// A face group with its area, centroid and second moments.
struct Patch {
    /// Quadrature points.
    points: Vec<PatchPoint>,
    /// Integral of N_a over the group for each of its nodes \[m^2\].
    weights: BTreeMap<usize, f64>,
    area: f64,
    centroid: Point3<f64>,
    /// Integral of |r|^2 I - r r^T about the centroid \[m^4\].
    moment: Matrix3<f64>,
}

struct PatchPoint {
    nodes: Vec<usize>,
    weights: Vec<f64>,
    area: f64,
}

impl Patch {
    fn new(mesh: &Mesh, group: &str) -> Result<Self, FemError> {
        let mut patch = Self {
            points: Vec::new(),
            weights: BTreeMap::new(),
            area: 0.0,
            centroid: Point3::origin(),
            moment: Matrix3::zeros(),
        };
        let mut rules = BTreeMap::new();
        for &face in &mesh.group(group)?.faces {
            let (kind, nodes) = (mesh.face_kind(face), mesh.face_nodes(face));
            let rule = match rules.entry(kind) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(new) => new.insert(kind.rule(3)?),
            };
            for &(xi, weight) in rule.iter() {
                let (mut n, mut dn) = ([0.0; 9], [[0.0; 2]; 9]);
                kind.shape(xi, &mut n, &mut dn);
                let mut t = [Vector3::zeros(); 2];
                for (a, &node) in nodes.iter().enumerate() {
                    t[0] += dn[a][0] * mesh.nodes[node].coords;
                    t[1] += dn[a][1] * mesh.nodes[node].coords;
                }
                let area = weight * t[0].cross(&t[1]).norm();
                patch.area += area;
                for (&node, n) in nodes.iter().zip(n) {
                    *patch.weights.entry(node).or_insert(0.0) += area * n;
                }
                patch.points.push(PatchPoint {
                    nodes: nodes.to_vec(),
                    weights: n[..kind.nodes()].to_vec(),
                    area,
                });
            }
        }
        let sum: Vector3<f64> = patch.weights.iter().map(|(&i, w)| mesh.nodes[i].coords * *w).sum();
        patch.centroid = Point3::from(sum / patch.area);
        for (&node, w) in &patch.weights {
            let r = mesh.nodes[node] - patch.centroid;
            patch.moment += *w * (Matrix3::from_diagonal_element(r.norm_squared()) - r * r.transpose());
        }
        let smallest = patch.moment.symmetric_eigenvalues().min();
        // The moments of an empty group are NaN.
        if smallest.is_nan() || smallest <= FLAT * patch.moment.trace() {
            return Err(FemError::Patch {
                group: group.to_owned(),
                area: patch.area,
            });
        }
        Ok(patch)
    }
}

fn check(mass: &LumpedMass) -> Result<(), FemError> {
    if !(mass.mass.is_finite() && mass.mass > 0.0) {
        return Err(FemError::NotPositive {
            what: "a lumped mass [kg]",
            value: mass.mass,
        });
    }
    // Each principal moment of inertia of a body is at most the sum of the other two.
    let j = mass.inertia.symmetric_eigenvalues();
    let excess = 2.0 * j.max() - j.sum();
    let asymmetry = (mass.inertia - mass.inertia.transpose()).amax();
    let slack = 1e-9 * j.amax();
    if !(j.min() >= -slack && excess <= slack && asymmetry <= slack) {
        return Err(FemError::Inertia {
            group: mass.group.clone(),
            moments: [j[0], j[1], j[2]],
        });
    }
    Ok(())
}

/// The mass moves with the mean of the group: u = 1/A integral of u dA, theta = J^-1 integral of r x u dA with J the
/// second moments of area, u_c = u + theta x d. A rigid motion equals its own mean.
fn distributed(mesh: &Mesh, mass: &LumpedMass, patch: &Patch) -> Added {
    let inverse = patch.moment.try_inverse().unwrap_or_else(Matrix3::zeros);
    let d = mass.centre - patch.centroid;
    let nodes: Vec<usize> = patch.weights.keys().copied().collect();
    let maps: Vec<(Matrix3<f64>, Matrix3<f64>)> = patch
        .weights
        .iter()
        .map(|(&node, &w)| {
            let r = mesh.nodes[node] - patch.centroid;
            let rotation = inverse * r.cross_matrix() * w;
            let translation = Matrix3::from_diagonal_element(w / patch.area) - d.cross_matrix() * rotation;
            (translation, rotation)
        })
        .collect();
    let mut blocks = Vec::with_capacity(nodes.len() * nodes.len());
    for (a, (g, h)) in maps.iter().enumerate() {
        for (b, (g_b, h_b)) in maps.iter().enumerate() {
            let m = g.transpose() * g_b * mass.mass + h.transpose() * mass.inertia * h_b;
            blocks.push((a, b, Matrix3::zeros(), m));
        }
    }
    Added { nodes, blocks }
}

fn spring_at(nodes: &[usize], weights: &[f64], k: Matrix3<f64>) -> Added {
    let mut blocks = Vec::with_capacity(nodes.len() * nodes.len());
    for (a, w) in weights.iter().enumerate() {
        for (b, v) in weights.iter().enumerate() {
            blocks.push((a, b, k * (w * v), Matrix3::zeros()));
        }
    }
    Added {
        nodes: nodes.to_vec(),
        blocks,
    }
}
