//! The equations of one frequency and parity, solved in single precision with residuals in double precision.
#![allow(clippy::needless_range_loop)] // indices are those of the equations, several arrays at once

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::{factor, solve};
use faer::perm::PermRef;
use faer::traits::ComplexField;
use faer::{Conj, Mat, MatMut, Par};
use nalgebra::{Complex, DMatrix};

/// Largest residual relative to the right-hand side, corresponding to 1e-4 dB; the error of the single-precision
/// kernels is a tenth of it.
const RESIDUAL: f64 = 1e-5;

/// Sums over the tiles of one frequency.
#[derive(Debug)]
pub(crate) struct Sums {
    /// Part of -K + alpha W.
    pub(crate) matrix: Mat<Complex<f32>>,
    /// The transpose of the other part, so that the contributions of a block to its own rows are contiguous in memory.
    pub(crate) transposed: Mat<Complex<f32>>,
    /// (S + alpha K') v, real and imaginary part, unknowns x patterns.
    pub(crate) right: [Mat<f64>; 2],
}

impl Sums {
    pub(crate) fn zeros(unknowns: usize, patterns: usize) -> Self {
        Self {
            matrix: Mat::zeros(unknowns, unknowns),
            transposed: Mat::zeros(unknowns, unknowns),
            right: [0, 1].map(|_| Mat::zeros(unknowns, patterns)),
        }
    }

    /// `factor` times the matrix and the right-hand sides as one array, column by column, with the real part of each
    /// value before the imaginary part; requires [`Sums::joined`].
    pub(crate) fn flat(&self, factor: Complex<f64>) -> Vec<f32> {
        let [re, im] = &self.right;
        let (n, patterns) = re.shape();
        let single = Complex::new(factor.re as f32, factor.im as f32);
        let mut values = Vec::with_capacity(2 * n * (n + patterns));
        for j in 0..n {
            values.extend(self.matrix.col_as_slice(j).iter().flat_map(|a| {
                let value = single * a;
                [value.re, value.im]
            }));
        }
        for m in 0..patterns {
            let right = re.col_as_slice(m).iter().zip(im.col_as_slice(m));
            values.extend(right.flat_map(|(&re, &im)| {
                let value = factor * Complex::new(re, im);
                [value.re as f32, value.im as f32]
            }));
        }
        values
    }

    /// Restores sums from the array of [`Sums::flat`]; `fill` writes the values from a given index onwards.
    pub(crate) fn from_flat([n, patterns]: [usize; 2], fill: impl Fn(usize, &mut [f32])) -> Self {
        let mut sums = Self {
            matrix: Mat::zeros(n, n),
            transposed: Mat::new(),
            right: [0, 1].map(|_| Mat::zeros(n, patterns)),
        };
        let mut column = vec![0.0; 2 * n];
        for j in 0..n {
            fill(2 * n * j, &mut column);
            let to = sums.matrix.col_as_slice_mut(j).iter_mut();
            to.zip(column.chunks_exact(2))
                .for_each(|(to, z)| *to = Complex::new(z[0], z[1]));
        }
        for m in 0..patterns {
            fill(2 * n * (n + m), &mut column);
            for (part, to) in sums.right.iter_mut().enumerate() {
                let to = to.col_as_slice_mut(m).iter_mut();
                to.zip(column.chunks_exact(2))
                    .for_each(|(to, z)| *to = f64::from(z[part]));
            }
        }
        sums
    }

    /// Adds the sums over other tiles; before [`Sums::joined`].
    pub(crate) fn add(&mut self, other: &Self) {
        self.matrix += &other.matrix;
        self.transposed += &other.transposed;
        self.right
            .iter_mut()
            .zip(&other.right)
            .for_each(|(to, from)| *to += from);
    }

    /// Adds both parts of the matrix, block by block.
    pub(crate) fn joined(mut self) -> Self {
        const SIDE: usize = 32;
        let n = self.matrix.nrows();
        for (left, top) in (0..n)
            .step_by(SIDE)
            .flat_map(|l| (0..n).step_by(SIDE).map(move |t| (l, t)))
        {
            for j in left..n.min(left + SIDE) {
                let rows = top..n.min(top + SIDE);
                for (to, i) in self.matrix.col_as_slice_mut(j)[rows.clone()].iter_mut().zip(rows) {
                    *to += self.transposed[(j, i)];
                }
            }
        }
        self.transposed = Mat::new();
        self
    }

    /// Replaces the equation of an unknown with the condition that it is zero; requires [`Sums::joined`].
    pub(crate) fn hold(&mut self, node: usize) {
        self.matrix
            .row_mut(node)
            .iter_mut()
            .for_each(|a| *a = Complex::default());
        self.matrix.col_mut(node).fill(Complex::default());
        self.matrix[(node, node)] = Complex::new(1.0, 0.0);
        for right in &mut self.right {
            right.row_mut(node).iter_mut().for_each(|right| *right = 0.0);
        }
    }

    /// `factor` times the inverse of the matrix times the right-hand sides, unknowns x patterns.
    ///
    /// Requires [`Sums::joined`]. Solves in single precision, or in double precision if the residual of a mixture of
    /// all patterns exceeds [`RESIDUAL`].
    pub(crate) fn solve(self, factor: Complex<f64>) -> DMatrix<Complex<f64>> {
        let [re, im] = &self.right;
        let (n, patterns) = re.shape();
        let mut work = self.matrix.clone();
        let mut found = Mat::from_fn(n, patterns, |i, m| Complex::new(re[(i, m)] as f32, im[(i, m)] as f32));
        factorise_and_solve(work.as_mut(), found.as_mut());
        let double = |z: Complex<f32>| Complex::new(f64::from(z.re), f64::from(z.im));
        if self.residual(&found) <= RESIDUAL {
            return DMatrix::from_fn(n, patterns, |i, m| factor * double(found[(i, m)]));
        }
        let mut work = Mat::from_fn(n, n, |i, j| double(self.matrix[(i, j)]));
        let mut found = Mat::from_fn(n, patterns, |i, m| Complex::new(re[(i, m)], im[(i, m)]));
        factorise_and_solve(work.as_mut(), found.as_mut());
        DMatrix::from_fn(n, patterns, |i, m| factor * found[(i, m)])
    }

    /// |b - A x| / |b| for a mixture of all patterns.
    fn residual(&self, found: &Mat<Complex<f32>>) -> f64 {
        let [re, im] = &self.right;
        let (n, patterns) = re.shape();
        let mut rest = vec![Complex::<f64>::default(); n];
        let mut mixed = rest.clone();
        for m in 0..patterns {
            let weight = (1.0 + m as f64).sin();
            for (i, (rest, x)) in rest.iter_mut().zip(&mut mixed).enumerate() {
                let found = found[(i, m)];
                *rest += Complex::new(re[(i, m)], im[(i, m)]) * weight;
                *x += Complex::new(f64::from(found.re), f64::from(found.im)) * weight;
            }
        }
        let size: f64 = rest.iter().map(Complex::norm_sqr).sum();
        for (j, x) in mixed.into_iter().enumerate() {
            for (rest, a) in rest.iter_mut().zip(self.matrix.col(j).iter()) {
                *rest -= x * Complex::new(f64::from(a.re), f64::from(a.im));
            }
        }
        let left: f64 = rest.iter().map(Complex::norm_sqr).sum();
        if left > 0.0 { (left / size).sqrt() } else { 0.0 }
    }
}

/// Overwrites the right-hand sides with the solutions, and the matrix with its factors.
fn factorise_and_solve<T: ComplexField>(mut matrix: MatMut<'_, T>, mut right: MatMut<'_, T>) {
    let (n, patterns) = right.shape();
    let (mut order, mut inverse) = (vec![0usize; n], vec![0usize; n]);
    let scratch = factor::lu_in_place_scratch::<usize, T>(n, n, Par::Seq, Default::default())
        .or(solve::solve_in_place_scratch::<usize, T>(n, patterns, Par::Seq));
    let mut memory = MemBuffer::new(scratch);
    let stack = MemStack::new(&mut memory);
    factor::lu_in_place(
        matrix.as_mut(),
        &mut order,
        &mut inverse,
        Par::Seq,
        stack,
        Default::default(),
    );
    solve::solve_in_place_with_conj(
        matrix.as_ref(),
        matrix.as_ref(),
        PermRef::new_checked(&order, &inverse, n),
        Conj::No,
        right.as_mut(),
        Par::Seq,
        stack,
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The matrix of ones, plus a smooth part of magnitude `tilt` and `diagonal` times the identity.
    fn sums(tilt: f64, diagonal: f64) -> Sums {
        let n = 40;
        let mut sums = Sums::zeros(n, 3);
        for i in 0..n {
            for j in 0..n {
                let smooth = (0.3 * (i * j) as f64).sin();
                sums.matrix[(i, j)] = Complex::new((1.0 + tilt * smooth) as f32, 0.0);
                sums.transposed[(j, i)] = Complex::new(0.0, (tilt * (i as f64 - j as f64)) as f32);
            }
            sums.matrix[(i, i)] += Complex::new(diagonal as f32, 0.0);
            for m in 0..3 {
                sums.right[0][(i, m)] = ((i + m) as f64).cos();
                sums.right[1][(i, m)] = 0.1 * m as f64;
            }
        }
        sums.joined()
    }

    fn residuals(tilt: f64, diagonal: f64) -> [f64; 3] {
        let given = sums(tilt, diagonal);
        let x = sums(tilt, diagonal).solve(Complex::new(1.0, 0.0));
        [0, 1, 2].map(|m| {
            let (mut left, mut size) = (0.0, 0.0);
            for i in 0..x.nrows() {
                let b = Complex::new(given.right[0][(i, m)], given.right[1][(i, m)]);
                let double = |a: Complex<f32>| Complex::new(f64::from(a.re), f64::from(a.im));
                let product = |j: usize| double(given.matrix[(i, j)]) * x[(j, m)];
                left += (b - (0..x.nrows()).map(product).sum::<Complex<f64>>()).norm_sqr();
                size += b.norm_sqr();
            }
            (left / size).sqrt()
        })
    }

    #[test]
    fn single_precision_where_it_suffices_and_double_where_not() {
        let good = residuals(0.01, 10.0);
        println!("{good:?}");
        assert!(good.iter().all(|r| (1e-9..RESIDUAL).contains(r)), "{good:?}");
        for tilt in [1e-2, 1e-4, 1e-6] {
            let bad = residuals(tilt, tilt);
            println!("{tilt:e}: {bad:?}");
            assert!(bad.iter().all(|r| *r < 1e-7), "{tilt:e}: {bad:?}");
        }
    }
}
