//! A tall matrix that grows by columns.

use std::ops::Range;

use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Mat, MatMut, MatRef};

use crate::dense::{add_product, transpose_product};

/// Columns that one piece of memory holds.
const PIECE: usize = 128;

/// V in pieces of [`PIECE`] columns, so that it grows without being copied and no more of it is in memory than is used.
pub(crate) struct Columns {
    rows: usize,
    pieces: Vec<Mat<f64>>,
}

impl Columns {
    pub(crate) fn new(rows: usize) -> Self {
        Self {
            rows,
            pieces: Vec::new(),
        }
    }

    /// Writes a block from column `start` on.
    pub(crate) fn put(&mut self, start: usize, block: MatRef<'_, f64>) {
        while self.pieces.len() * PIECE < start + block.ncols() {
            self.pieces.push(Mat::zeros(self.rows, PIECE));
        }
        let mut from = 0;
        while from < block.ncols() {
            let (piece, at) = ((start + from) / PIECE, (start + from) % PIECE);
            let width = (PIECE - at).min(block.ncols() - from);
            let mut to = self.pieces[piece].subcols_mut(at, width);
            to.rb_mut().copy_from(block.subcols(from, width));
            from += width;
        }
    }

    /// The parts of `range` that stand together, each with its place in the range.
    fn parts(&self, range: Range<usize>) -> impl Iterator<Item = (usize, MatRef<'_, f64>)> {
        let pieces = range.start / PIECE..range.end.div_ceil(PIECE);
        pieces.map(move |p| {
            let (start, end) = (range.start.max(p * PIECE), range.end.min((p + 1) * PIECE));
            (start - range.start, self.pieces[p].subcols(start - p * PIECE, end - start))
        })
    }

    /// V^T Z with the columns `range` of V.
    pub(crate) fn transpose_product(&self, range: Range<usize>, z: MatRef<'_, f64>) -> Mat<f64> {
        let mut c = Mat::zeros(range.len(), z.ncols());
        for (at, v) in self.parts(range) {
            let part = transpose_product(v, z);
            c.subrows_mut(at, v.ncols()).copy_from(&part);
        }
        c
    }

    /// W += alpha V C with the columns `range` of V.
    pub(crate) fn add_product(&self, range: Range<usize>, mut w: MatMut<'_, f64>, alpha: f64, c: MatRef<'_, f64>) {
        for (at, v) in self.parts(range) {
            add_product(w.rb_mut(), alpha, v, c.rb().subrows(at, v.ncols()));
        }
    }

    /// The columns `range`.
    pub(crate) fn columns(&self, range: Range<usize>) -> Mat<f64> {
        let mut columns = Mat::zeros(self.rows, range.len());
        for (at, v) in self.parts(range) {
            columns.subcols_mut(at, v.ncols()).copy_from(v);
        }
        columns
    }
}
