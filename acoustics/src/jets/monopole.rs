use super::opening::{FlowHistory, Opening};
use crate::air::Air;
use crate::checks::{InputError, positive};
use crate::signals::fourier::{FourierError, Transform, TransformSettings};
use rustfft::num_complex::Complex;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Resonance of the air in the openings with the compliance of the plenum behind them.
///
/// ```text
/// f_0 = (c/2 pi) sqrt(A / (V L'))        H = 1 / [1 - (f/f_0)^2 + j f/(f_0 Q)]
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PlenumResonance {
    /// Volume V of the plenum \[m³\].
    pub volume: f64,
    /// Length L' of the openings, including end corrections \[m\].
    pub neck_length: f64,
    /// Quality factor Q.
    pub quality: f64,
}

impl PlenumResonance {
    /// Resonance frequency f_0 \[Hz\] for a plenum filled with the gas of `air` at the given temperature \[K\].
    pub fn frequency(&self, opening: &Opening, temperature: f64, air: &Air) -> f64 {
        let c = (air.heat_ratio * air.gas_constant * temperature).sqrt();
        c / (2.0 * PI) * (opening.area() / (self.volume * self.neck_length)).sqrt()
    }

    /// |H|² at the frequency `hz`, for the resonance frequency `resonance_hz`.
    pub fn gain(&self, hz: f64, resonance_hz: f64) -> f64 {
        self.response(hz, resonance_hz).norm_sqr()
    }

    /// H at the frequency `hz`, causal.
    fn response(&self, hz: f64, resonance_hz: f64) -> Complex<f64> {
        let x = hz / resonance_hz;
        Complex::new(1.0 - x * x, x / self.quality).inv()
    }

    pub(super) fn check(&self) -> Result<(), InputError> {
        positive("plenum volume [m3]", self.volume)?;
        positive("neck length of the exhaust [m]", self.neck_length)?;
        positive("quality factor of the plenum", self.quality).map(drop)
    }
}

/// Frequencies \[Hz\] and signal x(f) of the unsteady outflow as a monopole in free space; E = 2 |x|².
///
/// ```text
/// E(f) = 2 |H F{d(m' T_0/T_a)/dt}|^2 / (4 pi rho0 c0)
/// ```
///
/// The derivative is computed from differences between samples and corrected for their transfer function sinc(pi f dt).
/// It is exact for a record without components above half the sampling frequency. H is 1, or the response of the plenum
/// with its resonance frequency.
pub(super) fn monopole(
    history: &FlowHistory,
    air: &Air,
    settings: &TransformSettings,
    plenum: Option<(&PlenumResonance, f64)>,
) -> Result<(Vec<f64>, Vec<Complex<f64>>), FourierError> {
    let dt = history.sample_interval;
    let source: Vec<f64> = history
        .mass_flow
        .iter()
        .zip(&history.temperature)
        .map(|(flow, temperature)| flow.max(0.0) * temperature / air.temperature)
        .collect();
    let derivative: Vec<f64> = source.windows(2).map(|pair| (pair[1] - pair[0]) / dt).collect();
    let transform = Transform::new(derivative.len(), dt, settings)?;
    let frequency = transform.frequencies();
    let signal = |(hz, x): (&f64, Complex<f64>)| {
        let phase = PI * hz * dt;
        // A difference quotient belongs to the midpoint between its samples.
        let middle = Complex::from_polar(phase / phase.sin() / (4.0 * PI * air.impedance()).sqrt(), -phase);
        let filter = plenum.map_or(Complex::ONE, |(plenum, f0)| plenum.response(*hz, f0));
        middle * filter * x
    };
    let signals = frequency
        .iter()
        .zip(transform.apply(&derivative)?)
        .map(signal)
        .collect();
    Ok((frequency, signals))
}
