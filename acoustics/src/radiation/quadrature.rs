use std::f64::consts::PI;

/// Nodes and weights of the `n`-point Gauss-Legendre rule on \[-1, 1\], by Newton's method.
pub(crate) fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    let legendre = |x: f64| {
        let (mut before, mut p) = (1.0, x);
        for k in 2..=n {
            let k = k as f64;
            (before, p) = (p, ((2.0 * k - 1.0) * x * p - (k - 1.0) * before) / k);
        }
        (p, n as f64 * (before - x * p) / (1.0 - x * x))
    };
    let node = |i: usize| {
        let mut x = -(PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
        for _ in 0..8 {
            let (p, dp) = legendre(x);
            x -= p / dp;
        }
        let (_, dp) = legendre(x);
        (x, 2.0 / ((1.0 - x * x) * dp * dp))
    };
    match n {
        0 => Vec::new(),
        1 => vec![(0.0, 2.0)],
        _ => (0..n).map(node).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::gauss_legendre;

    #[test]
    fn integrates_polynomials_to_its_degree() {
        for n in [1, 2, 3, 8, 33, 64] {
            let rule = gauss_legendre(n);
            for degree in (0..2 * n).step_by(2) {
                let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(degree as i32)).sum();
                assert!(
                    (sum - 2.0 / (degree as f64 + 1.0)).abs() < 1e-13,
                    "n = {n}, degree {degree}: {sum}"
                );
            }
        }
    }
}
