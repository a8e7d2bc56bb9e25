//! Products with symmetric sparse matrices of which the lower triangle is stored.

use faer::{Mat, MatRef};
use nalgebra_sparse::CscMatrix;
use pulp::{Arch, Simd, WithSimd};

/// Columns multiplied at once; a row of so many stands together in memory.
const WIDTH: usize = 16;

/// A X for symmetric A.
pub(crate) fn product(a: &CscMatrix<f64>, x: MatRef<'_, f64>) -> Mat<f64> {
    let n = a.nrows();
    let mut y = Mat::zeros(n, x.ncols());
    let mut from = vec![[0.0; WIDTH]; n];
    let mut to = vec![[0.0; WIDTH]; n];
    for start in (0..x.ncols()).step_by(WIDTH) {
        let width = WIDTH.min(x.ncols() - start);
        for c in 0..width {
            let column = x.col(start + c);
            for (row, value) in from.iter_mut().zip(column.iter()) {
                row[c] = *value;
            }
        }
        to.fill([0.0; WIDTH]);
        Arch::new().dispatch(RowsProduct {
            a,
            x: &from,
            y: &mut to,
        });
        for c in 0..width {
            for (value, row) in y.col_mut(start + c).iter_mut().zip(&to) {
                *value = row[c];
            }
        }
    }
    y
}

/// Y = A X with the columns of X side by side in each row, compiled for the vector instructions found at run time.
struct RowsProduct<'a> {
    a: &'a CscMatrix<f64>,
    x: &'a [[f64; WIDTH]],
    y: &'a mut [[f64; WIDTH]],
}

impl WithSimd for RowsProduct<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { a, x, y } = self;
        let (offsets, rows, values) = (a.col_offsets(), a.row_indices(), a.values());
        let row = WIDTH / S::F64_LANES;
        let x = S::as_simd_f64s(x.as_flattened()).0;
        let y = S::as_mut_simd_f64s(y.as_flattened_mut()).0;
        for (j, range) in offsets.windows(2).enumerate() {
            let (rows, values) = (&rows[range[0]..range[1]], &values[range[0]..range[1]]);
            // A pair of vectors at a time: sums and operands stay in registers, and the column of A in the cache.
            for pair in (0..row).step_by(2) {
                let at = |i: usize| i * row + pair;
                let x_j = [x[at(j)], x[at(j) + 1]];
                let mut y_j = [y[at(j)], y[at(j) + 1]];
                for (&i, &value) in rows.iter().zip(values) {
                    let value = simd.splat_f64s(value);
                    for c in 0..2 {
                        y_j[c] = simd.mul_add_e_f64s(value, x[at(i) + c], y_j[c]);
                        if i != j {
                            y[at(i) + c] = simd.mul_add_e_f64s(value, x_j[c], y[at(i) + c]);
                        }
                    }
                }
                y[at(j)] = y_j[0];
                y[at(j) + 1] = y_j[1];
            }
        }
    }
}

/// K - sigma M on the pattern of K, which holds that of M.
pub(crate) fn shifted(k: &CscMatrix<f64>, m: &CscMatrix<f64>, sigma: f64) -> CscMatrix<f64> {
    let mut a = k.clone();
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
    a
}
