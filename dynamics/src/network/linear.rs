//! Newton matrices of states with integrals. Only the state block is factorised.
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

/// The state block by columns, with lists of nonzero entries for the solution.
#[derive(Default)]
struct Factors {
    states: usize,
    lu: Vec<f64>,
    pivot: Vec<usize>,
    /// Reciprocals of the diagonal of U.
    inverse: Vec<f64>,
    /// Entries of L below the diagonal and of U above it, by columns, and the ends of the columns.
    lower: Vec<Entry>,
    upper: Vec<Entry>,
    lower_end: Vec<usize>,
    upper_end: Vec<usize>,
    /// Entries of B: row, column, value.
    below: Vec<(u32, u32, f64)>,
    ready: bool,
}

/// An entry of a column.
#[derive(Clone, Copy)]
struct Entry {
    row: u32,
    value: f64,
}

/// Nonzero entries of a column from a given row onwards.
fn entries(column: &[f64], from: usize) -> impl Iterator<Item = Entry> {
    column
        .iter()
        .enumerate()
        .filter(|(_, value)| **value != 0.0)
        .map(move |(i, value)| Entry {
            row: (from + i) as u32,
            value: *value,
        })
}

/// y -= a x
#[inline]
fn subtract(y: &mut [f64], a: f64, x: &[Entry]) {
    for entry in x {
        y[entry.row as usize] -= a * entry.value;
    }
}

impl Factors {
    /// Number of columns that precede the trailing identity columns.
    fn states(matrix: &[f64], size: usize) -> usize {
        let mut states = size;
        while states > 0 {
            let j = states - 1;
            let column = &matrix[j * size..][..size];
            let (head, tail) = column.split_at(j);
            // Without an early exit, which would prevent vector instructions; the shift drops the sign.
            let is_zero = |x: &[f64]| x.iter().fold(0, |bits, value| bits | value.to_bits() << 1) == 0;
            if column[j] != 1.0 || !is_zero(head) || !is_zero(&tail[1..]) {
                break;
            }
            states = j;
        }
        states
    }

    /// Gaussian elimination of the leading block of a column-major matrix.
    ///
    /// The row of a position is x' = v, with 1 on the diagonal and one other entry. It is its own pivot, so only that
    /// one column changes; partial pivoting would choose the stiffest row and fill the block. It adds c^2 K/M to 1 + c
    /// C/M in the rows of the velocities, like Newmark's effective mass. All other rows are pivoted partially.
    fn factorise(&mut self, matrix: &[f64], size: usize) {
        let n = Self::states(matrix, size);
        self.states = n;
        self.ready = false;
        self.below.clear();
        self.lower.clear();
        self.lower_end.clear();
        self.inverse.clear();
        self.lu.resize(n * n, 0.0);
        self.pivot.resize(n, 0);
        if n == 0 {
            self.upper.clear();
            self.upper_end.clear();
            self.ready = true;
            return;
        }
        for (j, column) in matrix.chunks_exact(size).take(n).enumerate() {
            self.lu[j * n..][..n].copy_from_slice(&column[..n]);
            let column = entries(&column[n..], 0);
            self.below
                .extend(column.map(|entry| (entry.row, j as u32, entry.value)));
        }
        for k in 0..n {
            let (left, right) = self.lu.split_at_mut((k + 1) * n);
            let column = &mut left[k * n..];
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
                return;
            }
            let scale = 1.0 / column[k];
            self.inverse.push(scale);
            let start = self.lower.len();
            let scaled = entries(&column[k + 1..], k + 1).map(|entry| Entry {
                value: entry.value * scale,
                ..entry
            });
            self.lower.extend(scaled);
            self.lower_end.push(self.lower.len());
            for other in right.chunks_exact_mut(n) {
                other.swap(k, pivot);
                if other[k] != 0.0 {
                    let top = other[k];
                    subtract(other, top, &self.lower[start..]);
                }
            }
        }
        self.order_rows();
        self.upper.clear();
        self.upper_end.clear();
        for (k, column) in self.lu.chunks_exact(n).enumerate() {
            self.upper.extend(entries(&column[..k], 0));
            self.upper_end.push(self.upper.len());
        }
        self.ready = true;
    }

    /// Moves the rows of L according to the pivots of later columns.
    fn order_rows(&mut self) {
        let n = self.states;
        for later in (0..n).filter(|k| self.pivot[*k] != *k) {
            let (a, b) = (later as u32, self.pivot[later] as u32);
            let before = later.checked_sub(1).map_or(0, |last| self.lower_end[last]);
            for entry in &mut self.lower[..before] {
                if entry.row == a {
                    entry.row = b;
                } else if entry.row == b {
                    entry.row = a;
                }
            }
        }
    }

    fn column<'a>(list: &'a [Entry], end: &[usize], j: usize) -> &'a [Entry] {
        let start = j.checked_sub(1).map_or(0, |last| end[last]);
        &list[start..end[j]]
    }

    fn solve(&self, b: &mut [f64]) {
        let n = self.states;
        let (x, q) = b.split_at_mut(n);
        for k in 0..n {
            x.swap(k, self.pivot[k]);
        }
        let mut start = 0;
        for (j, end) in self.lower_end.iter().enumerate() {
            if x[j] != 0.0 {
                subtract(x, x[j], &self.lower[start..*end]);
            }
            start = *end;
        }
        for j in (0..n).rev() {
            x[j] *= self.inverse[j];
            subtract(x, x[j], Self::column(&self.upper, &self.upper_end, j));
        }
        for (i, j, value) in &self.below {
            q[*i as usize] -= value * x[*j as usize];
        }
    }

    fn solve_transpose(&self, b: &mut [f64]) {
        let dot = |a: &[Entry], b: &[f64]| a.iter().map(|e| e.value * b[e.row as usize]).sum::<f64>();
        let n = self.states;
        let (x, q) = b.split_at_mut(n);
        for (i, j, value) in &self.below {
            x[*j as usize] -= value * q[*i as usize];
        }
        for j in 0..n {
            x[j] = (x[j] - dot(Self::column(&self.upper, &self.upper_end, j), x)) * self.inverse[j];
        }
        for j in (0..n).rev() {
            x[j] -= dot(Self::column(&self.lower, &self.lower_end, j), x);
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

#[cfg(test)]
mod tests {
    use super::*;

    const STATES: usize = 12;
    const SIZE: usize = 19;

    /// A column-major matrix of this block form: positions next to stiff contacts, entries that need pivoting, zeros.
    fn newton_matrix(positions: usize) -> Vec<f64> {
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
                let value = random();
                let sparse = if (i + 2 * j) % 3 == 0 { 0.0 } else { value };
                a[j * SIZE + i] = if j < STATES {
                    sparse
                } else {
                    f64::from(u8::from(i == j))
                };
            }
        }
        for body in 0..positions {
            let (y, v) = (2 * body, 2 * body + 1);
            for j in 0..STATES {
                a[j * SIZE + y] = 0.0;
            }
            a[y * SIZE + y] = 1.0;
            a[v * SIZE + y] = -1e-5;
            a[y * SIZE + v] = 1e3 * (1 + body) as f64;
            a[v * SIZE + v] = 1.0;
        }
        a
    }

    #[test]
    fn solutions_satisfy_the_system_and_its_transpose() {
        for a in [newton_matrix(0), newton_matrix(3)] {
            let mut factors = Factors::default();
            factors.factorise(&a, SIZE);
            assert_eq!(factors.states, STATES);
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
                    assert!(residual <= 1e-12 * size, "{i} {transpose}: {residual} of {size}");
                }
            }
        }
    }

    #[test]
    fn a_singular_matrix_is_an_error() {
        let mut factors = Factors::default();
        assert!(factors.ready().is_err());
        factors.factorise(&vec![0.0; SIZE * SIZE], SIZE);
        assert!(factors.ready().is_err());
        factors.factorise(&vec![f64::NAN; SIZE * SIZE], SIZE);
        assert!(factors.ready().is_err());
    }
}
