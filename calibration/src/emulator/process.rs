//! The Gaussian process of an emulator: its hyperparameters and its predictive mean.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltRegularization, cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::cholesky::llt::inverse::{inverse, inverse_scratch};
use faer::linalg::cholesky::llt::solve::{solve_in_place, solve_in_place_scratch};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use serde::{Deserialize, Serialize};

/// Mean and standard deviation of the normal density of ln w_j.
const RELEVANCE: [f64; 2] = [-3.5, 1.5];

/// Initial values: ln w_j, ln a and ln v.
const START: [f64; 3] = [-2.0, 0.0, -2.0];

/// Step sizes of Rprop: first, smallest, largest, and their factors where the sign of the derivative stays or changes.
const STEPS: [f64; 3] = [0.2, 1e-3, 1.0];
const FACTORS: [f64; 2] = [1.2, 0.5];

/// Logarithms of the hyperparameters are bounded by this magnitude.
const BOUND: f64 = 12.0;

/// Logarithms of the hyperparameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Hyperparameters {
    /// ln w_j, then ln a and ln v.
    logarithms: Vec<f64>,
}

impl Hyperparameters {
    pub(super) fn of_prior(variables: usize) -> Self {
        let [relevance, amplitude, noise] = START;
        let mut logarithms = vec![relevance; variables];
        logarithms.extend([amplitude, noise]);
        Self { logarithms }
    }

    fn variables(&self) -> usize {
        self.logarithms.len() - 2
    }

    fn relevance(&self, j: usize) -> f64 {
        self.logarithms[j].exp()
    }

    fn amplitude(&self) -> f64 {
        self.logarithms[self.variables()].exp()
    }

    /// v, in units of the variance of the values.
    pub(super) fn noise(&self) -> f64 {
        self.logarithms[self.variables() + 1].exp()
    }

    /// Coordinates whose linear effect, of variance 2 a w_j^2, exceeds a share of the noise.
    pub(super) fn active(&self, share: f64) -> Vec<usize> {
        let least = share * (0.5 * self.noise() / self.amplitude()).sqrt();
        (0..self.variables()).filter(|&j| self.relevance(j) > least).collect()
    }

    /// Those of some coordinates.
    pub(super) fn of(&self, active: &[usize]) -> Self {
        let mut logarithms: Vec<f64> = active.iter().map(|&j| self.logarithms[j]).collect();
        logarithms.extend_from_slice(&self.logarithms[self.variables()..]);
        Self { logarithms }
    }
}

/// Coefficients of the predictive mean.
pub(super) struct Polynomial {
    pub(super) constant: f64,
    pub(super) linear: Vec<f64>,
    /// Upper triangle, by rows.
    pub(super) quadratic: Vec<f64>,
}

/// Points (one row each) and their values, of mean 0 and variance 1.
pub(super) struct Training {
    points: Mat<f64>,
    values: Vec<f64>,
}

impl Training {
    /// The coordinates `variables` of some points.
    pub(super) fn new(points: &[&[f64]], variables: &[usize], values: Vec<f64>) -> Self {
        Self {
            points: Mat::from_fn(points.len(), variables.len(), |row, j| points[row][variables[j]]),
            values,
        }
    }

    /// sum_j w_j^2 x_j x_j' of all pairs.
    fn products(&self, own: &Hyperparameters) -> Mat<f64> {
        let (n, d) = (self.points.nrows(), self.points.ncols());
        let weighted = Mat::from_fn(n, d, |row, j| own.relevance(j) * self.points[(row, j)]);
        let mut products = Mat::zeros(n, n);
        let [a, b] = [weighted.as_ref(), weighted.transpose()];
        matmul(products.as_mut(), Accum::Replace, a, b, 1.0, Par::Seq);
        products
    }

    /// Lower Cholesky factor of the covariance of the values.
    fn factor(products: MatRef<'_, f64>, own: &Hyperparameters) -> Option<Mat<f64>> {
        let n = products.nrows();
        let (amplitude, noise) = (own.amplitude(), own.noise());
        let mut factor = Mat::from_fn(n, n, |row, column| {
            let smooth = amplitude * (1.0 + products[(row, column)]).powi(2);
            if row == column { smooth + noise } else { smooth }
        });
        let request = cholesky_in_place_scratch::<f64>(n, Par::Seq, Default::default());
        let mut memory = MemBuffer::new(request);
        let stack = MemStack::new(&mut memory);
        let regularisation = LltRegularization::default();
        cholesky_in_place(factor.as_mut(), regularisation, Par::Seq, stack, Default::default()).ok()?;
        Some(factor)
    }

    /// Solution of K alpha = y.
    fn solved(&self, factor: MatRef<'_, f64>) -> Mat<f64> {
        let n = factor.nrows();
        let mut alpha = Mat::from_fn(n, 1, |row, _| self.values[row]);
        let mut memory = MemBuffer::new(solve_in_place_scratch::<f64>(n, 1, Par::Seq));
        solve_in_place(factor, alpha.as_mut(), Par::Seq, MemStack::new(&mut memory));
        alpha
    }

    /// Derivatives of the negative logarithm of the posterior density of the hyperparameters. With W = alpha alpha^T -
    /// K^-1, that of the marginal likelihood is -tr(W dK/dt)/2 (Rasmussen and Williams, equation 5.9).
    fn derivatives(&self, own: &Hyperparameters) -> Option<Vec<f64>> {
        let (n, d) = (self.points.nrows(), self.points.ncols());
        let products = self.products(own);
        let factor = Self::factor(products.as_ref(), own)?;
        let alpha = self.solved(factor.as_ref());
        let mut inverted = Mat::zeros(n, n);
        let mut memory = MemBuffer::new(inverse_scratch::<f64>(n, Par::Seq));
        let stack = MemStack::new(&mut memory);
        inverse(inverted.as_mut(), factor.as_ref(), Par::Seq, stack);
        // Only the lower triangle of the inverse is computed.
        let w = |row: usize, column: usize| {
            let (low, high) = (row.min(column), row.max(column));
            alpha[(row, 0)] * alpha[(column, 0)] - inverted[(high, low)]
        };
        let amplitude = own.amplitude();
        let (mut of_amplitude, mut trace) = (0.0, 0.0);
        let slopes = Mat::from_fn(n, n, |row, column| {
            let one = 1.0 + products[(row, column)];
            let w = w(row, column);
            of_amplitude += w * amplitude * one * one;
            if row == column {
                trace += w;
            }
            w * 2.0 * amplitude * one
        });
        let mut moved = Mat::zeros(n, d);
        matmul(moved.as_mut(), Accum::Replace, &slopes, &self.points, 1.0, Par::Seq);
        let of_relevance = |j: usize| {
            let sum: f64 = (0..n).map(|row| self.points[(row, j)] * moved[(row, j)]).sum();
            let [mean, deviation] = RELEVANCE;
            -own.relevance(j).powi(2) * sum + (own.logarithms[j] - mean) / deviation.powi(2)
        };
        let mut derivatives: Vec<f64> = (0..d).map(of_relevance).collect();
        derivatives.extend([-0.5 * of_amplitude, -0.5 * own.noise() * trace]);
        Some(derivatives)
    }

    /// Estimates the hyperparameters by Rprop (Riedmiller and Braun, "A direct adaptive method for faster
    /// backpropagation learning", IEEE International Conference on Neural Networks (1993); for Gaussian processes Blum
    /// and Riedmiller, "Optimization of Gaussian process hyperparameters using Rprop", ESANN (2013)).
    pub(super) fn estimate(&self, start: Hyperparameters, iterations: usize) -> Hyperparameters {
        let mut own = start;
        let [first, least, most] = STEPS;
        let mut steps = vec![first; own.logarithms.len()];
        let mut before = vec![0.0; own.logarithms.len()];
        for _ in 0..iterations {
            let Some(now) = self.derivatives(&own) else {
                break;
            };
            for (k, derivative) in now.into_iter().enumerate() {
                let product = before[k] * derivative;
                if product != 0.0 {
                    steps[k] = (steps[k] * FACTORS[usize::from(product < 0.0)]).clamp(least, most);
                }
                if derivative != 0.0 {
                    own.logarithms[k] = (own.logarithms[k] - derivative.signum() * steps[k]).clamp(-BOUND, BOUND);
                }
                before[k] = derivative;
            }
        }
        own
    }

    /// The predictive mean as a polynomial; none if the covariance is not positive definite.
    pub(super) fn polynomial(&self, own: &Hyperparameters) -> Option<Polynomial> {
        let factor = Self::factor(self.products(own).as_ref(), own)?;
        let alpha = self.solved(factor.as_ref());
        let (n, d) = (self.points.nrows(), self.points.ncols());
        let weighted = Mat::from_fn(n, d, |row, j| alpha[(row, 0)] * self.points[(row, j)]);
        let mut pairs = Mat::zeros(d, d);
        let [a, b] = [self.points.transpose(), weighted.as_ref()];
        matmul(pairs.as_mut(), Accum::Replace, a, b, 1.0, Par::Seq);
        let amplitude = own.amplitude();
        let square = |j: usize| own.relevance(j).powi(2);
        let linear = |j: usize| 2.0 * amplitude * square(j) * (0..n).map(|row| weighted[(row, j)]).sum::<f64>();
        let quadratic = |j: usize, k: usize| {
            let both = if j == k { 1.0 } else { 2.0 };
            both * amplitude * square(j) * square(k) * pairs[(j, k)]
        };
        Some(Polynomial {
            constant: amplitude * (0..n).map(|row| alpha[(row, 0)]).sum::<f64>(),
            linear: (0..d).map(linear).collect(),
            quadratic: (0..d)
                .flat_map(|j| (j..d).map(move |k| (j, k)))
                .map(|(j, k)| quadratic(j, k))
                .collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    fn training() -> Training {
        let stream = |row: usize| Stream::new(5, &[row as u64]);
        let points: Vec<Vec<f64>> = (0..40)
            .map(|row| (0..3).map(|j| stream(row).normal(j)).collect())
            .collect();
        let rows: Vec<&[f64]> = points.iter().map(Vec::as_slice).collect();
        let values = points.iter().map(|x| x[0] + 0.5 * x[1] * x[1] - 0.5).collect();
        Training::new(&rows, &[0, 1, 2], values)
    }

    /// Negative logarithm of the posterior density, up to a constant.
    fn density(own: &Training, at: &Hyperparameters) -> f64 {
        let factor = Training::factor(own.products(at).as_ref(), at);
        let Some(factor) = factor else { return f64::NAN };
        let alpha = own.solved(factor.as_ref());
        let fit: f64 = own.values.iter().enumerate().map(|(row, y)| y * alpha[(row, 0)]).sum();
        let log_determinant: f64 = (0..factor.nrows()).map(|k| factor[(k, k)].ln()).sum();
        let [mean, deviation] = RELEVANCE;
        let relevances = &at.logarithms[..at.variables()];
        let prior: f64 = relevances.iter().map(|own| ((own - mean) / deviation).powi(2)).sum();
        0.5 * fit + log_determinant + 0.5 * prior
    }

    #[test]
    fn derivatives_are_those_of_the_density() {
        let training = training();
        let at = Hyperparameters {
            logarithms: vec![-0.8, -0.4, -2.0, 0.2, -1.5],
        };
        let derivatives = training.derivatives(&at).unwrap_or_default();
        assert_eq!(derivatives.len(), 5);
        for (k, derivative) in derivatives.into_iter().enumerate() {
            let moved = |by: f64| {
                let mut own = at.clone();
                own.logarithms[k] += by;
                density(&training, &own)
            };
            let difference = (moved(1e-5) - moved(-1e-5)) / 2e-5;
            assert!(
                (derivative - difference).abs() < 1e-5 * (1.0 + difference.abs()),
                "{k}: {derivative} {difference}"
            );
        }
    }

    #[test]
    fn the_polynomial_is_the_sum_over_the_kernel() {
        let training = training();
        let at = training.estimate(Hyperparameters::of_prior(3), 30);
        let products = training.products(&at);
        let alpha = Training::factor(products.as_ref(), &at).map(|own| training.solved(own.as_ref()));
        let (alpha, polynomial) = (alpha.unwrap_or_else(|| Mat::zeros(40, 1)), training.polynomial(&at));
        for row in 0..5 {
            let kernel = |other: usize| at.amplitude() * (1.0 + products[(row, other)]).powi(2);
            let sum: f64 = (0..40).map(|other| kernel(other) * alpha[(other, 0)]).sum();
            let of_polynomial = polynomial.as_ref().map_or(f64::NAN, |own| {
                let x = |j: usize| training.points[(row, j)];
                let linear: f64 = (0..3).map(|j| own.linear[j] * x(j)).sum();
                let pairs = (0..3).flat_map(|j| (j..3).map(move |k| (j, k)));
                let quadratic: f64 = pairs.zip(&own.quadratic).map(|((j, k), q)| q * x(j) * x(k)).sum();
                own.constant + linear + quadratic
            });
            assert!((sum - of_polynomial).abs() < 1e-9, "{sum} {of_polynomial}");
        }
    }
}
