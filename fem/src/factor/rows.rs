//! Blocks of vectors with the values of one unknown side by side, as the kernels of solves and sparse products read
//! them.

use faer::{MatMut, MatRef};
use pulp::Simd;

/// Vectors of a block.
pub(crate) const SIDES: usize = 16;

/// Rows of a tile that is transposed within the first cache.
const TILE: usize = 32;

/// The values of one unknown in all vectors of a block, two cache lines.
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

    /// Multiplies it.
    pub(crate) fn scale(&mut self, factor: f64) {
        self.0.iter_mut().for_each(|x| *x *= factor);
    }

    /// Takes over up to [`SIDES`] columns; the other sides become zero.
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

    /// Gives the first columns back.
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

/// Room for one block, reused from one product to the next: its pages are as large as the vectors, and to ask the
/// system for them anew costs as much as to transpose a block.
#[derive(Default)]
pub(crate) struct Rows(Vec<Row>);

impl Rows {
    /// Takes over up to [`SIDES`] columns; the other sides are zero.
    pub(crate) fn gather(&mut self, x: MatRef<'_, f64>) {
        self.resize(x.nrows());
        Row::gather(&mut self.0, x);
    }

    /// Gives the first columns back.
    pub(crate) fn scatter(&self, x: MatMut<'_, f64>) {
        Row::scatter(&self.0, x);
    }

    /// Changes the number of rows to `n`; the first rows stay.
    pub(crate) fn resize(&mut self, n: usize) {
        self.0.resize(n, Row::ZERO);
    }

    /// Makes it `n` rows of zeros.
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
