use crate::matrix::real_product;
use nalgebra::{Complex, DMatrix};
use serde::{Deserialize, Serialize};

/// Matrix T of one parity: maps the amplitudes of all modes to those of the independent modes, whose radiation is
/// known.
///
/// For modes of the same body, the column of an independent mode is a unit vector, and most other modes have a
/// different parity, so few columns have more than one entry. Modes of another body on the same surface are all
/// combinations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Combination {
    /// Indices of the independent modes among all modes; empty if they belong to another body.
    independent: Vec<usize>,
    /// Indices of the modes that are combinations of the independent ones.
    dependent: Vec<usize>,
    /// Coefficients, independent modes x dependent ones.
    #[serde(with = "crate::blocks")]
    of_dependent: DMatrix<f64>,
    modes: usize,
}

impl Combination {
    /// Creates the matrix for `modes` modes.
    pub(crate) fn new(
        modes: usize,
        independent: Vec<usize>,
        dependent: Vec<usize>,
        of_dependent: DMatrix<f64>,
    ) -> Self {
        Self {
            independent,
            dependent,
            of_dependent,
            modes,
        }
    }

    /// Combinations of another set of independent modes: one column of `of_combined` for each mode in `combined`; the
    /// others of `modes` are zero.
    pub(crate) fn of_others(modes: usize, combined: Vec<usize>, of_combined: DMatrix<f64>) -> Self {
        Self::new(modes, Vec::new(), combined, of_combined)
    }

    /// Number of independent modes.
    fn rows(&self) -> usize {
        self.of_dependent.nrows()
    }

    /// Indices of the independent modes among all modes.
    pub(crate) fn independent(&self) -> &[usize] {
        &self.independent
    }

    /// T a for each column of `motion` (modes x columns).
    pub(crate) fn of(&self, motion: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let mut of = if self.independent.is_empty() {
            DMatrix::zeros(self.rows(), motion.ncols())
        } else {
            motion.select_rows(&self.independent)
        };
        if !self.dependent.is_empty() {
            let dependent = motion.select_rows(&self.dependent);
            of += real_product(&self.of_dependent, &dependent);
        }
        of
    }

    /// Adds T^T x for each column of `x` (independent modes x columns).
    pub(crate) fn add_transposed(&self, x: &DMatrix<Complex<f64>>, to: &mut DMatrix<Complex<f64>>) {
        for (mut to, x) in to.column_iter_mut().zip(x.column_iter()) {
            self.independent
                .iter()
                .zip(x.iter())
                .for_each(|(&mode, x)| to[mode] += x);
        }
        if !self.dependent.is_empty() {
            let of = real_product(&self.of_dependent.transpose(), x);
            for (&mode, of) in self.dependent.iter().zip(of.row_iter()) {
                let mut row = to.row_mut(mode);
                row += of;
            }
        }
    }

    /// T v for a sparse real motion v, given by its nonzero entries; the result has only nonzero entries, in ascending
    /// order.
    pub(crate) fn of_sparse(&self, motion: &[(usize, f64)]) -> Vec<(usize, f64)> {
        let mut of = vec![0.0; self.rows()];
        for &(mode, v) in motion {
            if let Some(row) = self.independent.iter().position(|own| *own == mode) {
                of[row] += v;
            } else if let Some(column) = self.dependent.iter().position(|own| *own == mode) {
                let column = self.of_dependent.column(column);
                of.iter_mut().zip(column.iter()).for_each(|(of, t)| *of += t * v);
            }
        }
        of.into_iter().enumerate().filter(|(_, v)| *v != 0.0).collect()
    }

    /// T as a dense matrix.
    pub(crate) fn dense(&self) -> DMatrix<f64> {
        let mut dense = DMatrix::zeros(self.rows(), self.modes);
        for (row, &mode) in self.independent.iter().enumerate() {
            dense[(row, mode)] = 1.0;
        }
        for (&mode, column) in self.dependent.iter().zip(self.of_dependent.column_iter()) {
            dense.set_column(mode, &column);
        }
        dense
    }
}
