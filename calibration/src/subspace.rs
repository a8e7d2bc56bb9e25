//! The directions in input space that the readings inform, and the proposal within them.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::statistics::quantile_of;

/// Ridge parameter of the regression, per row.
const RIDGE: f64 = 1e-4;

/// A direction is informed if a change by one standard deviation changes the readings by more than this many error
/// scales.
const INFORMED: f64 = 0.3;

/// Number of robust standard deviations at which the regressand of a reading is clipped.
const CLIPPED: f64 = 4.0;

/// Ratio of the standard deviation to the median absolute deviation of a normal distribution.
const NORMAL_MAD: f64 = 1.482_602_218_505_602;

/// Points and their predictions, in units of the readings' scales; one row per point.
pub(crate) struct Regression {
    pub(crate) points: DMatrix<f64>,
    pub(crate) predictions: DMatrix<f64>,
}

/// An orthonormal basis (variables x r) of the informed directions: the left singular vectors of the ridge regression B
/// = (X^T X + 1e-4 n I)^-1 X^T Y whose singular values exceed 0.3, excluding variables constrained by rules.
pub(crate) fn directions(regression: Regression, ruled: &[bool]) -> DMatrix<f64> {
    let Regression {
        mut points,
        mut predictions,
    } = regression;
    let (n, d) = points.shape();
    if predictions.ncols() == 0 || n < 2 {
        return DMatrix::zeros(d, 0);
    }
    for mut column in points.column_iter_mut() {
        let mean = column.mean();
        column.add_scalar_mut(-mean);
    }
    for mut column in predictions.column_iter_mut() {
        let median = |mut values: Vec<f64>| quantile_of(&mut values, 0.5);
        let middle = median(column.iter().copied().collect());
        let spread = NORMAL_MAD * median(column.iter().map(|y| (y - middle).abs()).collect());
        if spread > 0.0 {
            let [low, high] = [-CLIPPED, CLIPPED].map(|c| middle + c * spread);
            column.apply(|y| *y = y.clamp(low, high));
        }
        let mean = column.mean();
        column.add_scalar_mut(-mean);
    }
    let mut gram = points.tr_mul(&points);
    for k in 0..d {
        gram[(k, k)] += RIDGE * n as f64;
    }
    let Some(factor) = gram.cholesky() else {
        return DMatrix::zeros(d, 0);
    };
    let mut effects = factor.solve(&points.tr_mul(&predictions));
    for (k, _) in ruled.iter().enumerate().filter(|(_, ruled)| **ruled) {
        effects.row_mut(k).fill(0.0);
    }
    let svd = effects.svd(true, false);
    let informed: Vec<usize> = (0..svd.singular_values.len())
        .filter(|&k| svd.singular_values[k] > INFORMED)
        .collect();
    svd.u
        .map_or_else(|| DMatrix::zeros(d, 0), |u| u.select_columns(&informed))
}

/// Mean and Cholesky factor of the covariance of points in a subspace.
pub(crate) struct Reference {
    pub(crate) mean: DVector<f64>,
    pub(crate) factor: Cholesky<f64, Dyn>,
}

impl Reference {
    /// Estimates the reference from points (r x n). The covariance is shrunk towards the identity, that of the prior,
    /// with the weight of Ledoit and Wolf ("A well-conditioned estimator for large-dimensional covariance matrices",
    /// Journal of Multivariate Analysis 88, 365 (2004)). None if any point is not finite.
    pub(crate) fn of(points: &DMatrix<f64>) -> Option<Self> {
        let (r, n) = points.shape();
        let mean = points.column_mean();
        let mut centred = points.clone();
        for mut column in centred.column_iter_mut() {
            column -= &mean;
        }
        let sample = (&centred * centred.transpose()) / n as f64;
        let identity = DMatrix::identity(r, r);
        let distance = (&sample - &identity).norm_squared();
        let scatter: f64 = centred
            .column_iter()
            .map(|x| (x * x.transpose() - &sample).norm_squared())
            .sum::<f64>()
            / (n as f64).powi(2);
        let weight = if distance > 0.0 {
            (scatter / distance).min(1.0)
        } else {
            1.0
        };
        let factor = (sample * (1.0 - weight) + identity * weight).cholesky()?;
        Some(Self { mean, factor })
    }

    /// L^-1 (y - m).
    pub(crate) fn standardised(&self, y: &DVector<f64>) -> DVector<f64> {
        let centred = y - &self.mean;
        let solved = self.factor.l_dirty().solve_lower_triangular(&centred);
        solved.unwrap_or(centred)
    }

    /// m + L e.
    pub(crate) fn point(&self, e: &DVector<f64>) -> DVector<f64> {
        &self.mean + self.factor.l() * e
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::random::Stream;

    fn normals(rows: usize, columns: usize) -> DMatrix<f64> {
        let stream = |row: usize| Stream::new(3, &[row as u64]);
        DMatrix::from_fn(rows, columns, |row, column| stream(row).normal(column as u64))
    }

    #[test]
    fn a_linear_model_informs_its_rows() {
        let points = normals(400, 6);
        let rows = DMatrix::from_row_slice(2, 6, &[3.0, 4.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0]);
        let predictions = &points * rows.transpose();
        let found = directions(Regression { points, predictions }, &[false; 6]);
        assert_eq!(found.ncols(), 1, "an effect of 0.1 scales informs nothing");
        let expected = [0.6, 0.8, 0.0, 0.0, 0.0, 0.0];
        let sign = found[(0, 0)].signum();
        for (got, expected) in found.iter().zip(expected) {
            assert!((sign * got - expected).abs() < 1e-2, "{found}");
        }
    }

    #[test]
    fn variables_of_rules_are_in_no_direction() {
        let points = normals(400, 3);
        let predictions = &points * DMatrix::from_row_slice(3, 1, &[2.0, 2.0, 0.0]);
        let found = directions(Regression { points, predictions }, &[false, true, false]);
        assert!(found.ncols() == 1 && found[(1, 0)] == 0.0 && found[(0, 0)].abs() > 0.99);
    }

    #[test]
    fn a_reference_standardises_its_points() {
        let points = normals(2, 5000);
        let scaled = DMatrix::from_fn(
            2,
            5000,
            |row, column| if row == 0 { 5.0 } else { 0.2 } * points[(row, column)],
        );
        let reference = Reference::of(&scaled).unwrap();
        let squares: f64 = scaled
            .column_iter()
            .map(|y| reference.standardised(&y.into_owned()).norm_squared())
            .sum();
        assert!((squares / 5000.0 / 2.0 - 1.0).abs() < 0.02);
        let y = scaled.column(7).into_owned();
        assert!((reference.point(&reference.standardised(&y)) - y).norm() < 1e-10);
    }
}
