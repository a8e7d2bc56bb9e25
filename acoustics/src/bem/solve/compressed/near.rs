//! Blocks between close clusters, from the same tiles as the dense matrix.

use super::Equations;
use super::clusters::{ClusterTree, Partition};
use super::operator::{Dense, map_in_parallel};
use crate::bem::mesh::symmetry::Parity;
use crate::bem::operators::blocks::Block;
use crate::bem::operators::near::NearAt;
use crate::bem::operators::tile::{Tile, spread};
use crate::bem::operators::wave::{Buffer, Operators};
use faer::Mat;
use nalgebra::{Complex, DMatrix};

/// Number of panel blocks whose contributions are in memory at a time.
const BATCH: usize = 64;

/// Which pairs of leaves are close, and where their blocks of the matrix are stored.
#[derive(Debug)]
pub(super) struct NearPairs {
    /// Index of the block of leaves t, s, at `t * leaves + s`; [`NONE`] for distant leaves.
    number: Vec<u32>,
    leaves: usize,
    /// Leaf of each unknown, and the unknown's position in the leaf.
    leaf_of: Vec<u32>,
    local: Vec<u32>,
    /// Leaf that owns each panel of the mesh.
    owners: Vec<usize>,
    /// For each panel block, the later blocks (and itself) that share a close pair of leaves with it.
    close: Vec<Vec<usize>>,
    /// Numbers of rows and columns of every block of the matrix.
    sizes: Vec<[usize; 2]>,
}

/// Marks pairs of distant leaves.
const NONE: u32 = u32::MAX;

/// The near blocks of one parity, and their contribution to the right-hand sides: unknowns x patterns, real and
/// imaginary part.
pub(super) struct NearSums {
    pub(super) blocks: Vec<Mat<Complex<f32>>>,
    pub(super) right: [Mat<f64>; 2],
}

/// Contribution of a pair of panel blocks.
struct Contribution {
    /// The second block.
    second: usize,
    parity: usize,
    /// A from the second to the first, row by row, and the transpose of A from the first to the second.
    pressure: [Vec<Complex<f32>>; 2],
    /// B times the patterns on the second, and on the first.
    velocity: [Mat<f32>; 2],
}

impl NearPairs {
    /// `owners` gives the leaf that owns each panel, which is the leaf of one of its unknowns.
    pub(super) fn new(tree: &ClusterTree, partition: &Partition, blocks: &[Block], owners: Vec<usize>) -> Self {
        let leaves = tree.leaves.len();
        let mut leaf_number = vec![0; tree.clusters.len()];
        for (number, &cluster) in tree.leaves.iter().enumerate() {
            leaf_number[cluster] = number;
        }
        let mut number = vec![NONE; leaves * leaves];
        let mut close_leaves = vec![Vec::new(); leaves];
        for (block, [t, s]) in partition.near.iter().map(|p| p.map(|c| leaf_number[c])).enumerate() {
            number[t * leaves + s] = block as u32;
            close_leaves[t].push(s);
        }
        let leaves_of = |block: &Block| {
            let mut leaves: Vec<usize> = block.nodes.iter().map(|&node| tree.leaf_of[node]).collect();
            leaves.sort_unstable();
            leaves.dedup();
            leaves
        };
        let of_blocks: Vec<Vec<usize>> = blocks.iter().map(leaves_of).collect();
        let mut blocks_of = vec![Vec::new(); leaves];
        for (j, leaves) in of_blocks.iter().enumerate() {
            leaves.iter().for_each(|&leaf| blocks_of[leaf].push(j));
        }
        let close = |(i, leaves): (usize, &Vec<usize>)| {
            let others = leaves
                .iter()
                .flat_map(|&t| &close_leaves[t])
                .flat_map(|&s| &blocks_of[s]);
            let mut close: Vec<usize> = others.copied().filter(|&j| j >= i).collect();
            close.sort_unstable();
            close.dedup();
            close
        };
        let places = tree.places();
        let first = |node: usize| tree.clusters[tree.leaves[tree.leaf_of[node]]].first;
        let size = |pair: &[usize; 2]| pair.map(|c| tree.clusters[c].len());
        Self {
            close: of_blocks.iter().enumerate().map(close).collect(),
            local: (0..places.len())
                .map(|node| (places[node] - first(node)) as u32)
                .collect(),
            leaf_of: tree.leaf_of.iter().map(|&leaf| leaf as u32).collect(),
            sizes: partition.near.iter().map(size).collect(),
            number,
            leaves,
            owners,
        }
    }

    /// The near blocks and their contribution to the right-hand sides, for each parity.
    pub(super) fn assemble(&self, equations: &Equations<'_>, patterns: &[(Parity, &DMatrix<f64>)]) -> Vec<NearSums> {
        let blocks = equations.blocks;
        let zeros = |p: &(Parity, &DMatrix<f64>)| NearSums {
            blocks: self
                .sizes
                .iter()
                .map(|&[rows, columns]| Mat::zeros(rows, columns))
                .collect(),
            right: [0, 1].map(|_| Mat::zeros(self.leaf_of.len(), p.1.ncols())),
        };
        let mut sums: Vec<NearSums> = patterns.iter().map(zeros).collect();
        let near = equations.near.at(equations.boundary, equations.wave.k);
        let parities: Vec<Parity> = patterns.iter().map(|p| p.0).collect();
        let on = |b: &Block| patterns.iter().map(|p| b.patterns(p.1)).collect();
        let on_blocks: Vec<Vec<Mat<f32>>> = map_in_parallel(blocks.iter().collect(), on);
        for first in (0..blocks.len()).step_by(BATCH) {
            let rows: Vec<usize> = (first..blocks.len().min(first + BATCH)).collect();
            let found = map_in_parallel(rows, |i| self.row(equations, &near, i, &parities, &on_blocks));
            for (i, contributions) in found.into_iter().enumerate() {
                let e = &blocks[first + i].nodes;
                for one in contributions {
                    let (f, sums) = (&blocks[one.second].nodes, &mut sums[one.parity]);
                    let all: Vec<usize> = (0..one.velocity[0].nrows()).collect();
                    let [forward, backward] = one.pressure;
                    self.add([e, f], &forward, false, &mut sums.blocks);
                    spread(e, &all, one.velocity[0].as_ref(), &mut sums.right);
                    if one.second != first + i {
                        self.add([e, f], &backward, true, &mut sums.blocks);
                        spread(f, &all, one.velocity[1].as_ref(), &mut sums.right);
                    }
                }
            }
        }
        sums
    }

    /// Contributions of a panel block and those close to it; `patterns` are those of every parity at the points of each
    /// block.
    fn row(
        &self,
        equations: &Equations<'_>,
        near: &NearAt<'_>,
        i: usize,
        parities: &[Parity],
        patterns: &[Vec<Mat<f32>>],
    ) -> Vec<Contribution> {
        let e = &equations.blocks[i];
        let mut tile = Tile::default();
        let mut found = Vec::new();
        for &j in &self.close[i] {
            let f = &equations.blocks[j];
            let operators = tile.evaluate(
                equations.boundary.planes(),
                equations.images,
                equations.wave,
                [e, f],
                parities,
                (near, near.pairs(i, j)),
            );
            for (parity, operators) in operators.iter_mut().enumerate() {
                self.clear_distant(operators, [e, f], i == j);
                let both = i != j;
                let sums = |block: &Block| Mat::zeros(patterns[i][parity].nrows(), 2 * block.nodes.len());
                let mut velocity = [sums(e), if both { sums(f) } else { Mat::new() }];
                operators.add_velocity(patterns[j][parity].as_ref(), velocity[0].as_mut());
                if both {
                    operators.add_velocity_back(f, patterns[i][parity].as_ref(), velocity[1].as_mut());
                }
                found.push(Contribution {
                    second: j,
                    parity,
                    pressure: [
                        operators.pressure(f),
                        if both { operators.pressure_back(f) } else { Vec::new() },
                    ],
                    velocity,
                });
            }
        }
        found
    }

    fn block(&self, t: u32, s: u32) -> Option<usize> {
        let number = self.number[t as usize * self.leaves + s as usize];
        (number != NONE).then_some(number as usize)
    }

    /// Adds a matrix from the second unknowns to the first, row by row, or the transpose of one from the first to the
    /// second, for unknowns in close leaves.
    fn add(&self, [e, f]: [&[usize]; 2], values: &[Complex<f32>], transposed: bool, to: &mut [Mat<Complex<f32>>]) {
        for (&row, values) in e.iter().zip(values.chunks_exact(f.len())) {
            for (&column, value) in f.iter().zip(values) {
                let [row, column] = if transposed { [column, row] } else { [row, column] };
                if let Some(block) = self.block(self.leaf_of[row], self.leaf_of[column]) {
                    to[block][(self.local[row] as usize, self.local[column] as usize)] += value;
                }
            }
        }
    }

    /// The entry for two unknowns; zero if their leaves are distant.
    pub(super) fn entry(&self, row: usize, column: usize, of: &[Dense]) -> Complex<f32> {
        match self.block(self.leaf_of[row], self.leaf_of[column]) {
            Some(block) => of[block].matrix[(self.local[row] as usize, self.local[column] as usize)],
            None => Complex::default(),
        }
    }

    /// Adds to the entry for two unknowns in close leaves.
    pub(super) fn add_entry(&self, row: usize, column: usize, value: f32, to: &mut [Dense]) {
        if let Some(block) = self.block(self.leaf_of[row], self.leaf_of[column]) {
            to[block].matrix[(self.local[row] as usize, self.local[column] as usize)] += value;
        }
    }

    /// Zeroes entries of B between unknowns and panels in distant leaves.
    fn clear_distant(&self, operators: &mut Operators, [e, f]: [&Block; 2], diagonal: bool) {
        let distant = |node: usize, panel: usize| self.block(self.leaf_of[node], self.owners[panel] as u32).is_none();
        let clear = |buffer: &mut Buffer, row: usize, column: usize| {
            for part in 0..2 {
                let at = buffer.start(part, row) + column;
                buffer.data[at] = 0.0;
            }
        };
        for (row, &node) in e.nodes.iter().enumerate() {
            for (q, _) in f.panels.iter().enumerate().filter(|&(_, &panel)| distant(node, panel)) {
                (0..f.corners).for_each(|b| clear(&mut operators.b, row, b * f.width + q));
            }
        }
        if diagonal {
            return;
        }
        for (q, &panel) in e.panels.iter().enumerate() {
            for (p, local) in f.local.iter().enumerate() {
                for j in (0..f.corners).filter(|&j| distant(f.nodes[local[j]], panel)) {
                    (0..e.corners).for_each(|a| clear(&mut operators.b_back, a * e.width + q, j * f.width + p));
                }
            }
        }
    }
}
