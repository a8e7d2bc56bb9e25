use rustfft::num_complex::Complex;
use serde::{Deserialize, Serialize};

/// Pole frequencies f_1 .. f_4 of the weightings \[Hz\] (IEC 61672-1:2013, 5.4 and annex E).
const F1: f64 = 20.598_997;
const F2: f64 = 107.652_65;
const F3: f64 = 737.862_23;
const F4: f64 = 12_194.217;

/// Frequency weighting of IEC 61672-1:2013.
///
/// ```text
/// A(f) = 20 lg[ f4^2 f^4 / ((f^2 + f1^2) sqrt(f^2 + f2^2) sqrt(f^2 + f3^2) (f^2 + f4^2)) ] - A_1000
/// C(f) = 20 lg[ f4^2 f^2 / ((f^2 + f1^2) (f^2 + f4^2)) ] - C_1000
/// Z(f) = 0
/// ```
///
/// A_1000 and C_1000 make the weighting 0 dB at 1 kHz; the standard rounds them to -2.000 and -0.062 dB.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Weighting {
    /// A: sensitivity of the ear at moderate levels.
    A,
    /// C, nearly flat.
    C,
    /// Z: no weighting.
    Z,
}

impl Weighting {
    /// The factor 10^{A(f)/10} on energy at the frequency `hz`.
    pub fn energy_factor(self, hz: f64) -> f64 {
        let f = hz * hz;
        let ratio = match self {
            Self::A => return a_squared(f) / a_squared(1e6),
            Self::C => f / ((f + F1 * F1) * (f + F4 * F4)) / (1e6 / ((1e6 + F1 * F1) * (1e6 + F4 * F4))),
            Self::Z => return 1.0,
        };
        ratio * ratio
    }

    /// The amplitude factor, with the phase of the causal filter with these poles (IEC 61672-1:2013, annex E).
    ///
    /// ```text
    /// H_A(s) ~ s^4 / ((s + w1)^2 (s + w2) (s + w3) (s + w4)^2)        H_C(s) ~ s^2 / ((s + w1)^2 (s + w4)^2)
    /// ```
    pub fn response(self, hz: f64) -> Complex<f64> {
        let pole = |corner: f64| Complex::new(corner, hz).inv();
        let outer = (pole(F1) * pole(F4)).powi(2);
        let shape = match self {
            Self::A => outer * pole(F2) * pole(F3),
            Self::C => -outer,
            Self::Z => Complex::ONE,
        };
        // The sign of s^4 and s^2 on the frequency axis is in `shape`; at 0 Hz both weightings vanish.
        shape / shape.norm() * self.energy_factor(hz).sqrt()
    }

    /// The weighting in decibels at the frequency `hz`; minus infinity for A and C at 0 Hz.
    pub fn db(self, hz: f64) -> f64 {
        10.0 * self.energy_factor(hz).log10()
    }
}

/// Square of the A-weighting's amplitude up to a constant, from the squared frequency `f`.
fn a_squared(f: f64) -> f64 {
    let near = f / (f + F1 * F1);
    let far = f / (f + F4 * F4);
    near * near * far * far / ((f + F2 * F2) * (f + F3 * F3))
}
