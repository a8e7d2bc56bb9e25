//! Products with symmetric sparse matrices of which the lower triangle is stored.

use faer::prelude::ReborrowMut;
use faer::{Mat, MatMut, MatRef};
use nalgebra_sparse::CscMatrix;
use pulp::{Arch, Simd, WithSimd};

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
