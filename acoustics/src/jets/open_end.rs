use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::LazyLock;

use nailnoise_meshes::gauss_legendre;
use nalgebra::Complex;

use crate::checks::InputError;

/// Highest k a: the first axisymmetric cross mode of the pipe, at the first positive zero of J_1.
const HIGHEST: f64 = 3.8317;

/// Number of quadrature points over 0 .. k a.
const POINTS: usize = 48;

/// The unflanged open end of a circular thin-walled pipe without mean flow; H. Levine and J. Schwinger, Phys. Rev. 73,
/// 383 (1948), equations (VI.4) and (VI.5).
///
/// ```text
/// R = -|R| exp(-2 j k l)                        r + j x = (1 + R)/(1 - R)
/// |R| = exp{-(2 ka/pi) int_0^ka theta(y) / (y sqrt((ka)^2 - y^2)) dy}       theta = atan2(J_1, -N_1)
/// l/a = (1/pi) int_0^ka ln[pi J_1 sqrt(J_1^2 + N_1^2)] / (y sqrt((ka)^2 - y^2)) dy
///     + (1/pi) int_0^inf ln[1/(2 I_1 K_1)] / (y sqrt(y^2 + (ka)^2)) dy
/// ```
///
/// At low frequency the end correction l/a evaluates to 0.6127, whereas the paper prints 0.6133.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpenEnd {
    /// Magnitude of the reflection factor.
    pub reflection: f64,
    /// End correction l/a.
    pub end_correction: f64,
    /// Radiation impedance r + j x, normalised by rho0 c0 / S.
    pub impedance: Complex<f64>,
}

impl OpenEnd {
    /// Evaluates the end at `ka`, the product of wavenumber and radius.
    ///
    /// # Errors
    /// [`InputError::OutsideRange`] unless 0 < `ka` <= 3.8317, above which cross modes propagate.
    pub fn new(ka: f64) -> Result<Self, InputError> {
        if !(ka > 0.0 && ka <= HIGHEST) {
            return Err(InputError::OutsideRange {
                what: "k a of the open end",
                value: ka,
                low: 0.0,
                high: HIGHEST,
            });
        }
        let (mut exponent, mut inner) = (0.0, 0.0);
        for &(y_over_ka, weight) in RULE.iter() {
            let y = ka * y_over_ka;
            let (j, n) = (libm::j1(y), libm::y1(y));
            exponent += weight * j.atan2(-n) / y_over_ka;
            inner += weight * (PI * j * j.hypot(n)).ln() / y;
        }
        let outer: f64 = LOGARITHMS.iter().map(|&(y, weight)| weight / y.hypot(ka)).sum();
        let reflection = (-2.0 / PI * exponent).exp();
        let end_correction = (inner + outer) / PI;
        let factor = -Complex::from_polar(reflection, -2.0 * ka * end_correction);
        Ok(Self {
            reflection,
            end_correction,
            impedance: (1.0 + factor) / (1.0 - factor),
        })
    }
}

/// Values of sin t with quadrature weights for t in 0 .. pi/2; the substitution y = k a sin t removes the square root
/// from the integrals. The points are dense near 0, where the third derivative of the logarithm grows: t = pi/2 s^3.
static RULE: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| {
    let point = |(x, weight): (f64, f64)| {
        let s = 0.5 * (1.0 + x);
        ((FRAC_PI_2 * s.powi(3)).sin(), 0.5 * weight * FRAC_PI_2 * 3.0 * s * s)
    };
    gauss_legendre(POINTS).into_iter().map(point).collect()
});

/// Values of y with ln[1/(2 I_1 K_1)] times the step of the trapezoidal rule in ln y, which converges exponentially.
static LOGARITHMS: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| {
    const STEP: f64 = 0.25;
    // Outside this range, the integrand is below 1e-15 of its maximum for every k a above 1e-4.
    (-100..=180)
        .map(|i| {
            let y = (f64::from(i) * STEP).exp();
            (y, STEP * -ln_twice_product(y))
        })
        .collect()
});

/// ln(2 I_1(y) K_1(y)): by series below 1e-3 and above 30 (DLMF 10.31, 10.40), otherwise by the integrals DLMF 10.32.3
/// and 10.32.9 with the trapezoidal rule.
fn ln_twice_product(y: f64) -> f64 {
    const EULER: f64 = 0.577_215_664_901_532_9;
    if y < 1e-3 {
        return (0.5 * y * y * ((0.5 * y).ln() + EULER - 0.25)).ln_1p();
    }
    if y > 30.0 {
        let y2 = y * y;
        return (-0.375 / y2 - 45.0 / (128.0 * y2 * y2)).ln_1p() - y.ln();
    }
    let steps = 128;
    let i1 = (0..steps)
        .map(|n| {
            let t = PI * (f64::from(n) + 0.5) / f64::from(steps);
            (y * (t.cos() - 1.0)).exp() * t.cos()
        })
        .sum::<f64>()
        / f64::from(steps);
    let step = 0.05;
    let k1 = (1..300)
        .map(|n| {
            let t = f64::from(n) * step;
            (-y * (t.cosh() - 1.0)).exp() * t.cosh()
        })
        .sum::<f64>()
        + 0.5;
    (2.0 * i1 * k1 * step).ln()
}
