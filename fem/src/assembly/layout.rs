//! The sparsity pattern of K and M, and the assembly of values into it.

use std::ops::Range;

use nailnoise_meshes::Mesh;
use nalgebra::Matrix3;
use nalgebra_sparse::pattern::SparsityPattern;
use rayon::prelude::*;

use super::element::{ElementMaterial, ElementMatrices, Rule, integrate};
use crate::factor::order::Graph;
use crate::reduction::{Reduction, Term};
use crate::{FemError, Material};

/// Number of elements integrated in parallel at a time; their sums are formed in element order.
const BATCH: usize = 1024;

/// Number of column blocks that are assembled in parallel.
const PIECES: usize = 8;

/// Number of nodes whose neighbours one thread finds at a time.
const NODES: usize = 4096;

/// Sets of independent nodes whose unknowns are coupled: those of each element and of each attachment.
pub(crate) struct Cliques {
    offsets: Vec<usize>,
    nodes: Vec<usize>,
}

impl Cliques {
    pub(crate) fn new(mesh: &Mesh, reduction: &Reduction) -> Self {
        let mut cliques = Self {
            offsets: vec![0],
            nodes: Vec::with_capacity(mesh.connectivity.len()),
        };
        for element in mesh.elements() {
            for &node in element.nodes {
                match reduction.expansion(node) {
                    None => cliques.nodes.push(node),
                    Some(terms) => cliques.nodes.extend(terms.iter().map(|t| t.0)),
                }
            }
            cliques.offsets.push(cliques.nodes.len());
        }
        for added in &reduction.added {
            cliques.nodes.extend_from_slice(&added.nodes);
            cliques.offsets.push(cliques.nodes.len());
        }
        cliques
    }

    pub(crate) fn nodes(&self) -> impl Iterator<Item = usize> {
        self.nodes.iter().copied()
    }

    /// The graph of nodes that share a clique, with nodes numbered by `index`.
    pub(crate) fn graph(&self, index: &[Option<usize>], n: usize) -> Graph {
        let mut cliques_of: Vec<Vec<usize>> = vec![Vec::new(); n];
        for (c, range) in self.offsets.windows(2).enumerate() {
            let nodes = &self.nodes[range[0]..range[1]];
            nodes
                .iter()
                .filter_map(|&node| index[node])
                .for_each(|k| cliques_of[k].push(c));
        }
        let parts = cliques_of.par_chunks(NODES).enumerate().map(|(part, cliques)| {
            let (mut ends, mut targets) = (Vec::with_capacity(cliques.len()), Vec::new());
            let mut seen = vec![usize::MAX; n];
            for (k, cliques) in (part * NODES..).zip(cliques) {
                let start = targets.len();
                seen[k] = k;
                for &c in cliques {
                    for &node in &self.nodes[self.offsets[c]..self.offsets[c + 1]] {
                        if let Some(i) = index[node].filter(|&i| seen[i] != k) {
                            seen[i] = k;
                            targets.push(i);
                        }
                    }
                }
                targets[start..].sort_unstable();
                ends.push(targets.len());
            }
            (ends, targets)
        });
        let parts: Vec<(Vec<usize>, Vec<usize>)> = parts.collect();
        let (mut offsets, mut targets) = (vec![0], Vec::new());
        for (ends, own) in parts {
            offsets.extend(ends.into_iter().map(|end| targets.len() + end));
            targets.extend(own);
        }
        Graph { offsets, targets }
    }
}

/// Position of every node pair in the two matrices; built once before values are assembled.
pub(crate) struct Layout {
    pub(crate) dof_of: Vec<usize>,
    /// Equation of each axis of each node, or none.
    equation: Vec<[Option<usize>; 3]>,
    /// Neighbours of each node with later numbers, preceded by the node itself.
    later: Graph,
    /// For each entry of `later`, the number of preceding entries in the columns of the stiffness, and in those of each
    /// axis of the mass.
    before: Vec<[usize; 4]>,
    /// How the mass matrix couples a node with others across axes.
    mixing: Vec<Mixing>,
    /// Patterns of the lower triangles of K and M, by columns.
    pub(crate) stiffness: SparsityPattern,
    pub(crate) mass: SparsityPattern,
}

/// Elements couple only like axes; attachments may couple all.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Mixing {
    Never,
    /// Across axes, but only with nodes that also mix.
    Among,
    /// Across axes with every neighbour.
    Always,
}

struct CscPattern {
    offsets: Vec<usize>,
    rows: Vec<usize>,
}

fn mixes(a: Mixing, b: Mixing) -> bool {
    a == Mixing::Always || b == Mixing::Always || (a == Mixing::Among && b == Mixing::Among)
}

impl Layout {
    /// `order` lists the node at each position of `graph`, `free` its free axes.
    ///
    /// # Errors
    /// [`FemError::Order`]; does not occur for the graph of a mesh.
    pub(crate) fn new(
        graph: &Graph,
        order: &[usize],
        free: &[[bool; 3]],
        reduction: &Reduction,
    ) -> Result<Self, FemError> {
        let mut mixing_of = vec![Mixing::Never; reduction.nodes];
        for added in &reduction.added {
            added.nodes.iter().for_each(|&n| mixing_of[n] = Mixing::Among);
        }
        reduction.rotations.iter().for_each(|&n| mixing_of[n] = Mixing::Always);
        let mixing: Vec<Mixing> = order.iter().map(|&node| mixing_of[node]).collect();
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
        let (mut stiffness, mut mass) = (CscPattern::new(), CscPattern::new());
        for p in 0..order.len() {
            let start = targets.len();
            targets.push(p);
            targets.extend(graph.neighbours(p).iter().copied().filter(|&q| q > p));
            let later = &targets[start..];
            let rows = |q: usize, column: usize| equation[q].into_iter().flatten().filter(move |&row| row >= column);
            let mut count = [0; 4];
            for &q in later {
                before.push(count);
                let mixed = mixes(mixing[p], mixing[q]);
                for axis in 0..3 {
                    count[3] += usize::from(equation[q][axis].is_some());
                    let Some(column) = equation[p][axis] else { continue };
                    count[axis] += match mixed {
                        true => rows(q, column).count(),
                        false => usize::from(equation[q][axis].is_some()),
                    };
                }
            }
            for (axis, column) in equation[p].iter().enumerate() {
                let Some(column) = *column else { continue };
                for &q in later {
                    stiffness.rows.extend(rows(q, column));
                    match mixes(mixing[p], mixing[q]) {
                        true => mass.rows.extend(rows(q, column)),
                        false => mass.rows.extend(equation[q][axis]),
                    }
                }
                stiffness.offsets.push(stiffness.rows.len());
                mass.offsets.push(mass.rows.len());
            }
            offsets.push(targets.len());
        }
        let equations = dof_of.len();
        Ok(Self {
            dof_of,
            equation,
            later: Graph { offsets, targets },
            before,
            mixing,
            stiffness: stiffness.checked(equations)?,
            mass: mass.checked(equations)?,
        })
    }

    /// Assembles K and M from the elements and attachments; `index` gives the position of each node.
    pub(crate) fn scatter(
        &self,
        mesh: &Mesh,
        materials: &[Material],
        index: &[Option<usize>],
        reduction: &Reduction,
    ) -> Result<Values, FemError> {
        let materials: Vec<ElementMaterial> = materials.iter().map(ElementMaterial::from).collect();
        let mut rules = Vec::new();
        for &kind in &mesh.kinds {
            if !rules.iter().any(|(k, _)| *k == kind) {
                rules.push((kind, Rule::new(kind)?));
            }
        }
        let mut values = Values {
            stiffness: vec![0.0; self.stiffness.nnz()],
            mass: vec![0.0; self.mass.nnz()],
        };
        // Elements are integrated in parallel. Each column block adds them in the order of their numbers, so the sums
        // do not depend on the threads. One batch is integrated while the previous one is added.
        let elements: Vec<usize> = (0..mesh.element_count()).collect();
        let integrated = |batch: &[usize]| -> Vec<Result<ElementMatrices, FemError>> {
            let of_element = |&e: &usize| {
                let element = mesh.element(e);
                let rule = rules
                    .iter()
                    .find(|(kind, _)| *kind == element.kind)
                    .map(|(_, rule)| rule);
                rule.map_or_else(
                    || Ok(ElementMatrices::default()),
                    |rule| integrate(mesh, e, element, rule, &materials[element.part]),
                )
            };
            batch.par_iter().map(of_element).collect()
        };
        let mut pieces = self.pieces(&mut values);
        let mut add = |batch: &[usize], matrices: Vec<Result<ElementMatrices, FemError>>| -> Result<(), FemError> {
            if matrices.iter().any(Result::is_err) {
                return matrices.into_iter().collect::<Result<Vec<_>, _>>().map(drop);
            }
            let of_element = |(&e, matrices)| {
                let nodes = mesh.element(e).nodes;
                let reduced = nodes.iter().any(|&n| reduction.expansion(n).is_some());
                (nodes, reduced, matrices)
            };
            let elements: Vec<_> = batch.iter().zip(matrices.iter().flatten()).map(of_element).collect();
            pieces.par_iter_mut().for_each(|piece| {
                for &(nodes, reduced, matrices) in &elements {
                    if reduced {
                        self.add_reduced(nodes, matrices, index, reduction, piece);
                    } else {
                        self.add(nodes, matrices, index, piece);
                    }
                }
            });
            Ok(())
        };
        let mut batches = elements.chunks(BATCH);
        let mut ready = batches.next().map(|batch| (batch, integrated(batch)));
        while let Some((batch, matrices)) = ready {
            let next = || batches.next().map(|batch| (batch, integrated(batch)));
            let (added, following) = rayon::join(|| add(batch, matrices), next);
            added?;
            ready = following;
        }
        pieces.par_iter_mut().for_each(|piece| {
            for added in &reduction.added {
                for (a, b, k, m) in &added.blocks {
                    if let (Some(p), Some(q)) = (index[added.nodes[*a]], index[added.nodes[*b]]) {
                        self.add_block(p, q, k, m, piece);
                    }
                }
            }
        });
        Ok(values)
    }

    /// Splits the values into column blocks of similar size.
    fn pieces<'v>(&self, values: &'v mut Values) -> Vec<Piece<'v>> {
        let (of_stiffness, of_mass) = (self.stiffness.major_offsets(), self.mass.major_offsets());
        let Values { stiffness, mass } = values;
        let (mut stiffness, mut mass) = (&mut stiffness[..], &mut mass[..]);
        let size = stiffness.len().div_ceil(PIECES);
        let mut pieces = Vec::with_capacity(PIECES);
        let (mut first, mut start, mut column) = (0, 0, 0);
        for (p, equations) in self.equation.iter().enumerate() {
            column += equations.iter().flatten().count();
            if of_stiffness[column] < (pieces.len() + 1) * size && p + 1 < self.equation.len() {
                continue;
            }
            let offsets = [of_stiffness[start], of_mass[start]];
            let (own_stiffness, behind) = stiffness.split_at_mut(of_stiffness[column] - offsets[0]);
            let (own_mass, behind_mass) = mass.split_at_mut(of_mass[column] - offsets[1]);
            pieces.push(Piece {
                nodes: first..p + 1,
                offsets,
                stiffness: own_stiffness,
                mass: own_mass,
            });
            (stiffness, mass) = (behind, behind_mass);
            (first, start) = (p + 1, column);
        }
        pieces
    }

    /// Adds an element without dependent nodes, as far as it lies in a column block.
    fn add(&self, nodes: &[usize], matrices: &ElementMatrices, index: &[Option<usize>], piece: &mut Piece<'_>) {
        let mut pair = 0;
        for (a, &node_a) in nodes.iter().enumerate() {
            for &node_b in &nodes[..=a] {
                let (block, m) = (&matrices.stiffness[pair], matrices.mass[pair]);
                pair += 1;
                let (Some(p), Some(q)) = (index[node_a], index[node_b]) else {
                    continue;
                };
                if !piece.nodes.contains(&p.min(q)) {
                    continue;
                }
                let mass = |i, j| if i == j { m } else { 0.0 };
                // The column belongs to the node with the lower number; K_ab = K_ba^T.
                if p <= q {
                    self.add_pair((q, p), |i, j| block[j][i], mass, piece);
                } else {
                    self.add_pair((p, q), |i, j| block[i][j], mass, piece);
                }
            }
        }
    }

    /// Adds stiffness and mass between the axes i of node `row` and j of node `column` <= `row`: all pairs, or only the
    /// lower triangle if the nodes are the same. Unless the pair mixes axes, the mass between different axes is zero.
    #[inline(always)]
    fn add_pair(
        &self,
        (row, column): (usize, usize),
        stiffness: impl Fn(usize, usize) -> f64,
        mass: impl Fn(usize, usize) -> f64,
        piece: &mut Piece<'_>,
    ) {
        let later = self.later.neighbours(column);
        let Ok(r) = later.binary_search(&row) else { return };
        let before = self.before[self.later.offsets[column] + r];
        let mixed = mixes(self.mixing[column], self.mixing[row]);
        // In the diagonal block, which is a triangle, each column has one row less.
        let mut skipped = 0;
        for j in 0..3 {
            let Some(c) = self.equation[column][j] else { continue };
            let of_stiffness = self.stiffness.major_offsets()[c] + before[3] - piece.offsets[0];
            let of_mass = self.mass.major_offsets()[c] + before[j] - piece.offsets[1];
            let rows = (0..3).filter_map(|i| self.equation[row][i].map(|e| (i, e)));
            let mut rank_of_mass = 0;
            for (rank, (i, _)) in rows.enumerate().filter(|(_, (_, e))| *e >= c) {
                piece.stiffness[of_stiffness + rank - skipped] += stiffness(i, j);
                if mixed || i == j {
                    piece.mass[of_mass + rank_of_mass] += mass(i, j);
                    rank_of_mass += 1;
                }
            }
            skipped += 1;
        }
    }

    /// Adds W^T K W and W^T M W of an element with dependent nodes, as far as they lie in a column block.
    fn add_reduced(
        &self,
        nodes: &[usize],
        matrices: &ElementMatrices,
        index: &[Option<usize>],
        reduction: &Reduction,
        piece: &mut Piece<'_>,
    ) {
        let own: Vec<[Term; 1]> = nodes.iter().map(|&n| [(n, Matrix3::identity())]).collect();
        let terms: Vec<&[Term]> = nodes
            .iter()
            .zip(&own)
            .map(|(&n, own)| reduction.expansion(n).unwrap_or(own))
            .collect();
        let mut pair = 0;
        for a in 0..nodes.len() {
            for b in 0..=a {
                let block = &matrices.stiffness[pair];
                let k = Matrix3::from_fn(|i, j| block[i][j]);
                let m = Matrix3::from_diagonal_element(matrices.mass[pair]);
                pair += 1;
                for &(node_p, w) in terms[a] {
                    for &(node_q, v) in terms[b] {
                        let (Some(p), Some(q)) = (index[node_p], index[node_q]) else {
                            continue;
                        };
                        if !piece.nodes.contains(&p.min(q)) {
                            continue;
                        }
                        let (k, m) = (w.transpose() * k * v, w.transpose() * m * v);
                        self.add_block(p, q, &k, &m, piece);
                        if a != b {
                            self.add_block(q, p, &k.transpose(), &m.transpose(), piece);
                        }
                    }
                }
            }
        }
    }

    /// Adds the part of the block between nodes p and q that lies in the lower triangle and in a column block.
    fn add_block(&self, p: usize, q: usize, k: &Matrix3<f64>, m: &Matrix3<f64>, piece: &mut Piece<'_>) {
        if p >= q && piece.nodes.contains(&q) {
            self.add_pair((p, q), |i, j| k[(i, j)], |i, j| m[(i, j)], piece);
        }
    }
}

/// Values in the order of the patterns.
pub(crate) struct Values {
    pub(crate) stiffness: Vec<f64>,
    pub(crate) mass: Vec<f64>,
}

/// The values in the columns of consecutive nodes.
struct Piece<'v> {
    /// Positions of the nodes.
    nodes: Range<usize>,
    /// Number of stiffness and mass values before the block.
    offsets: [usize; 2],
    stiffness: &'v mut [f64],
    mass: &'v mut [f64],
}

impl CscPattern {
    fn new() -> Self {
        Self {
            offsets: vec![0],
            rows: Vec::new(),
        }
    }

    fn checked(self, n: usize) -> Result<SparsityPattern, FemError> {
        SparsityPattern::try_from_offsets_and_indices(n, n, self.offsets, self.rows)
            .map_err(|e| FemError::Order { reason: e.to_string() })
    }
}
