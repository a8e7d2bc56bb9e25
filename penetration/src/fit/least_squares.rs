//! Linear least squares with a rank-revealing QR decomposition.

use nalgebra::{DMatrix, DVector};

use super::error::FitError;

/// Relative pivot size below which a column counts as a combination of others.
const RANK_TOLERANCE: f64 = 1e-10;

/// Smallest contribution of a column that counts as a partner of a dependent column.
const PARTNER: f64 = 1e-6;

/// Solves min |X c - s| for X of full rank without normal equations (Golub and Van Loan, Matrix Computations, 2013,
/// sec. 5.4).
#[derive(Debug, Clone)]
pub(super) struct LeastSquares {
    /// Orthonormal basis of the column space of X.
    q: DMatrix<f64>,
    /// A, which maps Q^T s to the coefficients of the terms: c = A Q^T s.
    inverse: DMatrix<f64>,
}

impl LeastSquares {
    /// Decomposes `matrix`; `conversion` maps its coefficients to those of the terms. A column counts as zero if its
    /// norm is below `RANK_TOLERANCE` times its entry of `raw_norms`.
    ///
    /// # Errors
    /// [`FitError::NotIdentifiable`], naming the dependent columns.
    pub(super) fn new(
        mut matrix: DMatrix<f64>,
        conversion: &DMatrix<f64>,
        raw_norms: &[f64],
        names: &[String],
    ) -> Result<Self, FitError> {
        let p = matrix.ncols();
        let mut norms = Vec::with_capacity(p);
        for (column, raw) in raw_norms.iter().enumerate() {
            let norm = matrix.column(column).norm();
            if norm.is_nan() || norm <= RANK_TOLERANCE * raw {
                let partners = if *raw > 0.0 { vec!["1".to_owned()] } else { Vec::new() };
                return Err(FitError::NotIdentifiable {
                    term: names[column].clone(),
                    partners,
                });
            }
            matrix.column_mut(column).scale_mut(1.0 / norm);
            norms.push(norm);
        }
        let qr = matrix.col_piv_qr();
        let r = qr.r();
        let mut order = DMatrix::from_fn(1, p, |_, column| column);
        qr.p().permute_columns(&mut order);
        let pivot = |k: usize| r[(k, k)].abs();
        if let Some(rank) = (0..p).find(|&k| pivot(k) <= RANK_TOLERANCE * pivot(0)) {
            return Err(dependent(&r, rank, order.as_slice(), names));
        }
        let Some(mut inverse) = r.solve_upper_triangular(&DMatrix::identity(p, p)) else {
            return Err(FitError::Covariance);
        };
        qr.p().inv_permute_rows(&mut inverse);
        for (mut row, norm) in inverse.row_iter_mut().zip(&norms) {
            row /= *norm;
        }
        Ok(Self {
            q: qr.q(),
            inverse: conversion * inverse,
        })
    }

    /// Q^T s, the coefficients in the orthonormal basis.
    pub(super) fn project(&self, s: &DVector<f64>) -> DVector<f64> {
        self.q.tr_mul(s)
    }

    /// Coefficients of the terms from those in the orthonormal basis.
    pub(super) fn coefficients(&self, projected: &DVector<f64>) -> DVector<f64> {
        &self.inverse * projected
    }

    /// Orthonormal columns.
    pub(super) fn q(&self) -> &DMatrix<f64> {
        &self.q
    }

    /// A, which maps coefficients in the orthonormal basis to those of the terms.
    pub(super) fn inverse(&self) -> &DMatrix<f64> {
        &self.inverse
    }

    /// (X^T X)^-1 in the terms of the law.
    pub(super) fn inverse_gram(&self) -> DMatrix<f64> {
        &self.inverse * self.inverse.transpose()
    }

    /// Covariance of the coefficients with residuals correlated within each of `clusters` but not between them: (X^T
    /// X)^-1 (sum X_g^T e_g e_g^T X_g) (X^T X)^-1 G/(G-1) (n-1)/(n-p) (CR1; Liang and Zeger 1986, Biometrika 73).
    pub(super) fn clustered(&self, residuals: &DVector<f64>, clusters: &[std::ops::Range<usize>]) -> DMatrix<f64> {
        let (n, p, groups) = (self.q.nrows() as f64, self.q.ncols(), clusters.len() as f64);
        let mut meat = DMatrix::zeros(p, p);
        let mut score = DVector::zeros(p);
        for cluster in clusters {
            let rows = self.q.rows(cluster.start, cluster.len());
            score.gemv_tr(1.0, &rows, &residuals.rows(cluster.start, cluster.len()), 0.0);
            meat.ger(1.0, &score, &score, 1.0);
        }
        meat *= groups / (groups - 1.0) * (n - 1.0) / (n - p as f64);
        &self.inverse * meat * self.inverse.transpose()
    }
}

/// The error that the column in position `rank` of the pivot order is a combination of earlier ones.
fn dependent(r: &DMatrix<f64>, rank: usize, order: &[usize], names: &[String]) -> FitError {
    let leading = r.view((0, 0), (rank, rank)).into_owned();
    let parts = leading.solve_upper_triangular(&r.view((0, rank), (rank, 1)).into_owned());
    let partners = (0..rank).filter(|&k| parts.as_ref().is_none_or(|parts| parts[(k, 0)].abs() > PARTNER));
    let mut all: Vec<usize> = partners.map(|k| order[k]).chain([order[rank]]).collect();
    // The term that comes last in the form is the one reported.
    all.sort_unstable();
    let term = all.pop().map_or_else(String::new, |last| names[last].clone());
    FitError::NotIdentifiable {
        term,
        partners: all.into_iter().map(|column| names[column].clone()).collect(),
    }
}
