//! From a mesh to K and M.

use nailnoise_meshes::Mesh;
use nalgebra::DMatrix;
use nalgebra_sparse::CscMatrix;
use rayon::prelude::*;

use crate::element::{ElementMaterial, ElementMatrices, Rule, integrate};
use crate::order::{Graph, elimination_order};
use crate::{Constraints, FemError, Material};

/// The free degrees of freedom of a mesh, numbered in the order of elimination.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Equations {
    /// Equation of degree of freedom 3 node + axis, or none where it is held.
    equation_of: Vec<Option<usize>>,
    /// Degree of freedom of each equation.
    dof_of: Vec<usize>,
}

/// Stiffness and mass of a body in the order of elimination, held degrees of freedom removed.
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
        self.equation_of.len()
    }

    /// The equation of a displacement component, or none where it is held.
    pub fn equation(&self, node: usize, axis: usize) -> Option<usize> {
        self.equation_of[3 * node + axis]
    }

    /// Columns over the degrees of freedom of the mesh (3 x nodes rows) from columns over the equations; held ones are
    /// zero.
    pub fn expand(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(self.dofs(), columns.ncols(), |dof, c| {
            self.equation_of[dof].map_or(0.0, |e| columns[(e, c)])
        })
    }

    /// Columns over the equations from columns over the degrees of freedom of the mesh; held ones are dropped.
    ///
    /// # Errors
    /// [`FemError::LoadRows`] unless there are three rows a node.
    pub fn restrict(&self, columns: &DMatrix<f64>) -> Result<DMatrix<f64>, FemError> {
        if columns.nrows() != self.dofs() {
            return Err(FemError::LoadRows {
                found: columns.nrows(),
                expected: self.dofs(),
            });
        }
        Ok(DMatrix::from_fn(self.len(), columns.ncols(), |e, c| {
            columns[(self.dof_of[e], c)]
        }))
    }
}

/// Assembles K and M of `mesh` with one material for each of its parts.
///
/// # Errors
/// [`FemError::Materials`], [`FemError::Node`], [`FemError::NothingFree`], [`FemError::Inverted`] or
/// [`FemError::Order`].
pub fn assemble(mesh: &Mesh, materials: &[Material], constraints: &Constraints) -> Result<System, FemError> {
    if materials.len() != mesh.part_names.len() {
        return Err(FemError::Materials {
            parts: mesh.part_names.len(),
            materials: materials.len(),
        });
    }
    let mut free = vec![[true; 3]; mesh.nodes.len()];
    for (node, axis) in constraints.iter() {
        let held = free.get_mut(node).ok_or(FemError::Node {
            node,
            nodes: mesh.nodes.len(),
        })?;
        held[axis.min(2)] = false;
    }
    // Nodes with nothing free, and those of no element, have no place in the graph.
    let mut used = vec![false; mesh.nodes.len()];
    mesh.connectivity.iter().for_each(|&node| used[node] = true);
    let active: Vec<usize> = (0..mesh.nodes.len())
        .filter(|&i| used[i] && free[i].contains(&true))
        .collect();
    if active.is_empty() {
        return Err(FemError::NothingFree {
            dofs: 3 * mesh.nodes.len(),
        });
    }
    let mut index = vec![None; mesh.nodes.len()];
    active.iter().enumerate().for_each(|(k, &node)| index[node] = Some(k));
    let graph = node_graph(mesh, &index, active.len());
    let order: Vec<usize> = elimination_order(&graph)?.into_iter().map(|k| active[k]).collect();
    order.iter().enumerate().for_each(|(k, &node)| index[node] = Some(k));
    let layout = Layout::new(&node_graph(mesh, &index, order.len()), &order, &free);
    let (stiffness, mass) = layout.scatter(mesh, materials, &index)?;
    let mut equation_of = vec![None; 3 * mesh.nodes.len()];
    layout
        .dof_of
        .iter()
        .enumerate()
        .for_each(|(e, &dof)| equation_of[dof] = Some(e));
    Ok(System {
        equations: Equations {
            equation_of,
            dof_of: layout.dof_of,
        },
        stiffness,
        mass,
    })
}

/// The graph of nodes that share an element, nodes numbered by `index`.
fn node_graph(mesh: &Mesh, index: &[Option<usize>], n: usize) -> Graph {
    let mut elements_of: Vec<Vec<usize>> = vec![Vec::new(); n];
    for (e, element) in mesh.elements().enumerate() {
        element
            .nodes
            .iter()
            .filter_map(|&node| index[node])
            .for_each(|k| elements_of[k].push(e));
    }
    let (mut offsets, mut targets) = (vec![0], Vec::new());
    let mut neighbours = Vec::new();
    for (k, elements) in elements_of.iter().enumerate() {
        neighbours.clear();
        for &e in elements {
            neighbours.extend(
                mesh.element(e)
                    .nodes
                    .iter()
                    .filter_map(|&node| index[node])
                    .filter(|&i| i != k),
            );
        }
        neighbours.sort_unstable();
        neighbours.dedup();
        targets.extend_from_slice(&neighbours);
        offsets.push(targets.len());
    }
    Graph { offsets, targets }
}

/// Where every node pair stands in the two matrices; built once, values are scattered into it.
struct Layout {
    dof_of: Vec<usize>,
    /// Equation of each axis of each node in elimination order, or none.
    equation: Vec<[Option<usize>; 3]>,
    /// Neighbours of each node that are eliminated with or after it, itself first.
    later: Graph,
    /// For each entry of `later`: free degrees of freedom in the column before it, in all and of each axis.
    before: Vec<[usize; 4]>,
    stiffness: CscPattern,
    mass: CscPattern,
}

struct CscPattern {
    offsets: Vec<usize>,
    rows: Vec<usize>,
}

impl Layout {
    fn new(graph: &Graph, order: &[usize], free: &[[bool; 3]]) -> Self {
        let mut dof_of = Vec::with_capacity(3 * order.len());
        let equation: Vec<[Option<usize>; 3]> = order
            .iter()
            .map(|&node| {
                std::array::from_fn(|axis| {
                    free[node][axis].then(|| {
                        dof_of.push(3 * node + axis);
                        dof_of.len() - 1
                    })
                })
            })
            .collect();
        let (mut offsets, mut targets, mut before) = (vec![0], Vec::new(), Vec::new());
        let mut stiffness = CscPattern {
            offsets: vec![0],
            rows: Vec::new(),
        };
        let mut mass = CscPattern {
            offsets: vec![0],
            rows: Vec::new(),
        };
        for p in 0..order.len() {
            let start = targets.len();
            targets.push(p);
            targets.extend(graph.neighbours(p).iter().copied().filter(|&q| q > p));
            let mut count = [0; 4];
            for &q in &targets[start..] {
                before.push(count);
                for axis in 0..3 {
                    if equation[q][axis].is_some() {
                        count[axis] += 1;
                        count[3] += 1;
                    }
                }
            }
            offsets.push(targets.len());
            for axis in 0..3 {
                let Some(column) = equation[p][axis] else { continue };
                for &q in &targets[start..] {
                    stiffness
                        .rows
                        .extend(equation[q].into_iter().flatten().filter(|&row| row >= column));
                    mass.rows.extend(equation[q][axis]);
                }
                stiffness.offsets.push(stiffness.rows.len());
                mass.offsets.push(mass.rows.len());
            }
        }
        Self {
            dof_of,
            equation,
            later: Graph { offsets, targets },
            before,
            stiffness,
            mass,
        }
    }

    fn scatter(
        &self,
        mesh: &Mesh,
        materials: &[Material],
        index: &[Option<usize>],
    ) -> Result<(CscMatrix<f64>, CscMatrix<f64>), FemError> {
        let materials: Vec<ElementMaterial> = materials.iter().map(ElementMaterial::from).collect();
        let mut rules = Vec::new();
        for &kind in &mesh.kinds {
            if !rules.iter().any(|(k, _)| *k == kind) {
                rules.push((kind, Rule::new(kind)?));
            }
        }
        let mut k_values = vec![0.0; self.stiffness.rows.len()];
        let mut m_values = vec![0.0; self.mass.rows.len()];
        // Elements are integrated in parallel and added up in their order, so the sums do not depend on the threads.
        let elements: Vec<usize> = (0..mesh.element_count()).collect();
        for batch in elements.chunks(1024) {
            let matrices: Vec<Result<ElementMatrices, FemError>> = batch
                .par_iter()
                .map(|&e| {
                    let element = mesh.element(e);
                    let rule = rules
                        .iter()
                        .find(|(kind, _)| *kind == element.kind)
                        .map(|(_, rule)| rule);
                    rule.map_or_else(
                        || Ok(ElementMatrices::default()),
                        |rule| integrate(mesh, e, element, rule, &materials[element.part]),
                    )
                })
                .collect();
            for (&e, matrices) in batch.iter().zip(matrices) {
                self.add(mesh.element(e).nodes, &matrices?, index, &mut k_values, &mut m_values);
            }
        }
        Ok((
            self.stiffness.matrix(k_values, self.dof_of.len())?,
            self.mass.matrix(m_values, self.dof_of.len())?,
        ))
    }

    fn add(
        &self,
        nodes: &[usize],
        matrices: &ElementMatrices,
        index: &[Option<usize>],
        k_values: &mut [f64],
        m_values: &mut [f64],
    ) {
        let mut pair = 0;
        for (a, &node_a) in nodes.iter().enumerate() {
            for &node_b in &nodes[..=a] {
                let (block, m) = (&matrices.stiffness[pair], matrices.mass[pair]);
                pair += 1;
                let (Some(p), Some(q)) = (index[node_a], index[node_b]) else {
                    continue;
                };
                // The column belongs to the node eliminated first; K_ab = K_ba^T.
                let (column, row, transposed) = if p <= q { (p, q, true) } else { (q, p, false) };
                let later = self.later.neighbours(column);
                let Ok(r) = later.binary_search(&row) else { continue };
                let before = self.before[self.later.offsets[column] + r];
                // Columns of a node lose one row each: the triangle of its own block.
                let mut skipped = 0;
                for j in 0..3 {
                    let Some(c) = self.equation[column][j] else { continue };
                    if self.equation[row][j].is_some() {
                        m_values[self.mass.offsets[c] + before[j]] += m;
                    }
                    let start = self.stiffness.offsets[c] + before[3];
                    let rows = (0..3).filter_map(|i| self.equation[row][i].map(|e| (i, e)));
                    for (rank, (i, _)) in rows.enumerate().filter(|(_, (_, e))| *e >= c) {
                        k_values[start + rank - skipped] += if transposed { block[j][i] } else { block[i][j] };
                    }
                    skipped += 1;
                }
            }
        }
    }
}

impl CscPattern {
    fn matrix(&self, values: Vec<f64>, n: usize) -> Result<CscMatrix<f64>, FemError> {
        CscMatrix::try_from_csc_data(n, n, self.offsets.clone(), self.rows.clone(), values)
            .map_err(|e| FemError::Order { reason: e.to_string() })
    }
}
