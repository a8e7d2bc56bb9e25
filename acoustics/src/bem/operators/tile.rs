//! The operators between two blocks of panels.
#![allow(clippy::needless_range_loop)] // indices are those of the equations, several arrays at once

use super::blocks::Block;
use super::equations::Sums;
use super::far::{Far, corner_values};
use super::near::{NearAt, NearPair, PairMatrices};
use super::wave::{Buffer, Operators, Wave};
use crate::bem::mesh::symmetry::{Image, Parity};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use pulp::Arch;
use rustfft::num_complex::Complex;

/// The velocity patterns of one parity at the points of all blocks.
///
/// Patterns are ordered by the first block that they move, so that those of each body are contiguous and a block
/// multiplies only a range of them.
#[derive(Debug)]
pub(crate) struct PatternsOnBlocks {
    parity: Parity,
    order: Vec<usize>,
    on_blocks: Vec<OnBlock>,
}

/// The patterns that move a block: the index of the first, and their values at the points of its panels, patterns x
/// points, with the panel index fastest.
#[derive(Debug)]
struct OnBlock {
    first: usize,
    patterns: Mat<f32>,
}

impl PatternsOnBlocks {
    /// Arranges patterns of a parity at the points of each block, patterns x points, see [`Block::patterns`].
    pub(crate) fn new(parity: Parity, all: &[Mat<f32>]) -> Self {
        let count = all.first().map_or(0, Mat::nrows);
        let moves = |block: usize, m: usize| all[block].row(m).iter().any(|v| *v != 0.0);
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by_cached_key(|&m| (0..all.len()).find(|&block| moves(block, m)));
        let on_block = |(block, all): (usize, &Mat<f32>)| {
            let moved = |place: &usize| moves(block, order[*place]);
            let first = (0..count).find(moved).unwrap_or(count);
            let end = (first..count).rfind(moved).map_or(first, |last| last + 1);
            OnBlock {
                first,
                patterns: Mat::from_fn(end - first, all.ncols(), |i, point| all[(order[first + i], point)]),
            }
        };
        Self {
            parity,
            on_blocks: all.iter().enumerate().map(on_block).collect(),
            order,
        }
    }
}

/// The right-hand sides of one parity: the product of B with its velocity patterns.
#[derive(Debug)]
pub(crate) struct RightHandSide<'a> {
    patterns: &'a PatternsOnBlocks,
    /// (S + alpha K') v at the nodes of each block, patterns x nodes, real parts before imaginary parts. Each block has
    /// its own sums, so that matrix products accumulate in place.
    sums: Vec<Mat<f32>>,
}

impl<'a> RightHandSide<'a> {
    /// Zero sums.
    pub(crate) fn zeros(blocks: &[Block], patterns: &'a PatternsOnBlocks) -> Self {
        let zeros = |b: &Block| Mat::zeros(patterns.order.len(), 2 * b.nodes.len());
        Self {
            patterns,
            sums: blocks.iter().map(zeros).collect(),
        }
    }

    /// Adds the contribution of the patterns on block `from` to the sums at the nodes of block `to`.
    fn add(&mut self, from: usize, to: usize, add: impl FnOnce(MatRef<'_, f32>, MatMut<'_, f32>)) {
        let OnBlock { first, patterns } = &self.patterns.on_blocks[from];
        if patterns.nrows() > 0 {
            let sums = self.sums[to].as_mut().subrows_mut(*first, patterns.nrows());
            add(patterns.as_ref(), sums);
        }
    }

    /// Adds the sums of all blocks to the right-hand sides.
    pub(crate) fn spread(&self, blocks: &[Block], to: &mut [Mat<f64>; 2]) {
        for (block, sums) in blocks.iter().zip(&self.sums) {
            spread(&block.nodes, &self.patterns.order, sums.as_ref(), to);
        }
    }
}

/// Workspace: the operators of every parity, and the pairs omitted by the far rule.
#[derive(Debug)]
pub(crate) struct Tile {
    parities: Vec<Operators>,
    mask: Vec<f32>,
    to_points: [[[f64; 4]; 4]; 2],
}

impl Default for Tile {
    fn default() -> Self {
        Self {
            parities: Vec::new(),
            mask: Vec::new(),
            to_points: [inverse::<3>(), inverse::<4>()],
        }
    }
}

/// Inverse of the corner functions at the points of the far rule, corners x points; it converts an operator on corner
/// values to one on point values.
fn inverse<const E: usize>() -> [[f64; 4]; 4] {
    use faer::linalg::solvers::DenseSolveCore;
    let phi = corner_values::<E>();
    let inverse = Mat::from_fn(E, E, |b, j| phi[b][j]).partial_piv_lu().inverse();
    let mut all = [[0.0; 4]; 4];
    for (j, row) in all.iter_mut().enumerate().take(E) {
        for (point, value) in row.iter_mut().enumerate().take(E) {
            *value = inverse[(j, point)];
        }
    }
    all
}

impl Tile {
    /// Adds the operators between blocks i and j (in both directions if they differ) to the sums of every parity.
    #[allow(clippy::too_many_arguments)] // one call, in the hot loop
    pub(crate) fn add(
        &mut self,
        planes: &[Option<f64>; 3],
        images: &[Image],
        wave: Wave,
        (blocks, [i, j]): (&[Block], [usize; 2]),
        near: &NearAt<'_>,
        right_hand_sides: &mut [RightHandSide<'_>],
        sums: &mut [Sums],
    ) {
        let [e, f] = [&blocks[i], &blocks[j]];
        let parities: Vec<Parity> = right_hand_sides.iter().map(|right| right.patterns.parity).collect();
        let near = (near, near.pairs(i, j));
        let operators = self.evaluate(planes, images, wave, [e, f], &parities, near).iter();
        for ((operators, right_hand_side), sums) in operators.zip(right_hand_sides).zip(sums) {
            operators.gather([e, f], sums);
            right_hand_side.add(j, i, |on_f, to| operators.add_velocity(on_f, to));
            if i != j {
                right_hand_side.add(i, j, |on_e, to| operators.add_velocity_back(f, on_e, to));
            }
        }
    }

    /// Evaluates the operators between blocks e and f (in both directions if they differ) for every parity.
    pub(crate) fn evaluate(
        &mut self,
        planes: &[Option<f64>; 3],
        images: &[Image],
        wave: Wave,
        [e, f]: [&Block; 2],
        all_parities: &[Parity],
        (near, pairs): (&NearAt<'_>, &[NearPair]),
    ) -> &mut [Operators] {
        let diagonal = std::ptr::eq(e, f);
        self.parities.resize_with(all_parities.len(), Operators::default);
        self.parities.iter_mut().for_each(|p| p.reset([e, f], diagonal));
        self.mask.clear();
        for _ in 0..images.len() * e.panels.len() {
            self.mask.resize(self.mask.len() + f.panels.len(), 1.0);
            self.mask.resize(self.mask.len() + f.width - f.panels.len(), 0.0);
        }
        for pair in pairs {
            let first = pair.image * e.panels.len();
            self.mask[(first + pair.e) * f.width + pair.f] = 0.0;
            if diagonal {
                self.mask[(first + pair.f) * f.width + pair.e] = 0.0;
            }
        }
        let odd: Vec<usize> = all_parities.iter().map(|parity| parity.odd_axes()).collect();
        // A field may be needed twice, so at most four are evaluated at once.
        for (parities, to) in odd.chunks(4).zip(self.parities.chunks_mut(4)) {
            let mask = &self.mask;
            Arch::new().dispatch(Far {
                wave,
                e,
                f,
                planes: *planes,
                parities,
                diagonal,
                mask,
                to,
            });
        }
        let mut own = PairMatrices::default();
        for pair in pairs {
            let pair = Close::new(pair, wave, [e, f], &self.to_points, near.matrices(pair, &mut own));
            for (to, parity) in self.parities.iter_mut().zip(all_parities) {
                pair.add(parity.sign(images[pair.pair.image]), [e, f], diagonal, to);
            }
        }
        &mut self.parities
    }
}

/// Contribution of a close pair to the operators of its blocks.
struct Close<'a> {
    pair: &'a NearPair,
    a: [[Complex<f64>; 4]; 4],
    a_back: [[Complex<f64>; 4]; 4],
    /// B from the points of f to the corners of e.
    b: [[Complex<f64>; 4]; 4],
    /// Transpose of B from the points of e to the corners of f.
    b_back: [[Complex<f64>; 4]; 4],
}

impl<'a> Close<'a> {
    fn new(
        pair: &'a NearPair,
        wave: Wave,
        [e, f]: [&Block; 2],
        to_points: &[[[f64; 4]; 4]; 2],
        m: &PairMatrices,
    ) -> Self {
        let mut close = Self {
            pair,
            a: Default::default(),
            a_back: Default::default(),
            b: Default::default(),
            b_back: Default::default(),
        };
        let alpha = wave.alpha();
        for i in 0..e.corners {
            for j in 0..f.corners {
                let (s, k, kp, w) = (m.s[i][j], m.k[i][j], m.kp[i][j], alpha * m.w[i][j]);
                close.a[i][j] = w - k;
                close.a_back[i][j] = w - kp;
                let (b, b_back) = (s + alpha * kp, s + alpha * k);
                for point in 0..f.corners {
                    close.b[i][point] += b * to_points[f.corners - 3][j][point];
                }
                for point in 0..e.corners {
                    close.b_back[point][j] += b_back * to_points[e.corners - 3][i][point];
                }
            }
        }
        close
    }

    fn add(&self, sign: f64, [e, f]: [&Block; 2], diagonal: bool, to: &mut Operators) {
        let pair = self.pair;
        for i in 0..e.corners {
            for j in 0..f.corners {
                let (row, column) = (e.local[pair.e][i], j * f.width + pair.f);
                let (back_row, back) = (f.local[pair.f][j], i * e.width + pair.e);
                to.a.add(row, column, sign * self.a[i][j]);
                to.b.add(row, column, sign * self.b[i][j]);
                if !diagonal {
                    to.a_back.add(row, column, sign * self.a_back[i][j]);
                    to.b_back.add(back, column, sign * self.b_back[i][j]);
                } else if pair.e != pair.f {
                    to.a.add(back_row, back, sign * self.a_back[i][j]);
                    to.b.add(back_row, back, sign * self.b_back[i][j]);
                }
            }
        }
    }
}

/// The sums of a row over the corners of the panels f, by node.
fn at_nodes<'a>(buffer: &'a Buffer, row: usize, f: &'a Block) -> impl Iterator<Item = Complex<f32>> + 'a {
    let [re, im] = [0, 1].map(|part| &buffer.data[buffer.start(part, row)..][..buffer.columns]);
    let mut begin = 0;
    f.columns_end.iter().map(move |&end| {
        let mut sum = Complex::default();
        for &column in &f.columns[begin..end] {
            sum += Complex::new(re[column], im[column]);
        }
        begin = end;
        sum
    })
}

impl Operators {
    /// A from the nodes of f to those of e, row by row.
    pub(crate) fn pressure(&self, f: &Block) -> Vec<Complex<f32>> {
        (0..self.a.rows).flat_map(|row| at_nodes(&self.a, row, f)).collect()
    }

    /// The transpose of A from the nodes of e to those of f, row by row; empty if they are the same block.
    pub(crate) fn pressure_back(&self, f: &Block) -> Vec<Complex<f32>> {
        (0..self.a_back.rows)
            .flat_map(|row| at_nodes(&self.a_back, row, f))
            .collect()
    }

    /// Adds B from the patterns on f to the nodes of e, patterns x nodes, real parts before imaginary parts.
    pub(crate) fn add_velocity(&self, on_f: MatRef<'_, f32>, to: MatMut<'_, f32>) {
        let b = self.b.stacked();
        matmul(to, Accum::Add, on_f, b.transpose(), 1.0, Par::Seq);
    }

    /// Adds B from the patterns on e to the nodes of f, likewise.
    pub(crate) fn add_velocity_back(&self, f: &Block, on_e: MatRef<'_, f32>, to: MatMut<'_, f32>) {
        let nodes = f.nodes.len();
        let mut nodal = vec![0.0; self.b_back.rows * 2 * nodes];
        for (row, to) in nodal.chunks_exact_mut(2 * nodes).enumerate() {
            let (re, im) = to.split_at_mut(nodes);
            for ((re, im), sum) in re.iter_mut().zip(im).zip(at_nodes(&self.b_back, row, f)) {
                (*re, *im) = (sum.re, sum.im);
            }
        }
        let b = MatRef::from_row_major_slice(&nodal, self.b_back.rows, 2 * nodes);
        matmul(to, Accum::Add, on_e, b, 1.0, Par::Seq);
    }

    /// Adds A from corners to nodes.
    fn gather(&self, [e, f]: [&Block; 2], sums: &mut Sums) {
        let add = |buffer: &Buffer, to: &mut Mat<Complex<f32>>| {
            for (row, &node) in e.nodes.iter().enumerate().take(buffer.rows) {
                let to = to.col_as_slice_mut(node);
                for (&column, sum) in f.nodes.iter().zip(at_nodes(buffer, row, f)) {
                    to[column] += sum;
                }
            }
        };
        add(&self.a, &mut sums.transposed);
        add(&self.a_back, &mut sums.matrix);
    }
}

/// Adds a product at the nodes of a block, patterns x nodes, real before imaginary, to the right-hand sides.
pub(crate) fn spread(nodes: &[usize], patterns: &[usize], product: MatRef<'_, f32>, to: &mut [Mat<f64>; 2]) {
    for (part, right) in to.iter_mut().enumerate() {
        let product = product.subcols(part * nodes.len(), nodes.len());
        for (&pattern, from) in patterns.iter().zip(product.row_iter()) {
            let to = right.col_as_slice_mut(pattern);
            for (&node, value) in nodes.iter().zip(from.iter()) {
                to[node] += f64::from(*value);
            }
        }
    }
}
