//! Gauss-Legendre quadrature.

use std::num::NonZeroUsize;

use gauss_quad::GaussLegendre;

/// Points and weights of the Gauss-Legendre rule with `n` points on \[-1, 1\], in ascending order, exact for
/// polynomials of degree 2n - 1; empty for n = 0.
pub fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    let Some(points) = NonZeroUsize::new(n) else {
        return Vec::new();
    };
    let mut rule = GaussLegendre::new(points).into_node_weight_pairs().into_vec();
    // The library's points are symmetric only up to rounding, and its middle point is not exactly zero.
    for i in 0..n / 2 {
        let (x, weight) = rule[n - 1 - i];
        rule[i] = (-x, weight);
    }
    if n % 2 == 1 {
        rule[n / 2].0 = 0.0;
    }
    rule
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rule_integrates_its_degree_exactly_and_no_more() {
        for n in 1..=10 {
            let rule = gauss_legendre(n);
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
            let rule = gauss_legendre(n);
            assert!(rule.windows(2).all(|pair| pair[1].0 > pair[0].0));
            for degree in (0..2 * n).step_by(2) {
                let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(degree as i32)).sum();
                let exact = 2.0 / (degree as f64 + 1.0);
                assert!((sum - exact).abs() < 1e-13, "n {n}, degree {degree}: {sum}");
            }
        }
    }

    #[test]
    fn a_rule_is_symmetric_to_the_last_bit() {
        for n in 0..70 {
            let rule = gauss_legendre(n);
            let mirrored: Vec<(f64, f64)> = rule.iter().rev().map(|&(x, w)| (0.0 - x, w)).collect();
            assert_eq!(rule, mirrored);
        }
    }
}
