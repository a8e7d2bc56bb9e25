//! Locates sign changes on an interpolant.

/// Last point of the narrowest bracket of a sign change of `f` between `a` and `b` (Illinois variant of regula falsi,
/// Dowell and Jarratt 1971, safeguarded by bisection). The point returned has the sign of `fb`.
pub(crate) fn locate<E>(
    mut a: f64,
    mut b: f64,
    mut fa: f64,
    mut fb: f64,
    mut f: impl FnMut(f64) -> Result<f64, E>,
) -> Result<f64, E> {
    let positive = fb > 0.0;
    let mut side = 0;
    for iteration in 0..60 {
        let (width, least) = (b - a, 2.0 * f64::EPSILON * b.abs());
        if width <= 2.0 * least {
            break;
        }
        let mut c = b - fb * width / (fb - fa);
        // Jumps and flat sections slow the secant method down.
        if iteration % 8 == 7 || !(a..=b).contains(&c) {
            c = a + 0.5 * width;
        }
        // A secant that hits the root from one side would never move the other end.
        c = c.clamp(a + least, b - least);
        if !(c > a && c < b) {
            break;
        }
        let fc = f(c)?;
        if (fc > 0.0) == positive {
            (b, fb) = (c, fc);
            if side == -1 {
                fa *= 0.5;
            }
            side = -1;
            if fc == 0.0 {
                break;
            }
        } else {
            (a, fa) = (c, fc);
            if side == 1 {
                fb *= 0.5;
            }
            side = 1;
        }
    }
    Ok(b)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Where `f` changes sign in 0..1, and the number of evaluations needed.
    fn found(f: impl Fn(f64) -> f64) -> (f64, usize) {
        let mut count = 0;
        let counted = |x: f64| {
            count += 1;
            Ok::<_, std::convert::Infallible>(f(x))
        };
        (locate(0.0, 1.0, f(0.0), f(1.0), counted).unwrap(), count)
    }

    #[test]
    fn sign_changes_are_found_to_the_last_digits_from_their_far_side() {
        type Function = (fn(f64) -> f64, f64);
        let functions: [Function; 5] = [
            (|x| x - 0.3, 0.3),
            (|x| 0.3 - x, 0.3),
            (|x| x * x * x - 0.001, 0.1),
            (|x| (40.0 * (x - 0.9)).exp() - 1.0, 0.9),
            (|x| if x < 0.7 { -1.0 } else { 2.0 }, 0.7),
        ];
        for (f, root) in functions {
            let (x, count) = found(f);
            assert!((x - root).abs() <= 1e-14 && count <= 60, "{root}: {x} after {count}");
            assert_eq!(f(x) > 0.0, f(1.0) > 0.0, "{root}");
        }
    }

    #[test]
    fn smooth_changes_take_few_evaluations() {
        assert!(found(|x| (x + 0.1).ln()).1 <= 12);
    }
}
