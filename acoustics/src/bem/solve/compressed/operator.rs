//! The compressed matrix and its product with many columns at once.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use nalgebra::Complex;
use rayon::prelude::*;
use std::ops::Range;

/// Largest number of columns multiplied at a time.
const COLUMNS: usize = 64;

/// A block of low rank, left times right transposed.
#[derive(Debug)]
pub(super) struct LowRank {
    pub(super) rows: Range<usize>,
    pub(super) columns: Range<usize>,
    pub(super) left: Mat<Complex<f32>>,
    pub(super) right: Mat<Complex<f32>>,
}

/// A block of close leaves.
#[derive(Debug)]
pub(super) struct Dense {
    pub(super) rows: Range<usize>,
    pub(super) columns: Range<usize>,
    pub(super) matrix: Mat<Complex<f32>>,
}

/// A matrix of blocks, ordered by the positions in the cluster tree.
#[derive(Debug, Default)]
pub(super) struct Compressed {
    pub(super) unknowns: usize,
    pub(super) low_rank: Vec<LowRank>,
    pub(super) dense: Vec<Dense>,
}

impl Compressed {
    /// The matrix times `x`. The result does not depend on the number of threads, because threads process different
    /// columns.
    pub(super) fn times(&self, x: MatRef<'_, Complex<f32>>) -> Mat<Complex<f32>> {
        by_columns(x, |x| self.times_some(x))
    }

    fn times_some(&self, x: MatRef<'_, Complex<f32>>) -> Mat<Complex<f32>> {
        let mut product = Mat::zeros(self.unknowns, x.ncols());
        let one = Complex::new(1.0, 0.0);
        for block in &self.dense {
            let x = x.subrows(block.columns.start, block.columns.len());
            let to = product.as_mut().subrows_mut(block.rows.start, block.rows.len());
            matmul(to, Accum::Add, block.matrix.as_ref(), x, one, Par::Seq);
        }
        let most = self.low_rank.iter().map(|b| b.left.ncols()).max().unwrap_or(0);
        let mut work = Mat::zeros(most, x.ncols());
        for block in &self.low_rank {
            let x = x.subrows(block.columns.start, block.columns.len());
            let rank = block.left.ncols();
            let inner = work.as_mut().subrows_mut(0, rank);
            matmul(inner, Accum::Replace, block.right.transpose(), x, one, Par::Seq);
            let to = product.as_mut().subrows_mut(block.rows.start, block.rows.len());
            matmul(
                to,
                Accum::Add,
                block.left.as_ref(),
                work.as_ref().subrows(0, rank),
                one,
                Par::Seq,
            );
        }
        product
    }
}

/// Applies an operator with as many rows as columns to a few columns at a time.
pub(super) fn by_columns(
    x: MatRef<'_, Complex<f32>>,
    each: impl Fn(MatRef<'_, Complex<f32>>) -> Mat<Complex<f32>> + Sync + Send,
) -> Mat<Complex<f32>> {
    let chunk = x.ncols().div_ceil(x.ncols().div_ceil(COLUMNS).max(1)).max(1);
    let firsts: Vec<usize> = (0..x.ncols()).step_by(chunk).collect();
    let parts = map_in_parallel(firsts.clone(), |first| {
        each(x.subcols(first, chunk.min(x.ncols() - first)))
    });
    let mut product = Mat::zeros(x.nrows(), x.ncols());
    for (part, first) in parts.iter().zip(firsts) {
        product.as_mut().subcols_mut(first, part.ncols()).copy_from(part);
    }
    product
}

/// Applies `each` to all items; the results are in the order of the items. Runs in parallel, except on a thread of a
/// pool that already works on several frequencies. If such a thread waited for part of one frequency, it would start
/// further ones, each with its own matrix.
pub(super) fn map_in_parallel<T: Send, R: Send>(items: Vec<T>, each: impl Fn(T) -> R + Sync + Send) -> Vec<R> {
    if rayon::current_thread_index().is_some() {
        items.into_iter().map(each).collect()
    } else {
        items.into_par_iter().map(each).collect()
    }
}
