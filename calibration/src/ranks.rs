//! Simulation-based calibration: a check of posteriors whose truth is known (Talts, Betancourt, Simpson, Vehtari and
//! Gelman, "Validating Bayesian inference algorithms with simulation-based calibration", arXiv:1804.06788 (2018)).
//!
//! A truth is drawn from the prior, measured with the errors of the likelihood, and calibrated. If prior, likelihood
//! and sampler agree, the place of the truth among the draws of its posterior is uniform between 0 and 1. Posteriors
//! that are too narrow push the places to both ends; posteriors that are too wide push them to the middle.
//!
//! The test is that of Anderson and Darling, which weights the ends:
//!
//! ```text
//! A^2 = -n - 1/n sum_i (2 i - 1) [ln u_i + ln(1 - u_(n+1-i))],    u_1 <= .. <= u_n
//! ```

/// Smallest number of places that is tested: the approximation of the probability is valid for 8 or more.
const FEWEST: usize = 8;

/// A test of uniform places.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uniformity {
    /// A^2.
    pub statistic: f64,
    /// Probability of at least this value for uniform places.
    pub p: f64,
}

/// The place of a truth among draws, 0 to 1; `share` in (0, 1) is its place between two draws, and among equal ones.
/// NaN draws do not count. None without draws, or if the truth is NaN.
///
/// With `share` uniform, the place is uniform if the truth is distributed like the draws.
pub fn place(truth: f64, draws: impl IntoIterator<Item = f64>, share: f64) -> Option<f64> {
    let (mut below, mut equal, mut count) = (0_u32, 0_u32, 0_u32);
    for draw in draws.into_iter().filter(|own| !own.is_nan()) {
        count += 1;
        below += u32::from(draw < truth);
        equal += u32::from(draw == truth);
    }
    let is_known = count > 0 && !truth.is_nan();
    is_known.then(|| (f64::from(below) + share * f64::from(equal + 1)) / f64::from(count + 1))
}

/// Tests whether places are uniform; none for fewer than 8.
pub fn uniformity(places: &[f64]) -> Option<Uniformity> {
    let count = places.len();
    if count < FEWEST {
        return None;
    }
    let mut sorted: Vec<f64> = places.iter().map(|own| own.clamp(1e-12, 1.0 - 1e-12)).collect();
    sorted.sort_by(f64::total_cmp);
    let n = count as f64;
    let pairs = sorted.iter().zip(sorted.iter().rev()).enumerate();
    let sum: f64 = pairs
        .map(|(k, (low, high))| (2 * k + 1) as f64 * (low.ln() + (-high).ln_1p()))
        .sum();
    let statistic = -n - sum / n;
    let below = limit(statistic);
    let p = (1.0 - below - correction(count, below)).clamp(0.0, 1.0);
    Some(Uniformity { statistic, p })
}

/// Distribution function of A^2 for many places (Marsaglia and Marsaglia, "Evaluating the Anderson-Darling
/// distribution", Journal of Statistical Software 9, 2 (2004)).
fn limit(z: f64) -> f64 {
    if z <= 0.0 {
        return 0.0;
    }
    let polynomial = |coefficients: &[f64]| coefficients.iter().rev().fold(0.0, |sum, own| sum * z + own);
    if z < 2.0 {
        let series = polynomial(&[2.000_12, 0.247_105, -0.064_982_1, 0.034_796_2, -0.011_672, 0.001_686_91]);
        (-1.233_714_1 / z).exp() / z.sqrt() * series
    } else {
        let series = polynomial(&[1.0776, -2.306_95, 0.434_24, -0.082_433, 0.008_056, -0.000_314_6]);
        (-series.exp()).exp()
    }
}

/// Difference of the distribution function for `count` places from its limit x (same source).
fn correction(count: usize, x: f64) -> f64 {
    let n = count as f64;
    let polynomial = |t: f64, coefficients: &[f64]| coefficients.iter().rev().fold(0.0, |sum, own| sum * t + own);
    let start = 0.012_65 + 0.1757 / n;
    if x > 0.8 {
        polynomial(x, &[-130.2137, 745.2337, -1705.091, 1950.646, -1116.360, 255.7844]) / n
    } else if x < start {
        let t = x / start;
        let shape = t.sqrt() * (1.0 - t) * (49.0 * t - 102.0);
        shape * (0.0037 / (n * n) + 0.000_78 / n + 0.000_06) / n
    } else {
        let t = (x - start) / (0.8 - start);
        let shape = polynomial(t, &[-0.000_226_33, 6.540_34, -14.6538, 14.458, -8.259, 1.918_64]);
        shape * (0.042_13 + 0.013_65 / n) / n
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::random::Stream;

    #[test]
    fn the_limit_has_the_tabulated_quantiles() {
        // D'Agostino and Stephens, "Goodness-of-fit techniques", 1986, table 4.2.
        for (z, p) in [
            (1.248, 0.75),
            (1.933, 0.90),
            (2.492, 0.95),
            (3.070, 0.975),
            (3.880, 0.99),
        ] {
            assert!((limit(z) - p).abs() < 1e-3, "{z}: {}", limit(z));
        }
    }

    #[test]
    fn uniform_places_have_uniform_probabilities() {
        for count in [8, 20, 100] {
            let probability = |run: u64| {
                let stream = Stream::new(count as u64, &[run]);
                let places: Vec<f64> = (0..count as u64).map(|k| stream.uniform(k)).collect();
                uniformity(&places).unwrap().p
            };
            let all: Vec<f64> = (0..4000).map(probability).collect();
            for level in [0.01, 0.05, 0.2, 0.5, 0.9] {
                let share = all.iter().filter(|own| **own < level).count() as f64 / 4000.0;
                let error = (level * (1.0 - level) / 4000.0_f64).sqrt();
                assert!(
                    (share - level).abs() < 4.0 * error + 1e-3,
                    "{count}: {share} below {level}"
                );
            }
        }
    }

    #[test]
    fn places_at_both_ends_and_in_the_middle_are_not_uniform() {
        let of = |shape: fn(f64) -> f64| {
            let places: Vec<f64> = (0..40).map(|k| shape((f64::from(k) + 0.5) / 40.0)).collect();
            uniformity(&places).unwrap().p
        };
        assert!(of(|u| u) > 0.99);
        assert!(of(|u| 0.5 + 0.5 * (2.0 * u - 1.0).abs().cbrt().copysign(u - 0.5)) < 0.03);
        assert!(of(|u| 0.25 + 0.5 * u) < 0.03);
        assert!(of(|u| u * u) < 0.01);
        assert_eq!(uniformity(&[0.5; 7]), None);
    }

    #[test]
    fn a_truth_is_placed_among_its_draws() {
        assert_eq!(place(2.5, [1.0, 2.0, 3.0], 0.5), Some(0.625));
        // Two equal draws share their part with the truth.
        assert_eq!(place(2.0, [2.0, 2.0, 5.0], 0.5), Some(0.375));
        assert_eq!(place(2.0, [1.0, f64::NAN], 0.5), Some(0.75));
        assert_eq!(place(f64::NAN, [1.0], 0.5), None);
        assert_eq!(place(1.0, [f64::NAN], 0.5), None);
    }
}
