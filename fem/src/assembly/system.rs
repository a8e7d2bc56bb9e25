//! Assembles K and M from a mesh.

use std::collections::BTreeMap;
use std::sync::Arc;

use faer::{ColRef, MatRef};
use nailnoise_meshes::Mesh;
use nalgebra::{DMatrix, Vector3};
use nalgebra_sparse::CscMatrix;
use nalgebra_sparse::pattern::SparsityPattern;
use rayon::prelude::*;

use super::layout::{Cliques, Layout};
use super::mirror::Mirror;
use crate::factor::{Symbolic, order};
use crate::reduction::Reduction;
use crate::{Attachments, Constraints, FemError, Material};

/// The free degrees of freedom of a model, numbered node by node in mesh order or in an elimination order
/// ([`assemble_in_order`]).
///
/// The degrees of freedom u of the mesh are u = T q, with q the unknowns of the equations. A free degree of freedom is
/// itself an unknown, a fixed one is zero, and one of a tied node is a combination of unknowns.
#[derive(Clone, Debug, PartialEq)]
pub struct Equations {
    /// Degrees of freedom of the mesh.
    dofs: usize,
    /// Equation of degree of freedom 3 node + axis, or none if it is fixed or tied; those of rigid masses follow.
    equation_of: Vec<Option<usize>>,
    /// Degree of freedom of each equation.
    dof_of: Vec<usize>,
    /// For each tied degree of freedom, the equations and weights that determine it.
    tied: BTreeMap<usize, Vec<(usize, f64)>>,
    /// The degrees of freedom that are rotations; a translation of the body leaves them at zero.
    rotations: Vec<usize>,
    /// Planes that map the positions of the unknowns onto each other.
    mirrors: Vec<Mirror>,
}

/// Stiffness and mass of a body without its fixed degrees of freedom.
///
/// Both matrices are symmetric; only their lower triangles are stored, by columns with ascending rows.
#[derive(Clone, Debug)]
pub struct System {
    /// The numbering.
    pub equations: Equations,
    /// K \[N/m\].
    pub stiffness: CscMatrix<f64>,
    /// M \[kg\].
    pub mass: CscMatrix<f64>,
    /// The pattern of factors, if the equations are in an elimination order.
    pub(crate) symbolic: Option<Arc<Symbolic>>,
}

impl Equations {
    /// Number of equations.
    pub fn len(&self) -> usize {
        self.dof_of.len()
    }

    /// Whether there are no equations.
    pub fn is_empty(&self) -> bool {
        self.dof_of.is_empty()
    }

    /// Degrees of freedom of the mesh, 3 x nodes.
    pub fn dofs(&self) -> usize {
        self.dofs
    }

    /// The node of an equation; nodes of rigid masses are numbered after those of the mesh.
    pub(crate) fn node(&self, equation: usize) -> usize {
        self.dof_of[equation] / 3
    }

    /// Number of nodes, including those of rigid masses.
    pub(crate) fn nodes(&self) -> usize {
        self.equation_of.len() / 3
    }

    /// Planes that map the positions of the unknowns onto each other.
    pub(crate) fn mirrors(&self) -> &[Mirror] {
        &self.mirrors
    }

    /// The equation of a displacement component, or none if it is fixed or tied.
    pub fn equation(&self, node: usize, axis: usize) -> Option<usize> {
        self.equation_of[3 * node + axis]
    }

    /// T q: expands columns over the equations to the degrees of freedom of the mesh (3 x nodes rows); fixed ones are
    /// zero.
    pub fn expand(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let columns = MatRef::from_column_major_slice(columns.as_slice(), columns.nrows(), columns.ncols());
        self.expanded(columns.ncols(), |c| columns.col(c))
    }

    /// Same as `expand` for the columns returned by `column`; threads share them.
    pub(crate) fn expanded<'c>(
        &self,
        columns: usize,
        column: impl Fn(usize) -> ColRef<'c, f64> + Sync,
    ) -> DMatrix<f64> {
        let mut all = vec![0.0; self.dofs * columns];
        let all_columns = all.par_chunks_mut(self.dofs.max(1)).enumerate();
        all_columns.for_each(|(c, to)| {
            let from = column(c);
            for (to, equation) in to.iter_mut().zip(&self.equation_of) {
                *to = equation.map_or(0.0, |e| from[e]);
            }
            for (&dof, terms) in &self.tied {
                to[dof] = terms.iter().map(|&(e, w)| w * from[e]).sum();
            }
        });
        DMatrix::from_vec(self.dofs, columns, all)
    }

    /// T^T f: converts forces on the degrees of freedom of the mesh to forces on the equations. Forces on fixed degrees
    /// of freedom are dropped; those on tied ones are transferred to their masters.
    ///
    /// # Errors
    /// [`FemError::LoadRows`] unless there are three rows per node.
    pub fn restrict(&self, columns: &DMatrix<f64>) -> Result<DMatrix<f64>, FemError> {
        let mut all = self.select(columns)?;
        for (&dof, terms) in &self.tied {
            for c in 0..columns.ncols() {
                terms.iter().for_each(|&(e, w)| all[(e, c)] += w * columns[(dof, c)]);
            }
        }
        Ok(all)
    }

    /// Extracts the unknowns from columns over the degrees of freedom of the mesh. Expanding them restores the columns
    /// if these satisfy constraints and ties. The unknowns of rigid masses are not in the mesh and are set to zero.
    ///
    /// # Errors
    /// [`FemError::LoadRows`] unless there are three rows per node.
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

    /// The unknowns if every free degree of freedom, including rigid masses, moves by `direction`.
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

/// Assembles K and M of `mesh` with its attachments.
///
/// # Errors
/// Those of [`assemble`]. [`FemError::Mesh`] if a group is unknown or a slave node is too far from its master.
/// [`FemError::TiedTwice`], [`FemError::TieCycle`], [`FemError::HeldAndTied`], [`FemError::Patch`],
/// [`FemError::Inertia`], [`FemError::Spring`] or [`FemError::NotPositive`].
pub fn assemble_with(
    mesh: &Mesh,
    materials: &[Material],
    constraints: &Constraints,
    attachments: &Attachments,
) -> Result<System, FemError> {
    let nodes = Nodes::new(mesh, constraints, attachments)?;
    nodes.assemble(mesh, materials, None)
}

/// Same as [`assemble_with`], with the nodes in the elimination order that [`elimination_order`] returned for this
/// mesh, these constraints and the same kinds of attachments on the same groups. [`crate::modes`] then need not compute
/// an order or permute K and M.
///
/// # Errors
/// Those of [`assemble_with`]; [`FemError::Order`] if the order is for different nodes.
pub fn assemble_in_order(
    mesh: &Mesh,
    materials: &[Material],
    constraints: &Constraints,
    attachments: &Attachments,
    order: &[u32],
) -> Result<System, FemError> {
    let nodes = Nodes::new(mesh, constraints, attachments)?;
    nodes.assemble(mesh, materials, Some(order))
}

/// The nodes with unknowns in an elimination order of their graph; none for a body that symmetry planes may divide,
/// because its sectors have separate orders. The order depends neither on materials nor on the values of masses and
/// stiffnesses.
///
/// # Errors
/// Those of [`assemble_with`], except those concerning materials and elements.
pub fn elimination_order(
    mesh: &Mesh,
    constraints: &Constraints,
    attachments: &Attachments,
) -> Result<Option<Vec<u32>>, FemError> {
    let nodes = Nodes::new(mesh, constraints, attachments)?;
    if !nodes.mirrors(mesh).is_empty() {
        return Ok(None);
    }
    let index = nodes.index(&nodes.active);
    let order = order::elimination_order(&nodes.cliques.graph(&index, nodes.active.len()))?;
    let dofs = 3 * nodes.reduction.nodes;
    let node = |place: usize| u32::try_from(nodes.active[place]).map_err(|_| FemError::TooLarge { dofs });
    order.into_iter().map(node).collect::<Result<_, _>>().map(Some)
}

/// The nodes of a model and their connections.
struct Nodes {
    reduction: Reduction,
    /// Free axes of every node.
    free: Vec<[bool; 3]>,
    cliques: Cliques,
    /// Those with unknowns, ascending.
    active: Vec<usize>,
}

impl Nodes {
    fn new(mesh: &Mesh, constraints: &Constraints, attachments: &Attachments) -> Result<Self, FemError> {
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
        // Nodes without free axes, unused nodes and dependent nodes do not appear in the graph.
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
        Ok(Self {
            reduction,
            free,
            cliques,
            active,
        })
    }

    /// The position of every node in an order of those with unknowns.
    fn index(&self, order: &[usize]) -> Vec<Option<usize>> {
        let mut index = vec![None; self.reduction.nodes];
        order.iter().enumerate().for_each(|(k, &node)| index[node] = Some(k));
        index
    }

    /// Symmetry planes that may divide the body, with equations numbered as in the mesh.
    fn mirrors(&self, mesh: &Mesh) -> Vec<Mirror> {
        let mut equation_of = vec![None; 3 * self.reduction.nodes];
        let free = self.active.iter().flat_map(|&node| {
            let axes = (0..3).filter(move |&axis| self.free[node][axis]);
            axes.map(move |axis| 3 * node + axis)
        });
        let dof_of: Vec<usize> = free.collect();
        dof_of
            .iter()
            .enumerate()
            .for_each(|(e, &dof)| equation_of[dof] = Some(e));
        Mirror::candidates(mesh, &equation_of, &dof_of)
    }

    /// The nodes with unknowns in an elimination order.
    fn ordered(&self, order: &[u32]) -> Result<Vec<usize>, FemError> {
        let order: Vec<usize> = order.iter().map(|&node| node as usize).collect();
        let mut ascending = order.clone();
        ascending.sort_unstable();
        if ascending != self.active {
            return Err(FemError::Order {
                reason: "the order of elimination is that of other nodes".to_owned(),
            });
        }
        Ok(order)
    }

    fn assemble(self, mesh: &Mesh, materials: &[Material], order: Option<&[u32]>) -> Result<System, FemError> {
        if materials.len() != mesh.part_names.len() {
            return Err(FemError::Materials {
                parts: mesh.part_names.len(),
                materials: materials.len(),
            });
        }
        let active = order.map_or_else(|| Ok(self.active.clone()), |order| self.ordered(order))?;
        let index = self.index(&active);
        let Self {
            reduction,
            free,
            cliques,
            ..
        } = self;
        let layout = Layout::new(&cliques.graph(&index, active.len()), &active, &free, &reduction)?;
        drop(cliques);
        let (values, symbolic) = rayon::join(
            || layout.scatter(mesh, materials, &index, &reduction),
            || order.map(|_| Symbolic::of_pattern(&layout.stiffness)).transpose(),
        );
        let (values, symbolic) = (values?, symbolic?);
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
        let mirrors = match order {
            Some(_) => Vec::new(),
            None => Mirror::candidates(mesh, &equation_of, &layout.dof_of),
        };
        Ok(System {
            equations: Equations {
                dofs: 3 * mesh.nodes.len(),
                equation_of,
                dof_of: layout.dof_of,
                tied,
                rotations: reduction.rotations.iter().flat_map(|&r| 3 * r..3 * r + 3).collect(),
                mirrors,
            },
            stiffness: matrix(layout.stiffness, values.stiffness)?,
            mass: matrix(layout.mass, values.mass)?,
            symbolic: symbolic.map(Arc::new),
        })
    }
}

/// The symmetric matrix whose lower triangle has these values.
fn matrix(pattern: SparsityPattern, values: Vec<f64>) -> Result<CscMatrix<f64>, FemError> {
    CscMatrix::try_from_pattern_and_values(pattern, values).map_err(|e| FemError::Order { reason: e.to_string() })
}
