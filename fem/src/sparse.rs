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
    fn with_simd<S: Simd>(self, _: S) {
        let Self { a, x, y } = self;
        let (offsets, rows, values) = (a.col_offsets(), a.row_indices(), a.values());
        for (j, range) in offsets.windows(2).enumerate() {
            let x_j = x[j];
            let mut y_j = y[j];
            let (rows, values) = (&rows[range[0]..range[1]], &values[range[0]..range[1]]);
            for (&i, &value) in rows.iter().zip(values) {
                if i == j {
                    for c in 0..WIDTH {
                        y_j[c] += value * x_j[c];
                    }
                } else {
                    let (x_i, y_i) = (&x[i], &mut y[i]);
                    for c in 0..WIDTH {
                        y_j[c] += value * x_i[c];
                        y_i[c] += value * x_j[c];
                    }
                }
            }
            y[j] = y_j;
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
