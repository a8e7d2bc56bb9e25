//! Acquisition function of a point: expected improvement multiplied by the probability that the constraints are met, in
//! logarithms.
//!
//! EI(x) = s h(z), z = (y_min - m(x))/s(x), h(z) = phi(z) + z Phi(z) (Jones et al. 1998, eq. 15), times the product of
//! P(c_k(x) <= 0) (Schonlau, Welch and Jones, "Global versus local search in constrained optimization", 1998). The
//! logarithms keep their gradient where both factors underflow (Ament et al., "Unexpected improvements to expected
//! improvement", 2023).

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use crate::kriging::Prediction;

/// Below this, asymptotic series replace differences of small numbers.
const ASYMPTOTIC: f64 = -6.0;

/// Minimum standard deviation: no improvement is expected at an observation.
const MIN_DEVIATION: f64 = 1e-12;

/// ln phi(z), the density of the normal distribution.
fn log_density(z: f64) -> f64 {
    -0.5 * (z * z + (2.0 * PI).ln())
}

/// Phi(z), the probability of a value less than z.
fn cumulative(z: f64) -> f64 {
    0.5 * libm::erfc(-z * FRAC_1_SQRT_2)
}

/// Logarithm of the expected improvement below `best`.
pub(crate) fn log_expected_improvement(own: Prediction, best: f64) -> f64 {
    let deviation = own.deviation.max(MIN_DEVIATION);
    let z = (best - own.mean) / deviation;
    let h = if z > ASYMPTOTIC {
        (log_density(z).exp() + z * cumulative(z)).ln()
    } else {
        // h = phi/z^2 (1 - 3/z^2 + 15/z^4 ...)
        log_density(z) - 2.0 * (-z).ln() + (-3.0 / (z * z) + 15.0 / z.powi(4)).ln_1p()
    };
    deviation.ln() + h
}

/// Logarithm of the probability that the smooth part is at most 0. With the roughness, every point would have a chance,
/// even next to points that violate the constraint by a step.
pub(crate) fn log_feasibility(own: Prediction) -> f64 {
    let z = -own.mean / own.smooth.max(MIN_DEVIATION);
    if z > ASYMPTOTIC {
        cumulative(z).ln()
    } else {
        // Phi = phi/|z| (1 - 1/z^2 + 3/z^4 ...)
        log_density(z) - (-z).ln() + (-1.0 / (z * z) + 3.0 / z.powi(4)).ln_1p()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(mean: f64, deviation: f64) -> Prediction {
        Prediction {
            mean,
            deviation,
            smooth: deviation,
        }
    }

    #[test]
    fn the_improvement_is_that_of_the_closed_form() {
        // EI of N(0, 1) below 0 is 1/sqrt(2 pi).
        assert!((log_expected_improvement(at(0.0, 1.0), 0.0) + 0.5 * (2.0 * PI).ln()).abs() < 1e-12);
        // Without uncertainty, it is the difference.
        assert!((log_expected_improvement(at(1.0, 1e-9), 3.0) - 2.0_f64.ln()).abs() < 1e-9);
    }

    #[test]
    fn series_continue_the_closed_forms_and_stay_finite() {
        for f in [log_feasibility, |own| log_expected_improvement(own, 0.0)] {
            let [near, far] = [-ASYMPTOTIC - 1e-6, -ASYMPTOTIC + 1e-6].map(|mean| f(at(mean, 1.0)));
            assert!((near - far).abs() < 5e-3, "{near} {far}");
            assert!(f(at(60.0, 1.0)).is_finite() && f(at(60.0, 1.0)) < f(at(50.0, 1.0)));
        }
    }

    #[test]
    fn a_constraint_at_its_limit_is_met_in_half_of_the_cases() {
        assert!((log_feasibility(at(0.0, 0.3)) - 0.5_f64.ln()).abs() < 1e-12);
        assert!(log_feasibility(at(-1.0, 0.1)).abs() < 1e-12);
    }
}
