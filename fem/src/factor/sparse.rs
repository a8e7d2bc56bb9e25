//! Products with symmetric sparse matrices that are stored as lower triangles.

use std::ops::Range;

use faer::prelude::ReborrowMut;
use faer::{Mat, MatMut, MatRef};
use nalgebra_sparse::CscMatrix;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::rows::{Row, Rows, SIDES};
use super::subtrees::{Part, PartRows, Subtrees};
use crate::FemError;

/// Workspace of products.
#[derive(Default)]
pub(crate) struct Room {
    from: Rows,
    to: Rows,
}

/// A X for symmetric A.
pub(crate) fn product(a: &CscMatrix<f64>, x: MatRef<'_, f64>) -> Mat<f64> {
    let mut y = Mat::zeros(a.nrows(), x.ncols());
    product_into(a, x, y.as_mut(), &mut Room::default());
    y
}

/// A x for a single vector; [`product`] would multiply fifteen zero vectors along with it.
pub(crate) fn product_of_vector(a: &CscMatrix<f64>, x: &[f64]) -> Vec<f64> {
    let mut y = vec![0.0; a.nrows()];
    for j in 0..a.ncols() {
        let (diagonal, rows, values) = column(a, j);
        let (x_j, mut y_j) = (x[j], diagonal * x[j]);
        for (&i, value) in rows.iter().zip(values) {
            y_j += value * x[i];
            y[i] += value * x_j;
        }
        y[j] += y_j;
    }
    y
}

/// Y = A X for symmetric A; threads share the blocks of columns.
pub(crate) fn product_into(a: &CscMatrix<f64>, x: MatRef<'_, f64>, mut y: MatMut<'_, f64>, room: &mut Room) {
    let block = |x: MatRef<'_, f64>, y: MatMut<'_, f64>, room: &mut Room| {
        room.from.gather(x);
        room.to.clear(a.nrows());
        Arch::new().dispatch(RowsProduct {
            a,
            x: room.from.as_slice(),
            y: room.to.as_mut_slice(),
        });
        room.to.scatter(y);
    };
    if x.ncols() <= SIDES {
        return block(x, y.rb_mut(), room);
    }
    let blocks = x.par_col_chunks(SIDES).zip(y.par_col_chunks_mut(SIDES));
    blocks.for_each_init(Room::default, |room, (x, y)| block(x, y, room));
}

/// Workspace of products by parts.
#[derive(Default)]
pub(crate) struct PartsRoom {
    pub(crate) from: PartRows,
    to: PartRows,
}

/// A symmetric matrix in the elimination order of `parts`.
pub(crate) struct Split<'a> {
    a: &'a CscMatrix<f64>,
    parts: &'a Subtrees,
    /// For each subtree and the top, the positions of rows that lie beyond the range of their column, in the order of
    /// the columns.
    beyond: Vec<Vec<u32>>,
}

impl<'a> Split<'a> {
    pub(crate) fn new(a: &'a CscMatrix<f64>, parts: &'a Subtrees) -> Self {
        let beyond = parts.subtrees.iter().chain([&parts.top]).map(|part| {
            let columns = part.rows.iter().flat_map(|range| range.clone().map(|j| (j, range.end)));
            let rows = columns.flat_map(|(j, end)| {
                let (_, rows, _) = column(a, j);
                rows[rows.partition_point(|&i| i < end)..].iter()
            });
            rows.map(|&i| part.place(i) as u32).collect()
        });
        Self {
            a,
            parts,
            beyond: beyond.collect(),
        }
    }

    /// Number of rows.
    pub(crate) fn len(&self) -> usize {
        self.a.nrows()
    }

    /// A X.
    pub(crate) fn product(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        let mut y = Mat::zeros(self.a.nrows(), x.ncols());
        self.product_into(x, y.as_mut(), &mut PartsRoom::default());
        y
    }

    /// Y = A X; threads share the subtrees of the columns.
    pub(crate) fn product_into(&self, x: MatRef<'_, f64>, mut y: MatMut<'_, f64>, room: &mut PartsRoom) {
        let parts = self.parts;
        let Subtrees { subtrees, top } = parts;
        let PartsRoom { from, to } = room;
        let (mut from, top_from) = from.split(parts);
        let (mut to, top_to) = to.split(parts);
        for start in (0..x.ncols()).step_by(SIDES) {
            let width = SIDES.min(x.ncols() - start);
            let x = x.subcols(start, width);
            let (own, of_top) = parts.rows_mut(y.rb_mut().subcols_mut(start, width));
            top.gather(top_from, x);
            let reached = &*top_from;
            let split = (subtrees, &self.beyond[..subtrees.len()], &mut from, &mut to, own).into_par_iter();
            let of_subtrees = || {
                split.for_each(|(part, beyond, from, to, y)| {
                    let (own, behind) = from.split_at_mut(part.len());
                    part.gather(own, x);
                    for (to, &at) in behind.iter_mut().zip(&part.reached) {
                        *to = reached[at as usize];
                    }
                    self.multiply(part, beyond, from, to);
                    Row::scatter(&to[..part.len()], y);
                });
            };
            // The top has about as many columns as several subtrees.
            rayon::join(of_subtrees, || {
                self.multiply(top, &self.beyond[subtrees.len()], reached, top_to);
            });
            parts.add_reached(&to, top_to);
            top.scatter(top_to, of_top);
        }
    }

    /// Adds the contributions of a part's columns to its own rows and to the rows it reaches.
    fn multiply(&self, part: &Part, beyond: &[u32], x: &[Row], y: &mut [Row]) {
        y.fill(Row::ZERO);
        let a = self.a;
        Arch::new().dispatch(PartProduct { a, part, beyond, x, y });
    }
}

/// See [`Split::multiply`].
struct PartProduct<'a> {
    a: &'a CscMatrix<f64>,
    part: &'a Part,
    beyond: &'a [u32],
    x: &'a [Row],
    y: &'a mut [Row],
}

impl WithSimd for PartProduct<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self {
            a,
            part,
            mut beyond,
            x,
            y,
        } = self;
        let mut at = 0;
        for Range { start, end } in part.rows.iter().cloned() {
            // A part's own rows are stored contiguously, so their positions differ from their numbers.
            let shift = start - at;
            for j in start..end {
                let own = j - shift;
                let (diagonal, rows, values) = column(a, j);
                // Rows ascend: those in the same range come first, those beyond it follow.
                let inside = match rows.last() {
                    Some(&last) if last >= end => rows.partition_point(|&i| i < end),
                    _ => rows.len(),
                };
                let ((near, far), (values, far_values)) = (rows.split_at(inside), values.split_at(inside));
                multiply_column(simd, (own, diagonal), x, y, near, values, move |i| i - shift);
                if !far.is_empty() {
                    let places;
                    (places, beyond) = beyond.split_at(far.len());
                    multiply_column(simd, (own, 0.0), x, y, places, far_values, |i| i as usize);
                }
            }
            at += end - start;
        }
    }
}

/// Y = A X with the columns of X adjacent in each row, compiled for the vector instructions detected at run time.
struct RowsProduct<'a> {
    a: &'a CscMatrix<f64>,
    x: &'a [Row],
    y: &'a mut [Row],
}

impl WithSimd for RowsProduct<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { a, x, y } = self;
        for j in 0..a.ncols() {
            let (diagonal, rows, values) = column(a, j);
            multiply_column(simd, (j, diagonal), x, y, rows, values, |i| i);
        }
    }
}

/// The diagonal of column j, and the rows and values below it.
#[inline(always)]
fn column(a: &CscMatrix<f64>, j: usize) -> (f64, &[usize], &[f64]) {
    let range = a.col_offsets()[j]..a.col_offsets()[j + 1];
    let (rows, values) = (&a.row_indices()[range.clone()], &a.values()[range]);
    // The diagonal entry, if present, comes first in the column.
    match rows.first() {
        Some(&i) if i == j => (values[0], &rows[1..], &values[1..]),
        _ => (0.0, rows, values),
    }
}

/// y_i += A_ij x_j and y_j += A_ij x_i for the entries of column j, whose row is at `own`; `place` gives the positions
/// of the others.
#[inline(always)]
fn multiply_column<S: Simd, I: Copy>(
    simd: S,
    (own, diagonal): (usize, f64),
    x: &[Row],
    y: &mut [Row],
    rows: &[I],
    values: &[f64],
    place: impl Fn(I) -> usize,
) {
    // One pair of vectors at a time, so that sums and operands stay in registers and the column of A in the cache.
    for h in 0..SIDES / S::F64_LANES / 2 {
        let x_j = x[own].pair::<S>(h);
        let mut y_j = y[own].pair::<S>(h);
        let diagonal = simd.splat_f64s(diagonal);
        for c in 0..2 {
            y_j[c] = simd.mul_add_e_f64s(diagonal, x_j[c], y_j[c]);
        }
        for (&i, &value) in rows.iter().zip(values) {
            let i = place(i);
            let value = simd.splat_f64s(value);
            let x_i = x[i].pair::<S>(h);
            let y_i = &mut y[i].vectors_mut::<S>()[2 * h..2 * h + 2];
            for c in 0..2 {
                y_j[c] = simd.mul_add_e_f64s(value, x_i[c], y_j[c]);
                y_i[c] = simd.mul_add_e_f64s(value, x_j[c], y_i[c]);
            }
        }
        y[own].vectors_mut::<S>()[2 * h..2 * h + 2].copy_from_slice(&y_j);
    }
}

/// A -= sigma M, where the pattern of A contains that of M.
pub(crate) fn subtract(a: &mut CscMatrix<f64>, sigma: f64, m: &CscMatrix<f64>) {
    for (j, column) in m.col_iter().enumerate() {
        let mut target = a.col_mut(j);
        let (rows, values) = target.rows_and_values_mut();
        let mut place = 0;
        for (&i, &value) in column.row_indices().iter().zip(column.values()) {
            // Rows ascend in both matrices, so one sweep finds every entry of M.
            while rows[place] < i {
                place += 1;
            }
            values[place] -= sigma * value;
        }
    }
}

/// The lower triangle of a symmetric A after renumbering unknown e to `place(e)`.
pub(crate) fn reordered(a: &CscMatrix<f64>, place: impl Fn(usize) -> usize) -> Result<CscMatrix<f64>, FemError> {
    let n = a.nrows();
    let places: Vec<usize> = (0..n).map(place).collect();
    u32::try_from(n).map_err(|_| FemError::TooLarge { dofs: n })?;
    // Sorted first by rows, then by columns, so that the rows of a column are ascending.
    let ends = |i: usize, j: usize| (places[i].max(places[j]), places[i].min(places[j]));
    let by_row = starts(n, a.triplet_iter().map(|(i, j, _)| ends(i, j).0));
    let mut next = by_row.clone();
    let mut entries = vec![(0_u32, 0.0); a.nnz()];
    for (i, j, &value) in a.triplet_iter() {
        let (row, column) = ends(i, j);
        entries[next[row]] = (column as u32, value);
        next[row] += 1;
    }
    let offsets = starts(n, entries.iter().map(|&(column, _)| column as usize));
    next.copy_from_slice(&offsets);
    let (mut rows, mut values) = (vec![0; entries.len()], vec![0.0; entries.len()]);
    for (row, range) in by_row.windows(2).enumerate() {
        for &(column, value) in &entries[range[0]..range[1]] {
            let at = &mut next[column as usize];
            (rows[*at], values[*at]) = (row, value);
            *at += 1;
        }
    }
    drop(entries);
    CscMatrix::try_from_csc_data(n, n, offsets, rows, values).map_err(|e| FemError::Order { reason: e.to_string() })
}

/// Start of the entries of each of `n` keys after sorting by key, followed by the end of the last ones.
fn starts(n: usize, keys: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut starts = vec![0; n + 1];
    keys.for_each(|key| starts[key + 1] += 1);
    for key in 0..n {
        starts[key + 1] += starts[key];
    }
    starts
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The lower triangle of a band matrix.
    fn band(n: usize) -> CscMatrix<f64> {
        let column = |j: usize| j..(j + 4).min(n);
        let mut offsets = vec![0];
        (0..n).for_each(|j| offsets.push(offsets[j] + column(j).len()));
        let rows: Vec<usize> = (0..n).flat_map(column).collect();
        let values = (0..rows.len()).map(|k| (k as f64).sin()).collect();
        CscMatrix::try_from_csc_data(n, n, offsets, rows, values).unwrap()
    }

    fn full(a: &CscMatrix<f64>) -> Mat<f64> {
        let mut full = Mat::zeros(a.nrows(), a.nrows());
        for (i, j, &value) in a.triplet_iter() {
            full[(i, j)] = value;
            full[(j, i)] = value;
        }
        full
    }

    #[test]
    fn product_is_that_of_the_full_matrix() {
        let a = band(50);
        let x = Mat::from_fn(50, 21, |i, j| ((i + 3 * j) as f64).cos());
        assert!((product(&a, x.as_ref()) - full(&a) * &x).norm_max() < 1e-13);
        let one: Vec<f64> = x.col(3).iter().copied().collect();
        let y = product_of_vector(&a, &one);
        let expected = full(&a) * x.subcols(3, 1);
        assert!(y.iter().enumerate().all(|(i, y)| (y - expected[(i, 0)]).abs() < 1e-13));
    }

    #[test]
    fn reordered_matrix_has_each_entry_at_its_new_place() {
        let (a, place) = (band(50), |e: usize| 7 * e % 50);
        let (before, after) = (full(&a), full(&reordered(&a, place).unwrap()));
        assert_eq!(after, Mat::from_fn(50, 50, |i, j| before[(43 * i % 50, 43 * j % 50)]));
    }

    #[test]
    fn shift_is_subtracted_where_the_mass_has_entries() {
        let (a, m) = (band(20), band(20));
        let mut shifted = a.clone();
        subtract(&mut shifted, 0.25, &m);
        assert!((full(&shifted) - faer::Scale(0.75) * full(&a)).norm_max() < 1e-15);
    }
}
