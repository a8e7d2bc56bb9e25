//! The operators between two blocks of panels.
#![allow(clippy::needless_range_loop)] // indices are those of the equations, several arrays at once

use crate::bem::mesh::symmetry::{Image, Parity};
use crate::bem::operators::blocks::Block;
use crate::bem::operators::equations::Sums;
use crate::bem::operators::far::{Far, corner_values};
use crate::bem::operators::near::{NearAt, NearPair, PairMatrices};
use crate::bem::operators::wave::{Buffer, Operators, Wave};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use nalgebra::DMatrix;
use pulp::Arch;
use rustfft::num_complex::Complex;

/// The velocity patterns of one parity, and what B makes of them.
#[derive(Debug)]
pub(crate) struct Flow {
    parity: Parity,
    /// At the points of each block's panels, patterns x points, panel fastest.
    patterns: Vec<Mat<f32>>,
    /// (S + alpha K') v at the nodes of each block, patterns x nodes, real parts before imaginary parts. Blocks add up their
    /// own nodes, so that matrix products accumulate in place.
    sums: Vec<Mat<f32>>,
}

impl Flow {
    /// For velocities given by the corner values of every panel.
    pub(crate) fn new(blocks: &[Block], parity: Parity, velocities: &DMatrix<f64>) -> Self {
        let count = velocities.ncols();
        Self {
            parity,
            patterns: blocks.iter().map(|b| b.patterns(velocities)).collect(),
            sums: blocks.iter().map(|b| Mat::zeros(count, 2 * b.nodes.len())).collect(),
        }
    }

    /// Adds the sums of all blocks to the right-hand sides.
    pub(crate) fn spread(&self, blocks: &[Block], to: &mut [Mat<f64>; 2]) {
        for (block, sums) in blocks.iter().zip(&self.sums) {
            spread(&block.nodes, sums.as_ref(), to);
        }
    }
}

/// Work space: the operators of every parity, and the pairs that the far rule leaves out.
#[derive(Debug)]
pub(crate) struct Tile {
    parities: Vec<Operators>,
    mask: Vec<f32>,
    to_points: [Mat<f64>; 2],
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

/// Inverse of the corner functions at the points of the far rule, corners x points: it converts an operator on corner
/// values to one on point values.
fn inverse<const E: usize>() -> Mat<f64> {
    use faer::linalg::solvers::DenseSolveCore;
    let phi = corner_values::<E>();
    Mat::from_fn(E, E, |b, j| phi[b][j]).partial_piv_lu().inverse()
}

impl Tile {
    /// Adds the operators between the blocks i and j (both directions if they differ) to the sums of every parity.
    #[allow(clippy::too_many_arguments)] // one call, in the hot loop
    pub(crate) fn add(
        &mut self,
        planes: &[Option<f64>; 3],
        images: &[Image],
        wave: Wave,
        (blocks, [i, j]): (&[Block], [usize; 2]),
        near: &NearAt<'_>,
        flows: &mut [Flow],
        sums: &mut [Sums],
    ) {
        let [e, f] = [&blocks[i], &blocks[j]];
        let parities: Vec<Parity> = flows.iter().map(|flow| flow.parity).collect();
        let near = (near, near.pairs(i, j));
        let operators = self.evaluate(planes, images, wave, [e, f], &parities, near).iter();
        for ((operators, flow), sums) in operators.zip(flows).zip(sums) {
            operators.gather([e, f], sums);
            operators.add_velocity(&flow.patterns[j], &mut flow.sums[i]);
            if i != j {
                operators.add_velocity_back(f, &flow.patterns[i], &mut flow.sums[j]);
            }
        }
    }

    /// The operators between the blocks e and f (both directions if they differ) of every parity.
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
        // A field may be needed twice: at most four at once.
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
    fn new(pair: &'a NearPair, wave: Wave, [e, f]: [&Block; 2], to_points: &[Mat<f64>; 2], m: &PairMatrices) -> Self {
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
                    close.b[i][point] += b * to_points[f.corners - 3][(j, point)];
                }
                for point in 0..e.corners {
                    close.b_back[point][j] += b_back * to_points[e.corners - 3][(i, point)];
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

/// Sums the corners of the panels f to its nodes: 2 rows x nodes, all real parts before all imaginary parts. Two rows at
/// a time, so that their additions overlap.
fn to_nodes(buffer: &Buffer, f: &Block) -> Vec<f32> {
    let mut nodal = vec![0.0; 2 * buffer.rows * f.nodes.len()];
    let pairs = buffer.data.chunks_exact((2 * buffer.columns).max(1));
    for (rows, to) in pairs.zip(nodal.chunks_exact_mut((2 * f.nodes.len()).max(1))) {
        let (first, second) = rows.split_at(buffer.columns);
        let (to_first, to_second) = to.split_at_mut(f.nodes.len());
        let mut begin = 0;
        for ((to_first, to_second), &end) in to_first.iter_mut().zip(to_second).zip(&f.columns_end) {
            let (mut of_first, mut of_second) = (0.0, 0.0);
            for &column in &f.columns[begin..end] {
                of_first += first[column];
                of_second += second[column];
            }
            (*to_first, *to_second, begin) = (of_first, of_second, end);
        }
    }
    nodal
}

/// Rows x columns of complex numbers from all real parts before all imaginary parts.
fn complex(parts: &[f32]) -> impl Iterator<Item = Complex<f32>> {
    let (re, im) = parts.split_at(parts.len() / 2);
    re.iter().zip(im).map(|(&re, &im)| Complex::new(re, im))
}

impl Operators {
    /// A from the nodes of f to those of e, row by row.
    pub(crate) fn pressure(&self, f: &Block) -> Vec<Complex<f32>> {
        complex(&to_nodes(&self.a, f)).collect()
    }

    /// The transpose of A from the nodes of e to those of f, row by row; empty if they are the same block.
    pub(crate) fn pressure_back(&self, f: &Block) -> Vec<Complex<f32>> {
        complex(&to_nodes(&self.a_back, f)).collect()
    }

    /// Adds B from the patterns on f to the nodes of e, patterns x nodes, real parts before imaginary parts.
    pub(crate) fn add_velocity(&self, on_f: &Mat<f32>, to: &mut Mat<f32>) {
        let b = self.b.stacked();
        matmul(to.as_mut(), Accum::Add, on_f.as_ref(), b.transpose(), 1.0, Par::Seq);
    }

    /// Adds B from the patterns on e to the nodes of f, likewise.
    pub(crate) fn add_velocity_back(&self, f: &Block, on_e: &Mat<f32>, to: &mut Mat<f32>) {
        let nodal = to_nodes(&self.b_back, f);
        let half = self.b_back.rows * f.nodes.len();
        for (part, b) in nodal.chunks_exact(half.max(1)).enumerate() {
            let b = MatRef::from_row_major_slice(b, self.b_back.rows, f.nodes.len());
            let to = to.as_mut().subcols_mut(part * f.nodes.len(), f.nodes.len());
            matmul(to, Accum::Add, on_e.as_ref(), b, 1.0, Par::Seq);
        }
    }

    /// Adds A from corners to nodes.
    fn gather(&self, [e, f]: [&Block; 2], sums: &mut Sums) {
        let add = |nodal: &[f32], to: &mut Mat<Complex<f32>>| {
            let columns = f.nodes.len();
            let (re, im) = nodal.split_at(nodal.len() / 2);
            let rows = re.chunks_exact(columns).zip(im.chunks_exact(columns));
            for (&row, (re, im)) in e.nodes.iter().zip(rows) {
                let to = to.col_as_slice_mut(row);
                for (&column, (&re, &im)) in f.nodes.iter().zip(re.iter().zip(im)) {
                    to[column] += Complex::new(re, im);
                }
            }
        };
        add(&to_nodes(&self.a, f), &mut sums.transposed);
        if !std::ptr::eq(e, f) {
            add(&to_nodes(&self.a_back, f), &mut sums.matrix);
        }
    }
}

/// Adds the columns of a block's product, real before imaginary, to the right-hand sides.
pub(crate) fn spread(nodes: &[usize], product: MatRef<'_, f32>, to: &mut [Mat<f64>; 2]) {
    for (part, right) in to.iter_mut().enumerate() {
        for (r, &row) in nodes.iter().enumerate() {
            let from = product.col(part * nodes.len() + r);
            right
                .col_mut(row)
                .iter_mut()
                .zip(from.iter())
                .for_each(|(to, v)| *to += f64::from(*v));
        }
    }
}
