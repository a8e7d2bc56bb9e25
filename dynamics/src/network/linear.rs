//! Newton matrices of states with integrals: only the block of the states is factorised.
//!
//! ```text
//! I - c J = [ A 0 ]    A x = b,   q = d - B x
//!           [ B I ]
//! ```
//! The integrals depend only on the states, so the last columns are those of the identity.

use diffsol::matrix::dense_nalgebra_serial::NalgebraMat;
use diffsol::{Matrix, MatrixCommon, NalgebraContext, NalgebraVec};
use diffsol_la::error::{LaError, LinearSolverError};
use diffsol_la::{LinearOp, LinearSolver};

/// Factors of the state block and the rows of the integrals.
#[derive(Default)]
pub(crate) struct LedgerLu {
    matrix: Option<NalgebraMat<f64>>,
    factors: Factors,
}

/// The state block by columns, so that every inner loop is a sum of scaled columns.
#[derive(Default)]
struct Factors {
    states: usize,
    lu: Vec<f64>,
    pivot: Vec<usize>,
    /// Entries of B that are not zero: row, column, value.
    below: Vec<(u32, u32, f64)>,
    ready: bool,
}

/// y -= a x
#[inline]
fn subtract(y: &mut [f64], a: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y -= a * x;
    }
}

impl Factors {
    /// Number of columns before the last ones that are those of the identity.
    fn states(matrix: &[f64], size: usize) -> usize {
        let mut states = size;
        while states > 0 {
            let j = states - 1;
            let column = &matrix[j * size..][..size];
            if column[j] != 1.0 || column.iter().enumerate().any(|(i, value)| i != j && *value != 0.0) {
                break;
            }
            states = j;
        }
        states
    }

    /// Gaussian elimination of a column-major matrix's leading block.
    ///
    /// The row of a position reads x' = v: 1 on the diagonal and one other entry. It is its own pivot and leaves that
    /// one column to be changed, where partial pivoting would take the stiffest row and fill the block. The addition to
    /// the velocities' rows is c^2 K/M next to 1 + c C/M, like Newmark's effective mass. All other pivots are partial.
    fn factorise(&mut self, matrix: &[f64], size: usize) {
        let n = Self::states(matrix, size);
        self.states = n;
        self.below.clear();
        self.lu.resize(n * n, 0.0);
        self.pivot.resize(n, 0);
        self.ready = true;
        for (j, column) in matrix.chunks_exact(size).take(n).enumerate() {
            self.lu[j * n..][..n].copy_from_slice(&column[..n]);
            let entries = column[n..].iter().enumerate().filter(|(_, value)| **value != 0.0);
            self.below
                .extend(entries.map(|(i, value)| (i as u32, j as u32, *value)));
        }
        for k in 0..n {
            let (left, right) = self.lu.split_at_mut((k + 1) * n);
            let (earlier, column) = left.split_at_mut(k * n);
            let larger = |best: usize, row: usize| {
                if column[row].abs() > column[best].abs() {
                    row
                } else {
                    best
                }
            };
            let pivot = if column[k] == 1.0 {
                k
            } else {
                (k + 1..n).fold(k, larger)
            };
            self.pivot[k] = pivot;
            column.swap(k, pivot);
            if column[k] == 0.0 || column[k].is_nan() {
                self.ready = false;
                return;
            }
            let scale = 1.0 / column[k];
            column[k + 1..].iter_mut().for_each(|x| *x *= scale);
            for other in right.chunks_exact_mut(n) {
                other.swap(k, pivot);
                if other[k] != 0.0 {
                    let top = other[k];
                    subtract(&mut other[k + 1..], top, &column[k + 1..]);
                }
            }
            // Rows of the part already eliminated move with their pivots.
            if pivot != k {
                earlier.chunks_exact_mut(n).for_each(|column| column.swap(k, pivot));
            }
        }
    }

    fn column(&self, j: usize) -> &[f64] {
        &self.lu[j * self.states..][..self.states]
    }

    fn solve(&self, b: &mut [f64]) {
        let n = self.states;
        let (x, q) = b.split_at_mut(n);
        for k in 0..n {
            x.swap(k, self.pivot[k]);
        }
        for j in 0..n {
            let (head, tail) = x.split_at_mut(j + 1);
            if head[j] != 0.0 {
                subtract(tail, head[j], &self.column(j)[j + 1..]);
            }
        }
        for j in (0..n).rev() {
            x[j] /= self.column(j)[j];
            let (head, tail) = x.split_at_mut(j);
            subtract(head, tail[0], &self.column(j)[..j]);
        }
        for (i, j, value) in &self.below {
            q[*i as usize] -= value * x[*j as usize];
        }
    }

    fn solve_transpose(&self, b: &mut [f64]) {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let n = self.states;
        let (x, q) = b.split_at_mut(n);
        for (i, j, value) in &self.below {
            x[*j as usize] -= value * q[*i as usize];
        }
        for j in 0..n {
            x[j] = (x[j] - dot(&self.column(j)[..j], &x[..j])) / self.column(j)[j];
        }
        for j in (0..n).rev() {
            x[j] -= dot(&self.column(j)[j + 1..], &x[j + 1..]);
        }
        for k in (0..n).rev() {
            x.swap(k, self.pivot[k]);
        }
    }

    fn ready(&self) -> Result<(), LaError> {
        if self.ready {
            Ok(())
        } else {
            Err(LinearSolverError::LuSolveFailed.into())
        }
    }
}

impl LinearSolver<NalgebraMat<f64>> for LedgerLu {
    fn set_linearisation<C>(&mut self, op: &C)
    where
        C: LinearOp<V = NalgebraVec<f64>, T = f64, M = NalgebraMat<f64>, C = NalgebraContext>,
    {
        if let Some(matrix) = &mut self.matrix {
            op.matrix_inplace(matrix);
            self.factors.factorise(matrix.inner().as_slice(), op.nrows());
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
