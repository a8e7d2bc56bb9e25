//! The compressed matrix and its product with many columns at once.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use nalgebra::Complex;
use rayon::prelude::*;
use std::ops::Range;

/// Columns that are multiplied at a time.
const COLUMNS: usize = 32;

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

/// A matrix of blocks, in the order of the clusters' places.
#[derive(Debug, Default)]
pub(super) struct Compressed {
    pub(super) unknowns: usize,
    pub(super) low_rank: Vec<LowRank>,
    pub(super) dense: Vec<Dense>,
}

impl Compressed {
    /// Numbers stored.
    pub(super) fn entries(&self) -> usize {
        let thin = |b: &LowRank| b.left.ncols() * (b.left.nrows() + b.right.nrows());
        let full = |b: &Dense| b.matrix.nrows() * b.matrix.ncols();
        self.low_rank.iter().map(thin).sum::<usize>() + self.dense.iter().map(full).sum::<usize>()
    }

    /// The matrix times `x`. The result does not depend on the number of threads: each thread multiplies other columns.
    pub(super) fn times(&self, x: MatRef<'_, Complex<f32>>) -> Mat<Complex<f32>> {
        let firsts = (0..x.ncols()).step_by(COLUMNS).collect();
        let parts = map_in_parallel(firsts, |first| {
            self.times_some(x.subcols(first, COLUMNS.min(x.ncols() - first)))
        });
        let mut product = Mat::zeros(self.unknowns, x.ncols());
        for (part, first) in parts.iter().zip((0..x.ncols()).step_by(COLUMNS)) {
            product.as_mut().subcols_mut(first, part.ncols()).copy_from(part);
        }
        product
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

/// Applies `each` to all items; the results are in the order of the items. In parallel, or in turn on a thread of a pool
/// that is working on several frequencies already: waiting there for a part of one frequency would begin further
/// frequencies, each with its own matrix.
pub(super) fn map_in_parallel<T: Send, R: Send>(items: Vec<T>, each: impl Fn(T) -> R + Sync + Send) -> Vec<R> {
    if rayon::current_thread_index().is_some() {
        items.into_iter().map(each).collect()
    } else {
        items.into_par_iter().map(each).collect()
    }
}
