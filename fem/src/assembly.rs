//! From a mesh to K and M.

use std::collections::BTreeMap;

use nailnoise_meshes::Mesh;
use nalgebra::{DMatrix, Vector3};
use nalgebra_sparse::CscMatrix;

use crate::layout::{Cliques, Layout};
use crate::reduction::Reduction;
use crate::symmetry::Mirror;
use crate::{Attachments, Constraints, FemError, Material};

/// The free degrees of freedom of a model, numbered node by node as the mesh has them.
///
/// The degrees of freedom u of the mesh follow from the unknowns q of the equations as u = T q: a free one is an unknown
/// itself, a held one is zero, and one of a tied node is a combination of unknowns.
#[derive(Clone, Debug, PartialEq)]
pub struct Equations {
    /// Degrees of freedom of the mesh.
    dofs: usize,
    /// Equation of degree of freedom 3 node + axis, or none where it is held or tied; those of rigid masses follow.
    equation_of: Vec<Option<usize>>,
    /// Degree of freedom of each equation.
    dof_of: Vec<usize>,
    /// For each tied degree of freedom the equations and weights it follows from.
    tied: BTreeMap<usize, Vec<(usize, f64)>>,
    /// The degrees of freedom that are rotations; a translation of the whole leaves them at rest.
    rotations: Vec<usize>,
    /// Planes that map the places of the unknowns onto each other.
    mirrors: Vec<Mirror>,
}

/// Stiffness and mass of a body, held degrees of freedom removed.
///
/// Both matrices are symmetric; only their lower triangles are stored, by columns, rows ascending.
#[derive(Clone, Debug)]
pub struct System {
    /// The numbering.
    pub equations: Equations,
    /// K \[N/m\].
    pub stiffness: CscMatrix<f64>,
    /// M \[kg\].
    pub mass: CscMatrix<f64>,
}

impl Equations {
    /// Number of equations.
    pub fn len(&self) -> usize {
        self.dof_of.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.dof_of.is_empty()
    }

    /// Degrees of freedom of the mesh, 3 x nodes.
    pub fn dofs(&self) -> usize {
        self.dofs
    }

    /// The node of an equation; those of rigid masses follow those of the mesh.
    pub(crate) fn node(&self, equation: usize) -> usize {
        self.dof_of[equation] / 3
    }

    /// Number of nodes, with those of rigid masses.
    pub(crate) fn nodes(&self) -> usize {
        self.equation_of.len() / 3
    }

    /// Planes that map the places of the unknowns onto each other.
    pub(crate) fn mirrors(&self) -> &[Mirror] {
        &self.mirrors
    }

    /// The equation of a displacement component, or none where it is held or tied.
    pub fn equation(&self, node: usize, axis: usize) -> Option<usize> {
        self.equation_of[3 * node + axis]
    }

    /// T q: columns over the degrees of freedom of the mesh (3 x nodes rows) from columns over the equations; held ones
    /// are zero.
    pub fn expand(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let mut all = DMatrix::from_fn(self.dofs, columns.ncols(), |dof, c| {
            self.equation_of[dof].map_or(0.0, |e| columns[(e, c)])
        });
        for (&dof, terms) in &self.tied {
            for c in 0..columns.ncols() {
                all[(dof, c)] = terms.iter().map(|&(e, w)| w * columns[(e, c)]).sum();
            }
        }
        all
    }

    /// T^T f: forces on the equations from forces on the degrees of freedom of the mesh; those on held ones are dropped,
    /// those on tied ones pass to what they are tied to.
    ///
    /// # Errors
    /// [`FemError::LoadRows`] unless there are three rows a node.
    pub fn restrict(&self, columns: &DMatrix<f64>) -> Result<DMatrix<f64>, FemError> {
        let mut all = self.select(columns)?;
        for (&dof, terms) in &self.tied {
            for c in 0..columns.ncols() {
                terms.iter().for_each(|&(e, w)| all[(e, c)] += w * columns[(dof, c)]);
            }
        }
        Ok(all)
    }

    /// The values of the unknowns in columns over the degrees of freedom of the mesh: expanding them gives the columns
    /// back where these respect constraints and ties. The unknowns of rigid masses are none of the mesh's and left zero.
    ///
    /// # Errors
    /// [`FemError::LoadRows`] unless there are three rows a node.
    pub fn select(&self, columns: &DMatrix<f64>) -> Result<DMatrix<f64>, FemError> {
        if columns.nrows() != self.dofs {
            return Err(FemError::LoadRows {
                found: columns.nrows(),
                expected: self.dofs,
            });
        }
        Ok(DMatrix::from_fn(self.len(), columns.ncols(), |e, c| {
            let dof = self.dof_of[e];
            if dof < self.dofs { columns[(dof, c)] } else { 0.0 }
        }))
    }

    /// The unknowns when every free degree of freedom moves by `direction`, rigid masses included.
    pub fn translation(&self, direction: Vector3<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(self.len(), 1, |e, _| {
            let dof = self.dof_of[e];
            if self.rotations.binary_search(&dof).is_ok() {
                0.0
            } else {
                direction[dof % 3]
            }
        })
    }
}

/// Assembles K and M of `mesh` with one material for each of its parts.
///
/// # Errors
/// [`FemError::Materials`], [`FemError::Node`], [`FemError::NothingFree`], [`FemError::Inverted`] or
/// [`FemError::Order`].
pub fn assemble(mesh: &Mesh, materials: &[Material], constraints: &Constraints) -> Result<System, FemError> {
    assemble_with(mesh, materials, constraints, &Attachments::default())
}

/// Assembles K and M of `mesh` with what is attached to it.
///
/// # Errors
/// Those of [`assemble`]; [`FemError::Mesh`] when a group is unknown or a slave node is too far from its master;
/// [`FemError::TiedTwice`], [`FemError::TieCycle`], [`FemError::HeldAndTied`], [`FemError::Patch`],
/// [`FemError::Inertia`], [`FemError::Spring`] or [`FemError::NotPositive`].
pub fn assemble_with(
    mesh: &Mesh,
    materials: &[Material],
    constraints: &Constraints,
    attachments: &Attachments,
) -> Result<System, FemError> {
    if materials.len() != mesh.part_names.len() {
        return Err(FemError::Materials {
            parts: mesh.part_names.len(),
            materials: materials.len(),
        });
    }
    let reduction = Reduction::new(mesh, attachments, constraints)?;
    let mut free = vec![[true; 3]; reduction.nodes];
    for (node, axis) in constraints.iter() {
        if node >= mesh.nodes.len() {
            let nodes = mesh.nodes.len();
            return Err(FemError::Node { node, nodes });
        }
        free[node][axis.min(2)] = false;
    }
    let cliques = Cliques::new(mesh, &reduction);
    // Nodes with nothing free, those of no element and the dependent ones have no place in the graph.
    let mut used = vec![false; reduction.nodes];
    cliques.nodes().for_each(|node| used[node] = true);
    let active: Vec<usize> = (0..reduction.nodes)
        .filter(|&i| used[i] && free[i].contains(&true))
        .collect();
    if active.is_empty() {
        return Err(FemError::NothingFree {
            dofs: 3 * mesh.nodes.len(),
        });
    }
    let mut index = vec![None; reduction.nodes];
    active.iter().enumerate().for_each(|(k, &node)| index[node] = Some(k));
    let layout = Layout::new(&cliques.graph(&index, active.len()), &active, &free, &reduction);
    let (stiffness, mass) = layout.scatter(mesh, materials, &index, &reduction)?;
    let mut equation_of = vec![None; 3 * reduction.nodes];
    layout
        .dof_of
        .iter()
        .enumerate()
        .for_each(|(e, &dof)| equation_of[dof] = Some(e));
    let mut tied = BTreeMap::new();
    for (node, terms) in reduction.dependent() {
        for axis in 0..3 {
            let row = terms
                .iter()
                .flat_map(|&(p, w)| (0..3).map(move |k| (3 * p + k, w[(axis, k)])));
            let row = row.filter_map(|(dof, w)| equation_of[dof].filter(|_| w != 0.0).map(|e| (e, w)));
            tied.insert(3 * node + axis, row.collect());
        }
    }
    let mirrors = Mirror::candidates(mesh, &equation_of, &layout.dof_of);
    Ok(System {
        equations: Equations {
            dofs: 3 * mesh.nodes.len(),
            equation_of,
            dof_of: layout.dof_of,
            tied,
            rotations: reduction.rotations.iter().flat_map(|&r| 3 * r..3 * r + 3).collect(),
            mirrors,
        },
        stiffness,
        mass,
    })
}
