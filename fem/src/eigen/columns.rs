//! A tall matrix that can grow by columns.

use std::ops::Range;

use faer::linalg::matmul::matmul;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;

use super::dense::{ROWS, add_product, transpose_product};

/// Number of columns allocated at a time.
const PIECE: usize = 128;

/// V in pieces of [`PIECE`] columns, so that it can grow without being copied and without unused memory.
pub(crate) struct Columns {
    rows: usize,
    /// The system provides zeroed memory. Its pages are touched only when a column is written, by all threads, because
    /// page faults are slower than the copy.
    pieces: Vec<Vec<f64>>,
}

impl Columns {
    pub(crate) fn new(rows: usize) -> Self {
        Self {
            rows,
            pieces: Vec::new(),
        }
    }

    /// Writes a block, starting at column `start`.
    pub(crate) fn put(&mut self, start: usize, block: MatRef<'_, f64>) {
        while self.pieces.len() * PIECE < start + block.ncols() {
            self.pieces.push(vec![0.0; self.rows * PIECE]);
        }
        let mut from = 0;
        while from < block.ncols() {
            let (piece, at) = ((start + from) / PIECE, (start + from) % PIECE);
            let width = (PIECE - at).min(block.ncols() - from);
            let to = &mut self.pieces[piece][at * self.rows..(at + width) * self.rows];
            copy(block.subcols(from, width), to);
            from += width;
        }
    }

    /// The columns `range` of one piece.
    fn of_piece(&self, piece: usize, range: Range<usize>) -> MatRef<'_, f64> {
        let values = &self.pieces[piece][range.start * self.rows..range.end * self.rows];
        MatRef::from_column_major_slice(values, self.rows, range.len())
    }

    /// The contiguous parts of `range`, with their offsets in the range.
    fn parts(&self, range: Range<usize>) -> impl Iterator<Item = (usize, MatRef<'_, f64>)> {
        let pieces = range.start / PIECE..range.end.div_ceil(PIECE);
        pieces.map(move |p| {
            let (start, end) = (range.start.max(p * PIECE), range.end.min((p + 1) * PIECE));
            (
                start - range.start,
                self.of_piece(p, start - p * PIECE..end - p * PIECE),
            )
        })
    }

    /// V^T Z, for the columns `range` of V.
    pub(crate) fn transpose_product(&self, range: Range<usize>, z: MatRef<'_, f64>) -> Mat<f64> {
        let mut c = Mat::zeros(range.len(), z.ncols());
        for (at, v) in self.parts(range) {
            let part = transpose_product(v, z);
            c.subrows_mut(at, v.ncols()).copy_from(&part);
        }
        c
    }

    /// W += alpha V C, for the columns `range` of V.
    pub(crate) fn add_product(&self, range: Range<usize>, mut w: MatMut<'_, f64>, alpha: f64, c: MatRef<'_, f64>) {
        for (at, v) in self.parts(range) {
            add_product(w.rb_mut(), alpha, v, c.rb().subrows(at, v.ncols()));
        }
    }

    /// V S, for the first columns of V. Rows are replaced in place piece by piece, and V is freed while its columns are
    /// copied, so that the product needs little additional memory.
    pub(crate) fn into_product(mut self, s: MatRef<'_, f64>) -> Mat<f64> {
        let parts: Vec<Range<usize>> = (0..s.nrows())
            .step_by(PIECE)
            .map(|start| start..(start + PIECE).min(s.nrows()))
            .collect();
        let rows = self.rows;
        // Groups of rows that are contiguous in all pieces.
        let mut chunks: Vec<Vec<MatMut<'_, f64>>> = (0..rows.div_ceil(ROWS)).map(|_| Vec::new()).collect();
        for piece in &mut self.pieces {
            let mut rest = MatMut::from_column_major_slice_mut(piece, rows, PIECE);
            for chunk in &mut chunks {
                let height = ROWS.min(rest.nrows());
                let (own, behind) = rest.split_at_row_mut(height);
                chunk.push(own);
                rest = behind;
            }
        }
        chunks.into_par_iter().for_each(|mut pieces| {
            let mut y = Mat::zeros(pieces.first().map_or(0, |piece| piece.nrows()), s.ncols());
            for (v, part) in pieces.iter().zip(&parts) {
                let (v, s) = (v.rb().subcols(0, part.len()), s.subrows(part.start, part.len()));
                matmul(y.as_mut(), Accum::Add, v, s, 1.0, Par::Seq);
            }
            for (piece, first) in pieces.iter_mut().zip((0..s.ncols()).step_by(PIECE)) {
                let width = PIECE.min(s.ncols() - first);
                let mut to = piece.rb_mut().subcols_mut(0, width);
                to.copy_from(y.subcols(first, width));
            }
        });
        self.pieces.truncate(s.ncols().div_ceil(PIECE));
        let mut product = Mat::with_capacity(rows, s.ncols());
        for (piece, first) in self.pieces.drain(..).zip((0..s.ncols()).step_by(PIECE)) {
            let width = PIECE.min(s.ncols() - first);
            product.resize_with(rows, first + width, |i, j| piece[(j - first) * rows + i]);
        }
        product
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

/// Copies columns to contiguous memory, in parallel.
fn copy(from: MatRef<'_, f64>, to: &mut [f64]) {
    let columns = to.par_chunks_mut(from.nrows().max(1)).enumerate();
    columns.for_each(|(j, to)| {
        let from = from.col(j);
        match from.try_as_col_major() {
            Some(from) => to.copy_from_slice(from.as_slice()),
            None => to.iter_mut().zip(from.iter()).for_each(|(to, from)| *to = *from),
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tall(columns: usize) -> Mat<f64> {
        Mat::from_fn(500, columns, |i, j| ((2 * i + 3 * j) as f64).sin())
    }

    #[test]
    fn blocks_across_pieces_multiply_as_one_matrix() {
        let whole = tall(300);
        let mut v = Columns::new(500);
        for start in (0..300).step_by(20) {
            v.put(start, whole.subcols(start, 20));
        }
        let range = 110..270;
        let part = whole.subcols(range.start, range.len());
        assert_eq!(v.columns(range.clone()), part.to_owned());
        let z = tall(4);
        let c = v.transpose_product(range.clone(), z.as_ref());
        assert!((part.transpose() * &z - &c).norm_max() < 1e-12);
        let mut w = z.clone();
        v.add_product(range, w.as_mut(), -1.0, c.as_ref());
        assert!((&z - part * &c - &w).norm_max() < 1e-9);
        let s = Mat::from_fn(300, 150, |i, j| ((i + 7 * j) as f64).cos());
        assert!((&whole * &s - v.into_product(s.as_ref())).norm_max() < 1e-9);
    }
}
