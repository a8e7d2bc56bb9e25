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
use pulp::Arch;
use rustfft::num_complex::Complex;

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
    /// Adds the operators between the blocks e and f (both directions if they differ) to the sums of every parity.
    ///
    /// `patterns` holds the normal velocities of a parity at the points of each block's panels, patterns x points, panel
    /// fastest.
    #[allow(clippy::too_many_arguments)] // one call, in the hot loop
    pub(crate) fn add(
        &mut self,
        planes: &[Option<f64>; 3],
        images: &[Image],
        wave: Wave,
        [e, f]: [&Block; 2],
        patterns: &[(Parity, [&Mat<f32>; 2])],
        (near, pairs): (&NearAt<'_>, &[NearPair]),
        sums: &mut [Sums],
    ) {
        let diagonal = std::ptr::eq(e, f);
        self.parities.resize_with(patterns.len(), Operators::default);
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
        let odd: Vec<usize> = patterns.iter().map(|(parity, _)| parity.odd_axes()).collect();
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
            for (to, (parity, _)) in self.parities.iter_mut().zip(patterns) {
                pair.add(parity.sign(images[pair.pair.image]), [e, f], diagonal, to);
            }
        }
        for ((operators, (_, patterns)), sums) in self.parities.iter().zip(patterns).zip(sums) {
            operators.gather([e, f], diagonal, *patterns, sums);
        }
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

impl Operators {
    /// Adds corners to nodes and applies B to the patterns.
    fn gather(&self, [e, f]: [&Block; 2], diagonal: bool, patterns: [&Mat<f32>; 2], sums: &mut Sums) {
        let modes = patterns[0].nrows();
        let mut local = Vec::new();
        let to_nodes = |buffer: &Buffer, local: &mut Vec<f32>| {
            local.clear();
            for rows in buffer.data.chunks_exact(2 * buffer.columns) {
                let (first, second) = rows.split_at(buffer.columns);
                let start = local.len();
                local.resize(start + 2 * f.nodes.len(), 0.0);
                let (to_first, to_second) = local[start..].split_at_mut(f.nodes.len());
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
        };
        let at = |local: &[f32], r: usize, c: usize, rows: usize| {
            let n = f.nodes.len();
            Complex::new(local[r * n + c], local[(rows + r) * n + c])
        };
        to_nodes(&self.a, &mut local);
        for (r, &row) in e.nodes.iter().enumerate() {
            let to = sums.transposed.col_as_slice_mut(row);
            for (c, &column) in f.nodes.iter().enumerate() {
                to[column] += at(&local, r, c, e.nodes.len());
            }
        }
        let mut product = Mat::<f32>::zeros(modes, 2 * e.nodes.len());
        matmul(
            product.as_mut(),
            Accum::Replace,
            patterns[1].as_ref(),
            self.b.stacked().transpose(),
            1.0,
            Par::Seq,
        );
        spread(&e.nodes, product.as_ref(), sums);
        if diagonal {
            return;
        }
        to_nodes(&self.a_back, &mut local);
        for (r, &column) in e.nodes.iter().enumerate() {
            let to = sums.matrix.col_as_slice_mut(column);
            for (c, &row) in f.nodes.iter().enumerate() {
                to[row] += at(&local, r, c, e.nodes.len());
            }
        }
        to_nodes(&self.b_back, &mut local);
        let rows = self.b_back.rows;
        let half = rows * f.nodes.len();
        let mut product = Mat::<f32>::zeros(modes, 2 * f.nodes.len());
        for part in 0..2 {
            let b = MatRef::from_row_major_slice(&local[part * half..(part + 1) * half], rows, f.nodes.len());
            let to = product.as_mut().subcols_mut(part * f.nodes.len(), f.nodes.len());
            matmul(to, Accum::Replace, patterns[0].as_ref(), b, 1.0, Par::Seq);
        }
        spread(&f.nodes, product.as_ref(), sums);
    }
}

/// Adds the columns of a block's product, real before imaginary, to the right-hand sides.
fn spread(nodes: &[usize], product: MatRef<'_, f32>, sums: &mut Sums) {
    for (part, right) in sums.right.iter_mut().enumerate() {
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
