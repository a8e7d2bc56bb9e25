//! Newton matrices of states with integrals, of which only the state block is factorised.
//!
//! ```text
//! I - c J = [ A 0 ]    A x = b,   q = d - B x
//!           [ B I ]
//! ```
//! The integrals depend only on the states, so their columns are those of the identity. Halving the size of the matrix
//! reduces the work to an eighth.

use diffsol::matrix::dense_nalgebra_serial::NalgebraMat;
use diffsol::{Matrix, MatrixCommon, NalgebraContext, NalgebraVec};
use diffsol_la::error::{LaError, LinearSolverError};
use diffsol_la::{LinearOp, LinearSolver};

use super::state::{BODIES, INTEGRALS, SIZE, STATES};

/// Factors of the state block and the rows of the integrals.
#[derive(Default)]
pub(crate) struct BlockLu {
    matrix: Option<NalgebraMat<f64>>,
    factors: Box<Factors>,
}

/// The state block by columns, so that every inner loop adds scaled columns.
struct Factors {
    lu: [[f64; STATES]; STATES],
    pivot: [usize; STATES],
    /// Nonzero entries of B: row, column, value.
    below: Vec<(u32, u32, f64)>,
    singular: bool,
}

impl Default for Factors {
    fn default() -> Self {
        Self {
            lu: [[0.0; STATES]; STATES],
            pivot: [0; STATES],
            below: Vec::with_capacity(INTEGRALS * STATES),
            singular: true,
        }
    }
}

/// Whether a state is the position of a body.
fn is_position(state: usize) -> bool {
    state < 2 * BODIES && state.is_multiple_of(2)
}

/// y -= a x
#[inline]
fn subtract(y: &mut [f64], a: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y -= a * x;
    }
}

impl Factors {
    /// Gaussian elimination of the leading block of a column-major matrix.
    ///
    /// The row of a position is x' = v, with 1 on the diagonal and one other entry. It is its own pivot, so only that
    /// one column changes; partial pivoting would choose the stiffest row and fill the block. It adds c^2 K/M to 1 + c
    /// C/M in the rows of the velocities, like Newmark's effective mass. All other rows are pivoted partially.
    fn factorise(&mut self, matrix: &[f64]) {
        self.below.clear();
        for (j, column) in matrix.chunks_exact(SIZE).take(STATES).enumerate() {
            self.lu[j].copy_from_slice(&column[..STATES]);
            let entries = column[STATES..].iter().enumerate().filter(|(_, value)| **value != 0.0);
            self.below
                .extend(entries.map(|(i, value)| (i as u32, j as u32, *value)));
        }
        self.singular = false;
        for k in 0..STATES {
            let (left, right) = self.lu.split_at_mut(k + 1);
            let column = &mut left[k];
            let larger = |best: usize, row: usize| {
                if column[row].abs() > column[best].abs() {
                    row
                } else {
                    best
                }
            };
            let pivot = if is_position(k) && column[k] == 1.0 {
                k
            } else {
                (k + 1..STATES).fold(k, larger)
            };
            self.pivot[k] = pivot;
            column.swap(k, pivot);
            if column[k] == 0.0 || column[k].is_nan() {
                self.singular = true;
                return;
            }
            let scale = 1.0 / column[k];
            column[k + 1..].iter_mut().for_each(|x| *x *= scale);
            for other in right {
                other.swap(k, pivot);
                if other[k] != 0.0 {
                    let top = other[k];
                    subtract(&mut other[k + 1..], top, &column[k + 1..]);
                }
            }
            // Rows of the eliminated part move with their pivots.
            if pivot != k {
                left[..k].iter_mut().for_each(|earlier| earlier.swap(k, pivot));
            }
        }
    }

    fn solve(&self, b: &mut [f64]) {
        let (x, q) = b.split_at_mut(STATES);
        for k in 0..STATES {
            x.swap(k, self.pivot[k]);
        }
        for j in 0..STATES {
            let (head, tail) = x.split_at_mut(j + 1);
            subtract(tail, head[j], &self.lu[j][j + 1..]);
        }
        for j in (0..STATES).rev() {
            x[j] /= self.lu[j][j];
            let (head, tail) = x.split_at_mut(j);
            subtract(head, tail[0], &self.lu[j][..j]);
        }
        for (i, j, value) in &self.below {
            q[*i as usize] -= value * x[*j as usize];
        }
    }

    fn solve_transpose(&self, b: &mut [f64]) {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (x, q) = b.split_at_mut(STATES);
        for (i, j, value) in &self.below {
            x[*j as usize] -= value * q[*i as usize];
        }
        for j in 0..STATES {
            x[j] = (x[j] - dot(&self.lu[j][..j], &x[..j])) / self.lu[j][j];
        }
        for j in (0..STATES).rev() {
            x[j] -= dot(&self.lu[j][j + 1..], &x[j + 1..]);
        }
        for k in (0..STATES).rev() {
            x.swap(k, self.pivot[k]);
        }
    }

    fn ready(&self) -> Result<(), LaError> {
        if self.singular {
            Err(LinearSolverError::LuSolveFailed.into())
        } else {
            Ok(())
        }
    }
}

impl LinearSolver<NalgebraMat<f64>> for BlockLu {
    fn set_linearisation<C>(&mut self, op: &C)
    where
        C: LinearOp<V = NalgebraVec<f64>, T = f64, M = NalgebraMat<f64>, C = NalgebraContext>,
    {
        if let Some(matrix) = &mut self.matrix {
            op.matrix_inplace(matrix);
            self.factors.factorise(matrix.inner().as_slice());
        }
    }

    fn set_sparsity<C>(&mut self, op: &C)
    where
        C: LinearOp<V = NalgebraVec<f64>, T = f64, M = NalgebraMat<f64>, C = NalgebraContext>,
    {
        self.matrix = Some(NalgebraMat::new_from_sparsity(
            op.nrows(),
            op.ncols(),
            op.sparsity(),
            *op.context(),
        ));
    }

    fn solve_in_place(&self, b: &mut NalgebraVec<f64>) -> Result<(), LaError> {
        self.factors.ready()?;
        self.factors.solve(b.batch_as_mut_slice(0));
        Ok(())
    }

    fn solve_transpose_in_place(&self, b: &mut NalgebraVec<f64>) -> Result<(), LaError> {
        self.factors.ready()?;
        self.factors.solve_transpose(b.batch_as_mut_slice(0));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A column-major matrix of this block form with entries that need pivoting.
    fn matrix() -> Vec<f64> {
        let mut seed = 1u64;
        let mut random = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let mut a = vec![0.0; SIZE * SIZE];
        for j in 0..SIZE {
            for i in 0..SIZE {
                a[j * SIZE + i] = if j < STATES {
                    random()
                } else {
                    f64::from(u8::from(i == j))
                };
            }
        }
        a[0] = 1e-12;
        a
    }

    /// The same with rows of positions as in a Newton matrix, next to a stiff contact.
    fn newton_matrix() -> Vec<f64> {
        let (mut a, step) = (matrix(), 1e-5);
        for body in 0..BODIES {
            let (y, v) = (2 * body, 2 * body + 1);
            for j in 0..STATES {
                a[j * SIZE + y] = 0.0;
            }
            a[y * SIZE + y] = 1.0;
            a[v * SIZE + y] = -step;
            a[y * SIZE + v] = step * 1e8 * (1 + body) as f64;
            a[v * SIZE + v] = 1.0;
        }
        a
    }

    #[test]
    fn solutions_satisfy_the_system_and_its_transpose() {
        for a in [matrix(), newton_matrix()] {
            let mut factors = Factors::default();
            factors.factorise(&a);
            let right: Vec<f64> = (0..SIZE).map(|i| 1.0 + (i as f64).sin()).collect();
            let (mut x, mut xt) = (right.clone(), right.clone());
            factors.solve(&mut x);
            factors.solve_transpose(&mut xt);
            for (transpose, x) in [(false, &x), (true, &xt)] {
                let entry = |i: usize, j: usize| if transpose { a[i * SIZE + j] } else { a[j * SIZE + i] };
                for (i, right) in right.iter().enumerate() {
                    let terms: Vec<f64> = (0..SIZE).map(|j| entry(i, j) * x[j]).collect();
                    let size = terms.iter().map(|term| term.abs()).sum::<f64>();
                    let residual = (terms.iter().sum::<f64>() - right).abs();
                    assert!(residual <= 1e-13 * size, "{i} {transpose}: {residual} of {size}");
                }
            }
        }
    }

    #[test]
    fn a_singular_matrix_is_an_error() {
        let mut factors = Factors::default();
        assert!(factors.ready().is_err());
        factors.factorise(&vec![0.0; SIZE * SIZE]);
        assert!(factors.ready().is_err());
        factors.factorise(&vec![f64::NAN; SIZE * SIZE]);
        assert!(factors.ready().is_err());
    }
}
