//! Readings with their errors, and the likelihood of predictions.
//!
//! Reading k is y_k = f_k + sum_i c_ki z_i + e_k. The predicted value is f_k, and e_k is the independent error with
//! scale s_k. The errors z_i, of an instrument or of the model, are shared by several readings and sampled as
//! variables. With the residual r_k = (y_k - f_k - sum_i c_ki z_i)/s_k,
//!
//! ```text
//! l_k = -(nu + 1)/2 log(1 + r_k^2/nu), nu = 4      Student t
//! l_k = -r_k^2/2                                   Gaussian
//! ```
//!
//! without constants, so that l_k <= 0. The residuals of correlated errors are first whitened with the Cholesky factor
//! of their covariance. A censored reading contributes the logarithm of the probability of the observed interval.

use std::collections::BTreeSet;

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use crate::normal;

/// Degrees of freedom of the Student t distribution. Its effective scale by Fisher information is 18 % above a Gaussian
/// one, and a single outlier hardly affects the rest.
const DEGREES: f64 = 4.0;

/// Distribution of the independent errors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ErrorLaw {
    /// Student t with 4 degrees of freedom.
    Student,
    /// Gaussian, for comparison with closed-form results.
    Gaussian,
}

impl ErrorLaw {
    /// Logarithm of the density at a residual, relative to its value at 0.
    pub fn log_density(self, r: f64) -> f64 {
        match self {
            Self::Student => -0.5 * (DEGREES + 1.0) * (r * r / DEGREES).ln_1p(),
            Self::Gaussian => -0.5 * r * r,
        }
    }

    /// Probability of an error less than `r` scales. For 4 degrees of freedom, with q = 4 + r^2, F = 1/2 + r (q + 2)/(2
    /// q^(3/2)) (Johnson, Kotz and Balakrishnan, "Continuous univariate distributions", 1995, chapter 28).
    pub fn cumulative(self, r: f64) -> f64 {
        match self {
            Self::Gaussian => normal::cumulative(r),
            // In this tail the closed form suffers from cancellation: F = 3/r^4 (1 + O(1/r^2)).
            Self::Student if r < -100.0 => 3.0 / r.powi(4),
            Self::Student => {
                let q = 4.0 + r * r;
                0.5 + r * (q + 2.0) / (2.0 * q * q.sqrt())
            }
        }
    }

    /// The error below which the probability is `p`, 0 < p < 1. For 4 degrees of freedom, with a = 4 p (1 - p),
    /// t = 2 (cos(arccos(a^(1/2))/3)/a^(1/2) - 1)^(1/2), and the sign of p - 1/2 (Shaw, "Sampling Student's T
    /// distribution", Journal of Computational Finance 9, 37 (2006)).
    pub fn quantile(self, p: f64) -> f64 {
        match self {
            Self::Gaussian => normal::quantile(p),
            Self::Student => {
                let root = (4.0 * p * (1.0 - p)).max(f64::EPSILON).sqrt().min(1.0);
                let q = ((root.acos() / 3.0).cos() / root - 1.0).max(0.0);
                2.0 * q.sqrt().copysign(p - 0.5)
            }
        }
    }
}

/// The observed value or interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Reading {
    /// A value.
    Value(f64),
    /// At most this value.
    AtMost(f64),
    /// At least this value.
    AtLeast(f64),
    /// Between these values.
    Within([f64; 2]),
}

impl Reading {
    /// The value closest to `x` that is consistent with the reading.
    pub fn nearest(self, x: f64) -> f64 {
        match self {
            Self::Value(value) => value,
            Self::AtMost(most) => x.min(most),
            Self::AtLeast(least) => x.max(least),
            Self::Within([least, most]) => x.clamp(least, most),
        }
    }
}

impl Reading {
    /// The statement of the same observer about another value: the value, or the side of the bounds on which it lies.
    fn of_value(self, value: f64) -> Self {
        match self {
            Self::Value(_) => Self::Value(value),
            Self::AtMost(bound) | Self::AtLeast(bound) => match value <= bound {
                true => Self::AtMost(bound),
                false => Self::AtLeast(bound),
            },
            Self::Within([low, _]) if value < low => Self::AtMost(low),
            Self::Within([_, high]) if value > high => Self::AtLeast(high),
            Self::Within(ends) => Self::Within(ends),
        }
    }
}

/// An error shared by several readings: a standard normal variable of the sampler times a coefficient.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SharedError {
    /// Index of the variable.
    pub variable: usize,
    /// Its effect on the reading, in the unit of the reading.
    pub coefficient: f64,
}

/// A reading with its errors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Datum {
    /// Name in the file of measurements.
    pub name: String,
    /// Index of the condition under which it was read.
    pub condition: usize,
    /// The reading, in the unit of the prediction.
    pub reading: Reading,
    /// s, scale of the independent error; above 0.
    pub scale: f64,
    /// Errors shared with other readings.
    pub shared: Vec<SharedError>,
    /// Whether the reading conditions the inputs; otherwise it is only predicted.
    pub counts: bool,
}

/// A predicted value.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Prediction {
    /// The value.
    Value(f64),
    /// The simulation ended before the value was reached, so the value is at least this.
    AtLeast(f64),
    /// There is no value because an event did not occur.
    Missing,
}

impl Prediction {
    /// The value or its lower bound; NaN if missing.
    pub fn value(self) -> f64 {
        match self {
            Self::Value(value) | Self::AtLeast(value) => value,
            Self::Missing => f64::NAN,
        }
    }
}

/// A correlation of the independent errors of several readings.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorCorrelation {
    /// Indices of the readings.
    pub data: Vec<usize>,
    /// The covariance of each pair is `r` times the product of their `parts`.
    pub r: f64,
    /// Standard deviation of the correlated part of each reading's error, in the same order.
    pub parts: Vec<f64>,
}

/// Why the errors do not define a likelihood.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LikelihoodError {
    /// The covariance is not positive definite.
    #[error("the correlations of the errors of {names} are not positive definite")]
    Indefinite {
        /// Names of the readings.
        names: String,
    },
    /// A reading with correlated errors is censored and therefore has no residual.
    #[error("`{name}` is censored: its error cannot be correlated with others")]
    Censored {
        /// Name of the reading.
        name: String,
    },
}

/// A group of readings whose errors are correlated, directly or through others.
#[derive(Debug, Clone)]
struct Block {
    members: Vec<usize>,
    /// L^-1 of their covariance L L^T.
    whitening: DMatrix<f64>,
}

/// The likelihood of predictions.
#[derive(Debug, Clone)]
pub struct Likelihood {
    data: Vec<Datum>,
    law: ErrorLaw,
    blocks: Vec<Block>,
    order: Vec<usize>,
}

impl Likelihood {
    /// Creates the likelihood of readings taken under `conditions` conditions.
    ///
    /// # Errors
    /// [`LikelihoodError`] if the correlations are invalid.
    pub fn new(
        data: Vec<Datum>,
        conditions: usize,
        correlations: &[ErrorCorrelation],
        law: ErrorLaw,
    ) -> Result<Self, LikelihoodError> {
        let blocks = blocks(&data, correlations)?;
        let count = |condition: &usize| {
            let own = data.iter().filter(|own| own.condition == *condition && own.counts);
            std::cmp::Reverse(own.count())
        };
        let mut order: Vec<usize> = (0..conditions).collect();
        order.sort_by_key(count);
        Ok(Self {
            data,
            law,
            blocks,
            order,
        })
    }

    /// The readings.
    pub fn data(&self) -> &[Datum] {
        &self.data
    }

    /// Distribution of the independent errors.
    pub fn law(&self) -> ErrorLaw {
        self.law
    }

    /// Condition indices, the one with the most readings first, so that most candidates are rejected early.
    pub fn order(&self) -> &[usize] {
        &self.order
    }

    /// Indices of the readings of a condition.
    pub fn of_condition(&self, condition: usize) -> impl Iterator<Item = usize> + '_ {
        (0..self.data.len()).filter(move |&k| self.data[k].condition == condition)
    }

    /// Whether any reading is used for conditioning.
    pub fn is_informed(&self) -> bool {
        self.data.iter().any(|datum| datum.counts)
    }

    /// Total effect of the shared errors on a reading.
    pub fn shared(&self, datum: usize, z: &[f64]) -> f64 {
        let shared = self.data[datum].shared.iter();
        shared.map(|own| own.coefficient * z[own.variable]).sum()
    }

    /// Log-likelihood of one reading given its prediction and the shared errors, without correlations.
    pub fn of_datum(&self, datum: usize, z: &[f64], prediction: Prediction) -> f64 {
        self.of_reading(datum, self.data[datum].scale, self.shared(datum, z), prediction)
    }

    fn of_reading(&self, datum: usize, scale: f64, shared: f64, prediction: Prediction) -> f64 {
        let law = self.law;
        let below = |bound: f64, value: f64| law.cumulative((bound - value - shared) / scale);
        let above = |bound: f64, value: f64| law.cumulative((value + shared - bound) / scale);
        match (self.data[datum].reading, prediction) {
            (_, Prediction::Missing) => f64::NEG_INFINITY,
            (Reading::Value(y), Prediction::Value(f)) => law.log_density((y - f - shared) / scale),
            (Reading::AtMost(y), Prediction::Value(f) | Prediction::AtLeast(f))
            | (Reading::Value(y), Prediction::AtLeast(f)) => below(y, f).ln(),
            (Reading::AtLeast(y), Prediction::Value(f)) => above(y, f).ln(),
            (Reading::AtLeast(_), Prediction::AtLeast(_)) => 0.0,
            (Reading::Within([low, high]), Prediction::Value(f)) => {
                (below(high, f) - below(low, f)).max(f64::MIN_POSITIVE).ln()
            }
            (Reading::Within([_, high]), Prediction::AtLeast(f)) => below(high, f).ln(),
        }
    }

    /// Log-likelihood of a reading whose scale is multiplied by `factor`, including the normalisation of the scale.
    pub(crate) fn widened(&self, datum: usize, factor: f64, z: &[f64], prediction: Prediction) -> f64 {
        let scale = factor * self.data[datum].scale;
        self.of_reading(datum, scale, self.shared(datum, z), prediction)
    }

    /// Log-likelihood of the readings that become complete with the last of the first `known` conditions of
    /// [`order`](Self::order).
    pub(crate) fn of_step(&self, known: usize, z: &[f64], predictions: &[Prediction]) -> f64 {
        let seen = |datum: &usize| self.order[..known].contains(&self.data[*datum].condition);
        let last = self.order[known - 1];
        let of_block = |block: &Block| {
            let due = block.members.iter().all(seen) && block.members.iter().any(|&k| self.data[k].condition == last);
            if due { self.of_block(block, z, predictions) } else { 0.0 }
        };
        self.blocks.iter().map(of_block).sum()
    }

    fn of_block(&self, block: &Block, z: &[f64], predictions: &[Prediction]) -> f64 {
        let residual = |&k: &usize| match (self.data[k].reading, predictions[k]) {
            (Reading::Value(y), Prediction::Value(f)) => Some(y - f - self.shared(k, z)),
            _ => None,
        };
        // A prediction that is only a bound has no residual to whiten.
        match block.members.iter().map(residual).collect::<Option<Vec<f64>>>() {
            Some(residuals) => {
                let whitened = &block.whitening * DVector::from_vec(residuals);
                whitened.iter().map(|r| self.law.log_density(*r)).sum()
            }
            None => {
                let of_datum = |&k: &usize| self.of_datum(k, z, predictions[k]);
                block.members.iter().map(of_datum).sum()
            }
        }
    }

    /// Log-likelihood of all readings used for conditioning.
    pub fn total(&self, z: &[f64], predictions: &[Prediction]) -> f64 {
        self.blocks
            .iter()
            .map(|block| self.of_block(block, z, predictions))
            .sum()
    }

    /// Readings of a point. The error of each is drawn from its law at one of the `shares` in (0, 1). Errors of the
    /// readings that count are correlated as stated. For a bound, the observer states the side on which the value lies.
    /// If the prediction is not a value, the reading is unchanged.
    pub fn measured(&self, z: &[f64], predictions: &[Prediction], shares: &[f64]) -> Vec<Reading> {
        let mut errors: Vec<f64> = self
            .data
            .iter()
            .zip(shares)
            .map(|(own, share)| own.scale * self.law.quantile(*share))
            .collect();
        for block in self.blocks.iter().filter(|own| own.members.len() > 1) {
            let independent = block.members.iter().map(|&k| self.law.quantile(shares[k]));
            let independent = DVector::from_iterator(block.members.len(), independent);
            // The inverse of a Cholesky factor has a positive diagonal.
            if let Some(correlated) = block.whitening.solve_lower_triangular(&independent) {
                block
                    .members
                    .iter()
                    .zip(correlated.iter())
                    .for_each(|(&k, own)| errors[k] = *own);
            }
        }
        let observed = |(k, error): (usize, f64)| {
            let reading = self.data[k].reading;
            match predictions[k] {
                Prediction::Value(f) => reading.of_value(f + self.shared(k, z) + error),
                _ => reading,
            }
        };
        errors.into_iter().enumerate().map(observed).collect()
    }

    /// Logarithm of the constant omitted by [`total`](Self::total), for readings that are values.
    pub fn constant(&self) -> f64 {
        let at_zero = match self.law {
            // Gamma(5/2)/(sqrt(4 pi) Gamma(2)) = 3/8.
            ErrorLaw::Student => 0.375_f64.ln(),
            ErrorLaw::Gaussian => -0.5 * (2.0 * std::f64::consts::PI).ln(),
        };
        let is_value = |k: &usize| matches!(self.data[*k].reading, Reading::Value(_));
        let of_block = |block: &Block| {
            let diagonal = (0..block.members.len()).filter(|&row| is_value(&block.members[row]));
            diagonal
                .map(|row| at_zero + block.whitening[(row, row)].ln())
                .sum::<f64>()
        };
        self.blocks.iter().map(of_block).sum()
    }
}

/// Groups the conditioning readings whose errors are correlated.
fn blocks(data: &[Datum], correlations: &[ErrorCorrelation]) -> Result<Vec<Block>, LikelihoodError> {
    let n = data.len();
    let mut covariance = DMatrix::from_fn(
        n,
        n,
        |row, column| if row == column { data[row].scale.powi(2) } else { 0.0 },
    );
    let mut label: Vec<usize> = (0..n).collect();
    for correlation in correlations {
        let pairs: Vec<(usize, f64)> = correlation
            .data
            .iter()
            .copied()
            .zip(correlation.parts.iter().copied())
            .collect();
        for &(a, part_a) in pairs.iter().filter(|(k, _)| data[*k].counts) {
            if !matches!(data[a].reading, Reading::Value(_)) {
                let name = data[a].name.clone();
                return Err(LikelihoodError::Censored { name });
            }
            for &(b, part_b) in pairs.iter().filter(|(k, _)| *k != a && data[*k].counts) {
                covariance[(a, b)] = correlation.r * part_a * part_b;
                let [from, to] = [label[a].max(label[b]), label[a].min(label[b])];
                label.iter_mut().filter(|own| **own == from).for_each(|own| *own = to);
            }
        }
    }
    let labels: BTreeSet<usize> = (0..n).filter(|&k| data[k].counts).map(|k| label[k]).collect();
    let block = |of: usize| {
        let members: Vec<usize> = (0..n).filter(|&k| data[k].counts && label[k] == of).collect();
        let size = members.len();
        let own = DMatrix::from_fn(size, size, |row, column| covariance[(members[row], members[column])]);
        let whitening = own
            .cholesky()
            .and_then(|factor| factor.l().solve_lower_triangular(&DMatrix::identity(size, size)));
        let names = || {
            members
                .iter()
                .map(|&k| data[k].name.as_str())
                .collect::<Vec<_>>()
                .join(", ")
        };
        match whitening {
            Some(whitening) => Ok(Block { members, whitening }),
            None => Err(LikelihoodError::Indefinite { names: names() }),
        }
    };
    labels.into_iter().map(block).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn datum(reading: Reading, scale: f64) -> Datum {
        Datum {
            name: "a".to_owned(),
            condition: 0,
            reading,
            scale,
            shared: Vec::new(),
            counts: true,
        }
    }

    fn likelihood(data: Vec<Datum>, law: ErrorLaw) -> Likelihood {
        Likelihood::new(data, 1, &[], law).unwrap()
    }

    #[test]
    fn the_quantile_inverts_the_cumulative_probability() {
        for law in [ErrorLaw::Student, ErrorLaw::Gaussian] {
            for p in [0.001, 0.05, 0.3, 0.5, 0.8, 0.99] {
                assert!((law.cumulative(law.quantile(p)) - p).abs() < 1e-9, "{law:?}: {p}");
            }
        }
    }

    #[test]
    fn the_distribution_function_is_the_integral_of_the_density() {
        for law in [ErrorLaw::Student, ErrorLaw::Gaussian] {
            let constant = likelihood(vec![datum(Reading::Value(0.0), 1.0)], law).constant().exp();
            for (low, high) in [(-3.0, -1.0), (-1.0, 0.5), (0.5, 6.0)] {
                let width = (high - low) / 2000.0;
                let density = |k: i32| law.log_density(low + (f64::from(k) + 0.5) * width).exp();
                let integral = constant * width * (0..2000).map(density).sum::<f64>();
                let expected = law.cumulative(high) - law.cumulative(low);
                assert!((integral - expected).abs() < 1e-6, "{law:?} {integral} {expected}");
            }
        }
    }

    #[test]
    fn the_far_tail_of_the_student_law_is_continuous() {
        let [before, after] = [-99.999, -100.001].map(|r| ErrorLaw::Student.cumulative(r));
        assert!((before / after - 1.0).abs() < 2e-3, "{before} {after}");
    }

    #[test]
    fn a_censored_reading_has_the_probability_of_its_side() {
        for (reading, expected) in [
            (Reading::AtMost(3.0), normal::cumulative(1.0)),
            (Reading::AtLeast(3.0), normal::cumulative(-1.0)),
            (Reading::Within([1.0, 3.0]), 1.0 - 2.0 * normal::cumulative(-1.0)),
        ] {
            let own = likelihood(vec![datum(reading, 1.0)], ErrorLaw::Gaussian);
            let got = own.total(&[], &[Prediction::Value(2.0)]).exp();
            assert!((got - expected).abs() < 1e-12, "{reading:?}: {got}");
        }
    }

    #[test]
    fn a_shared_error_moves_the_prediction() {
        for reading in [Reading::Value(3.0), Reading::AtMost(3.0), Reading::AtLeast(3.0)] {
            let mut own = datum(reading, 0.7);
            own.shared = vec![SharedError {
                variable: 1,
                coefficient: 0.5,
            }];
            let with = likelihood(vec![own], ErrorLaw::Student).total(&[9.0, 2.0], &[Prediction::Value(1.5)]);
            let moved = likelihood(vec![datum(reading, 0.7)], ErrorLaw::Student);
            assert!((with - moved.total(&[9.0, 2.0], &[Prediction::Value(2.5)])).abs() < 1e-12);
        }
    }

    #[test]
    fn an_event_beyond_the_record_is_a_lower_bound_and_a_missing_one_is_impossible() {
        let own = likelihood(vec![datum(Reading::Value(3.0), 1.0)], ErrorLaw::Gaussian);
        let of = |prediction| own.total(&[], &[prediction]);
        assert!((of(Prediction::AtLeast(2.0)).exp() - normal::cumulative(1.0)).abs() < 1e-12);
        assert_eq!(of(Prediction::Missing), f64::NEG_INFINITY);
    }

    #[test]
    fn correlated_errors_have_the_bivariate_normal_density() {
        let data = vec![datum(Reading::Value(1.0), 2.0), datum(Reading::Value(-1.0), 0.5)];
        let correlation = ErrorCorrelation {
            data: vec![0, 1],
            r: 0.6,
            parts: vec![2.0, 0.5],
        };
        let own = Likelihood::new(data, 1, std::slice::from_ref(&correlation), ErrorLaw::Gaussian).unwrap();
        let got = own.total(&[], &[Prediction::Value(0.0), Prediction::Value(0.0)]) + own.constant();
        let (x, y, r) = (0.5, -2.0, 0.6_f64);
        let exponent = -(x * x - 2.0 * r * x * y + y * y) / (2.0 * (1.0 - r * r));
        let expected = exponent - (2.0 * std::f64::consts::PI * 2.0 * 0.5 * (1.0 - r * r).sqrt()).ln();
        assert!((got - expected).abs() < 1e-12, "{got} {expected}");
    }

    #[test]
    fn measured_values_have_the_stated_errors_and_correlations() {
        let data = vec![datum(Reading::Value(0.0), 2.0), datum(Reading::Value(0.0), 0.5)];
        let correlation = ErrorCorrelation {
            data: vec![0, 1],
            r: 0.6,
            parts: vec![2.0, 0.5],
        };
        let own = Likelihood::new(data, 1, &[correlation], ErrorLaw::Gaussian).unwrap();
        let stream = crate::random::Stream::new(3, &[]);
        let measured = |k: u64| {
            let shares = [stream.uniform(2 * k), stream.uniform(2 * k + 1)];
            let readings = own.measured(&[], &[Prediction::Value(1.0), Prediction::Value(-3.0)], &shares);
            let errors: Vec<f64> = readings
                .iter()
                .zip([1.0, -3.0])
                .map(|(own, f)| own.nearest(0.0) - f)
                .collect();
            [errors[0] / 2.0, errors[1] / 0.5]
        };
        let all: Vec<[f64; 2]> = (0..20_000).map(measured).collect();
        let mean = |of: &dyn Fn(&[f64; 2]) -> f64| all.iter().map(of).sum::<f64>() / 20_000.0;
        for (found, expected) in [
            (mean(&|e| e[0]), 0.0),
            (mean(&|e| e[0] * e[0]), 1.0),
            (mean(&|e| e[1] * e[1]), 1.0),
            (mean(&|e| e[0] * e[1]), 0.6),
        ] {
            assert!((found - expected).abs() < 0.03, "{found}, expected {expected}");
        }
    }

    #[test]
    fn a_bound_is_measured_as_the_side_of_the_value() {
        let of = |reading: Reading, value: f64| {
            let own = likelihood(vec![datum(reading, 1e-9)], ErrorLaw::Student);
            own.measured(&[], &[Prediction::Value(value)], &[0.4])[0]
        };
        assert_eq!(of(Reading::AtMost(3.0), 2.0), Reading::AtMost(3.0));
        assert_eq!(of(Reading::AtMost(3.0), 4.0), Reading::AtLeast(3.0));
        assert_eq!(of(Reading::AtLeast(3.0), 2.0), Reading::AtMost(3.0));
        assert_eq!(of(Reading::Within([1.0, 3.0]), 2.0), Reading::Within([1.0, 3.0]));
        assert_eq!(of(Reading::Within([1.0, 3.0]), 0.0), Reading::AtMost(1.0));
        assert_eq!(of(Reading::Within([1.0, 3.0]), 9.0), Reading::AtLeast(3.0));
    }

    #[test]
    fn impossible_correlations_are_refused() {
        let data: Vec<Datum> = (0..3).map(|_| datum(Reading::Value(0.0), 1.0)).collect();
        let correlation = ErrorCorrelation {
            data: vec![0, 1, 2],
            r: -0.6,
            parts: vec![1.0; 3],
        };
        let error = Likelihood::new(data, 1, &[correlation], ErrorLaw::Student).unwrap_err();
        assert!(matches!(error, LikelihoodError::Indefinite { .. }));
    }

    #[test]
    fn sums_by_steps_are_the_total() {
        let mut data: Vec<Datum> = (0..4).map(|k| datum(Reading::Value(f64::from(k)), 1.0)).collect();
        for (own, condition) in data.iter_mut().zip([0, 1, 1, 0]) {
            own.condition = condition;
        }
        let correlation = ErrorCorrelation {
            data: vec![0, 2],
            r: 0.3,
            parts: vec![1.0; 2],
        };
        let own = Likelihood::new(data, 2, &[correlation], ErrorLaw::Student).unwrap();
        let predictions = [0.3, 0.2, -1.0, 2.0].map(Prediction::Value);
        let steps: f64 = (1..=2).map(|known| own.of_step(known, &[], &predictions)).sum();
        assert!((steps - own.total(&[], &predictions)).abs() < 1e-12);
    }
}
