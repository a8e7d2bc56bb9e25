//! Quantiles and probabilities of the normal distribution and of Student's t.

use statrs::distribution::{ContinuousCDF, StudentsT};

/// The two-sided quantile of Student's t: |t| exceeds it with probability 1 - `confidence`.
pub fn student_t(confidence: f64, degrees_of_freedom: f64) -> f64 {
    StudentsT::new(0.0, 1.0, degrees_of_freedom.max(1.0))
        .map_or(f64::INFINITY, |t| t.inverse_cdf(0.5 + 0.5 * confidence))
}

/// The quantile of N(0, 1) for the probability `share` (0..1).
pub fn standard_normal(share: f64) -> f64 {
    // A share of 0 would give an infinite quantile; 2^-54 is less than half of the next larger value.
    let share = share.max(0.5 * f64::EPSILON * 0.25);
    -f64::sqrt(2.0) * statrs::function::erf::erfc_inv(2.0 * share)
}

/// Two-sided probability that |t| exceeds this value.
pub fn probability_beyond(t: f64, degrees_of_freedom: f64) -> f64 {
    StudentsT::new(0.0, 1.0, degrees_of_freedom.max(1.0)).map_or(f64::NAN, |law| 2.0 * law.sf(t.abs()))
}
