//! Blocks of vectors. The values of one unknown are adjacent, as required by the kernels for solves and sparse
//! products.

use faer::{MatMut, MatRef};
use pulp::Simd;

/// Number of vectors in a block.
pub(crate) const SIDES: usize = 16;

/// Number of rows in a tile that is transposed within the L1 cache.
const TILE: usize = 32;

/// The values of one unknown in all vectors of a block; two cache lines.
#[derive(Clone, Copy)]
#[repr(align(128))]
pub(crate) struct Row([f64; SIDES]);

impl Row {
    pub(crate) const ZERO: Self = Self([0.0; SIDES]);

    #[inline(always)]
    pub(crate) fn vectors<S: Simd>(&self) -> &[S::f64s] {
        S::as_simd_f64s(&self.0).0
    }

    #[inline(always)]
    pub(crate) fn vectors_mut<S: Simd>(&mut self) -> &mut [S::f64s] {
        S::as_mut_simd_f64s(&mut self.0).0
    }

    /// Adds another row.
    pub(crate) fn add(&mut self, other: &Self) {
        self.0.iter_mut().zip(&other.0).for_each(|(x, y)| *x += y);
    }

    /// Subtracts another row.
    pub(crate) fn subtract(&mut self, other: &Self) {
        self.0.iter_mut().zip(&other.0).for_each(|(x, y)| *x -= y);
    }

    /// Multiplies it by a factor.
    pub(crate) fn scale(&mut self, factor: f64) {
        self.0.iter_mut().for_each(|x| *x *= factor);
    }

    /// Copies up to [`SIDES`] columns; the remaining vectors become zero.
    pub(crate) fn gather(rows: &mut [Self], x: MatRef<'_, f64>) {
        for (t, tile) in rows.chunks_mut(TILE).enumerate() {
            let x = x.subrows(t * TILE, tile.len());
            for c in 0..x.ncols() {
                for (row, value) in tile.iter_mut().zip(x.col(c).iter()) {
                    row.0[c] = *value;
                }
            }
            if x.ncols() < SIDES {
                tile.iter_mut().for_each(|row| row.0[x.ncols()..].fill(0.0));
            }
        }
    }

    /// Copies the first columns back.
    pub(crate) fn scatter(rows: &[Self], mut x: MatMut<'_, f64>) {
        for (t, tile) in rows.chunks(TILE).enumerate() {
            let mut x = x.as_mut().subrows_mut(t * TILE, tile.len());
            for c in 0..x.ncols() {
                for (value, row) in x.as_mut().col_mut(c).iter_mut().zip(tile) {
                    *value = row.0[c];
                }
            }
        }
    }

    /// Vectors 2 `h` and 2 `h` + 1.
    #[inline(always)]
    pub(crate) fn pair<S: Simd>(&self, h: usize) -> [S::f64s; 2] {
        let vectors = self.vectors::<S>();
        [vectors[2 * h], vectors[2 * h + 1]]
    }
}

/// Storage for one block, reused between products: requesting its pages from the system each time would take as long as
/// transposing a block.
#[derive(Default)]
pub(crate) struct Rows(Vec<Row>);

impl Rows {
    /// Copies up to [`SIDES`] columns; the remaining vectors are zero.
    pub(crate) fn gather(&mut self, x: MatRef<'_, f64>) {
        self.resize(x.nrows());
        Row::gather(&mut self.0, x);
    }

    /// Copies the first columns back.
    pub(crate) fn scatter(&self, x: MatMut<'_, f64>) {
        Row::scatter(&self.0, x);
    }

    /// Changes the number of rows to `n`; the first rows are retained.
    pub(crate) fn resize(&mut self, n: usize) {
        self.0.resize(n, Row::ZERO);
    }

    /// Resets it to `n` rows of zeros.
    pub(crate) fn clear(&mut self, n: usize) {
        self.0.clear();
        self.0.resize(n, Row::ZERO);
    }

    pub(crate) fn as_slice(&self) -> &[Row] {
        &self.0
    }

    pub(crate) fn as_mut_slice(&mut self) -> &mut [Row] {
        &mut self.0
    }
}
