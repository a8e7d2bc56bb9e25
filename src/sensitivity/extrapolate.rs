//! A derivative from differences at decreasing steps, with an error estimate.

/// A derivative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Estimate {
    pub(super) value: f64,
    pub(super) error: f64,
    /// The smallest step used.
    pub(super) step: f64,
}

/// Extrapolates differences at the steps h, h/2, h/4, ... to a step of zero (Ridders, "Accurate computation of F'(x)
/// and F'(x) F''(x)", 1982).
///
/// `order` is the power of the step between terms of the error: 2 for central differences, 1 for one-sided ones.
/// `noise` is the error of a value for reasons other than the parameter; the difference at a small step contains it
/// divided by the step. Of all entries of the tableau
/// ```text
/// D_k0 = difference at h/2^k,  D_km = D_k,m-1 + (D_k,m-1 - D_k-1,m-1)/(2^(order m) - 1)
/// ```
/// the one with the smallest error is taken. Its error is the larger of its distance to its two ancestors and its
/// noise. In the first column, the noise is `noise` divided by the step, and it propagates through the tableau with the
/// sum of the weights' magnitudes. At long steps, truncation makes the first term large; at short ones, noise makes the
/// second large. A missing difference ends the tableau; fewer than two yield `None`.
pub(super) fn extrapolate(differences: &[Option<f64>], first: f64, order: i32, noise: f64) -> Option<Estimate> {
    let known: Vec<(usize, f64)> = differences
        .iter()
        .enumerate()
        .filter_map(|(k, d)| Some((k, (*d)?)))
        .collect();
    // Long steps that are missing because the design would not be valid leave a shorter tableau.
    let start = known.first()?.0;
    let run: Vec<f64> = known
        .iter()
        .enumerate()
        .take_while(|(i, (k, _))| start + i == *k)
        .map(|(_, (_, d))| *d)
        .collect();
    let mut best: Option<Estimate> = None;
    let (mut previous, mut carried): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
    for (k, difference) in run.iter().enumerate() {
        let step = first / f64::from(1_u32 << (start + k));
        let (mut row, mut noises) = (vec![*difference], vec![noise / step]);
        for m in 1..=k {
            let (same, before) = (row[m - 1], previous[m - 1]);
            let weight = 1.0 / (2f64.powi(order * m as i32) - 1.0);
            let value = same + (same - before) * weight;
            row.push(value);
            noises.push(noises[m - 1] * (1.0 + weight) + carried[m - 1] * weight);
            let error = (value - same).abs().max((value - before).abs()).max(noises[m]);
            if best.is_none_or(|best| error < best.error) {
                best = Some(Estimate { value, error, step });
            }
        }
        (previous, carried) = (row, noises);
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    fn central(f: impl Fn(f64) -> f64, x: f64, h: f64) -> Vec<Option<f64>> {
        let step = |k: i32| h / 2f64.powi(k);
        (0..4)
            .map(|k| Some((f(x + step(k)) - f(x - step(k))) / (2.0 * step(k))))
            .collect()
    }

    #[test]
    fn smooth_functions_lose_their_truncation() {
        let d = extrapolate(&central(f64::exp, 1.0, 0.2), 0.2, 2, 0.0).unwrap();
        assert!(
            (d.value - 1f64.exp()).abs() < 1e-10 && (d.value - 1f64.exp()).abs() <= d.error,
            "{d:?}"
        );
        let forward: Vec<_> = (0..5)
            .map(|k| 0.2 / 2f64.powi(k))
            .map(|h| Some((h.exp() - 1.0) / h))
            .collect();
        let d = extrapolate(&forward, 0.2, 1, 0.0).unwrap();
        assert!(
            (d.value - 1.0).abs() < 1e-6 && (d.value - 1.0).abs() <= d.error,
            "{d:?}"
        );
    }

    #[test]
    fn noise_is_within_the_error_and_asks_for_a_long_step() {
        let noisy = |x: f64| x.exp() + 1e-4 * (1e5 * x).sin();
        let d = extrapolate(&central(noisy, 1.0, 0.2), 0.2, 2, 1e-4).unwrap();
        assert!((d.value - 1f64.exp()).abs() <= d.error, "{d:?}");
        assert!(d.step >= 0.05, "{d:?}");
    }

    #[test]
    fn a_kink_has_a_large_error() {
        let d = extrapolate(&central(|x: f64| (x - 0.03).abs(), 0.0, 0.2), 0.2, 2, 0.0).unwrap();
        assert!(d.error > 0.1 || (d.value + 1.0).abs() <= d.error + 1e-12, "{d:?}");
    }

    #[test]
    fn missing_differences_shorten_the_tableau() {
        let mut differences = central(f64::sin, 0.3, 0.2);
        differences[0] = None;
        let d = extrapolate(&differences, 0.2, 2, 0.0).unwrap();
        assert!((d.value - 0.3f64.cos()).abs() < 1e-8);
        assert_eq!(extrapolate(&[None, None, Some(1.0)], 0.2, 2, 0.0), None);
        assert_eq!(extrapolate(&[], 0.2, 2, 0.0), None);
    }
}
