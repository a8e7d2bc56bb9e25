//! Gauss-Legendre quadrature.

use crate::MeshError;

/// Points and weights of the Gauss-Legendre rule with `n` points on \[-1, 1\], exact for polynomials of degree 2n - 1.
///
/// The points are the roots of the Legendre polynomial P_n, found by Newton's method from Tricomi's estimate; the
/// weights are w = 2 / ((1 - x^2) P_n'(x)^2) (Abramowitz & Stegun 25.4.29).
///
/// # Errors
/// [`MeshError::GaussPoints`] for n = 0.
pub fn gauss_legendre(n: usize) -> Result<Vec<(f64, f64)>, MeshError> {
    if n == 0 {
        return Err(MeshError::GaussPoints { points: n });
    }
    Ok((1..=n)
        .map(|i| {
            let mut x = -(std::f64::consts::PI * (i as f64 - 0.25) / (n as f64 + 0.5)).cos();
            for _ in 0..20 {
                let (p, dp) = legendre(n, x);
                let change = p / dp;
                x -= change;
                if change.abs() < 1e-15 {
                    break;
                }
            }
            // The middle root of an odd rule is zero exactly.
            if 2 * i == n + 1 {
                x = 0.0;
            }
            let dp = legendre(n, x).1;
            (x, 2.0 / ((1.0 - x * x) * dp * dp))
        })
        .collect())
}

/// P_n(x) and P_n'(x) by the three-term recurrence.
fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut p0, mut p1) = (1.0, x);
    for k in 1..n {
        let k = k as f64;
        (p0, p1) = (p1, ((2.0 * k + 1.0) * x * p1 - k * p0) / (k + 1.0));
    }
    (p1, n as f64 * (x * p1 - p0) / (x * x - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rule_integrates_its_degree_exactly_and_no_more() {
        for n in 1..=10 {
            let rule = gauss_legendre(n).unwrap();
            for degree in 0..=2 * n {
                let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(degree as i32)).sum();
                let exact = if degree % 2 == 0 {
                    2.0 / (degree as f64 + 1.0)
                } else {
                    0.0
                };
                if degree < 2 * n {
                    assert!(
                        (sum - exact).abs() < 1e-14,
                        "n {n}, degree {degree}: {sum} against {exact}"
                    );
                } else {
                    assert!((sum - exact).abs() > 1e-7);
                }
            }
        }
    }

    #[test]
    fn long_rules_integrate_even_powers() {
        for n in [33, 48, 64, 200] {
            let rule = gauss_legendre(n).unwrap();
            assert!(rule.windows(2).all(|pair| pair[1].0 > pair[0].0));
            for degree in (0..2 * n).step_by(2) {
                let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(degree as i32)).sum();
                let exact = 2.0 / (degree as f64 + 1.0);
                assert!((sum - exact).abs() < 1e-13, "n {n}, degree {degree}: {sum}");
            }
        }
    }

    #[test]
    fn a_rule_without_points_is_refused() {
        assert!(gauss_legendre(0).is_err());
    }
}
