//! Products with symmetric sparse matrices of which the lower triangle is stored.

use faer::prelude::ReborrowMut;
use faer::{Mat, MatMut, MatRef};
use nalgebra_sparse::CscMatrix;
use pulp::{Arch, Simd, WithSimd};

use crate::FemError;
use crate::rows::{Row, Rows, SIDES};

/// Room that products work in.
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

/// Y = A X for symmetric A.
pub(crate) fn product_into(a: &CscMatrix<f64>, x: MatRef<'_, f64>, mut y: MatMut<'_, f64>, room: &mut Room) {
    for start in (0..x.ncols()).step_by(SIDES) {
        let width = SIDES.min(x.ncols() - start);
        room.from.gather(x.subcols(start, width));
        room.to.clear(a.nrows());
        Arch::new().dispatch(RowsProduct {
            a,
            x: room.from.as_slice(),
            y: room.to.as_mut_slice(),
        });
        room.to.scatter(y.rb_mut().subcols_mut(start, width));
    }
}

/// Y = A X with the columns of X side by side in each row, compiled for the vector instructions found at run time.
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
        let (offsets, rows, values) = (a.col_offsets(), a.row_indices(), a.values());
        for (j, range) in offsets.windows(2).enumerate() {
            // The diagonal, where there is one, opens the column.
            let own = usize::from(range[0] < range[1] && rows[range[0]] == j);
            let diagonal = if own == 1 { values[range[0]] } else { 0.0 };
            let (rows, values) = (&rows[range[0] + own..range[1]], &values[range[0] + own..range[1]]);
            // A pair of vectors at a time: sums and operands stay in registers, and the column of A in the cache.
            for h in 0..SIDES / S::F64_LANES / 2 {
                let x_j = x[j].pair::<S>(h);
                let mut y_j = y[j].pair::<S>(h);
                let diagonal = simd.splat_f64s(diagonal);
                for c in 0..2 {
                    y_j[c] = simd.mul_add_e_f64s(diagonal, x_j[c], y_j[c]);
                }
                for (&i, &value) in rows.iter().zip(values) {
                    let value = simd.splat_f64s(value);
                    let x_i = x[i].pair::<S>(h);
                    let y_i = &mut y[i].vectors_mut::<S>()[2 * h..2 * h + 2];
                    for c in 0..2 {
                        y_j[c] = simd.mul_add_e_f64s(value, x_i[c], y_j[c]);
                        y_i[c] = simd.mul_add_e_f64s(value, x_j[c], y_i[c]);
                    }
                }
                y[j].vectors_mut::<S>()[2 * h..2 * h + 2].copy_from_slice(&y_j);
            }
        }
    }
}

/// A -= sigma M on the pattern of A, which holds that of M.
pub(crate) fn subtract(a: &mut CscMatrix<f64>, sigma: f64, m: &CscMatrix<f64>) {
    for (j, column) in m.col_iter().enumerate() {
        let mut target = a.col_mut(j);
        let (rows, values) = target.rows_and_values_mut();
        let mut place = 0;
        for (&i, &value) in column.row_indices().iter().zip(column.values()) {
            // Rows ascend in both, so one sweep meets every entry of M.
            while rows[place] < i {
                place += 1;
            }
            values[place] -= sigma * value;
        }
    }
}

/// The lower triangle of a symmetric A whose unknown e becomes number `place(e)`.
pub(crate) fn reordered(a: &CscMatrix<f64>, place: impl Fn(usize) -> usize) -> Result<CscMatrix<f64>, FemError> {
    let n = a.nrows();
    let places: Vec<usize> = (0..n).map(place).collect();
    // First by rows, then by columns: the rows of a column come in ascending order.
    let entries = a.triplet_iter().map(|(i, j, &value)| {
        let (p, q) = (places[i], places[j]);
        (p.max(q), (p.min(q), value))
    });
    let (offsets, by_rows) = buckets(n, entries);
    let entries = offsets.windows(2).enumerate().flat_map(|(row, range)| {
        let entries = &by_rows[range[0]..range[1]];
        entries.iter().map(move |&(column, value)| (column, (row, value)))
    });
    let (offsets, by_columns) = buckets(n, entries);
    let (rows, values) = by_columns.into_iter().unzip();
    CscMatrix::try_from_csc_data(n, n, offsets, rows, values).map_err(|e| FemError::Order { reason: e.to_string() })
}

/// What comes with each of `n` keys, in the order of the keys and for each as it comes.
fn buckets<T: Copy + Default>(n: usize, entries: impl Iterator<Item = (usize, T)> + Clone) -> (Vec<usize>, Vec<T>) {
    let mut offsets = vec![0; n + 1];
    entries.clone().for_each(|(key, _)| offsets[key + 1] += 1);
    for key in 0..n {
        offsets[key + 1] += offsets[key];
    }
    let mut next = offsets.clone();
    let mut sorted = vec![T::default(); offsets[n]];
    for (key, entry) in entries {
        sorted[next[key]] = entry;
        next[key] += 1;
    }
    (offsets, sorted)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A band of the lower triangle.
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
