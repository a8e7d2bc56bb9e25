use super::opening::{FlowHistory, Opening};
use crate::air::{Air, GAS_CONSTANT, HEAT_RATIO};
use crate::error::{AcousticsError, positive};
use crate::fourier::{Transform, TransformSettings};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Resonance of the air in the openings on the plenum behind them.
///
/// ```text
/// f_0 = (c/2 pi) sqrt(A / (V L'))        |H|^2 = 1 / [(1 - (f/f_0)^2)^2 + (f/(f_0 Q))^2]
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PlenumResonance {
    /// Volume V of the plenum \[m³\].
    pub volume: f64,
    /// Length L' of the openings with end corrections \[m\].
    pub neck_length: f64,
    /// Quality factor Q.
    pub quality: f64,
}

impl PlenumResonance {
    /// Resonance frequency f_0 \[Hz\] with air of the given temperature \[K\] in the plenum.
    pub fn frequency(&self, opening: &Opening, temperature: f64) -> f64 {
        let c = (HEAT_RATIO * GAS_CONSTANT * temperature).sqrt();
        c / (2.0 * PI) * (opening.area() / (self.volume * self.neck_length)).sqrt()
    }

    /// |H|² at the frequency `hz` for the resonance frequency `resonance_hz`.
    pub fn gain(&self, hz: f64, resonance_hz: f64) -> f64 {
        let x = hz / resonance_hz;
        1.0 / ((1.0 - x * x).powi(2) + (x / self.quality).powi(2))
    }

    pub(super) fn check(&self) -> Result<(), AcousticsError> {
        positive("plenum volume [m3]", self.volume)?;
        positive("neck length of the exhaust [m]", self.neck_length)?;
        positive("quality factor of the plenum", self.quality).map(drop)
    }
}

/// Frequencies \[Hz\] and energy density \[J/Hz\] of the unsteady outflow as a monopole in free space.
///
/// ```text
/// E(f) = 2 |F{d(m' T_0/T_a)/dt}|^2 / (4 pi rho0 c0)
/// ```
///
/// The derivative is taken between samples and freed of the difference quotient's sinc(pi f dt), so that it is exact
/// for a record without content above half the sampling frequency.
pub(super) fn monopole(
    history: &FlowHistory,
    air: &Air,
    settings: &TransformSettings,
) -> Result<(Vec<f64>, Vec<f64>), AcousticsError> {
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
    let energy = |(hz, x): (&f64, rustfft::num_complex::Complex<f64>)| {
        let phase = PI * hz * dt;
        let exact = phase / phase.sin();
        2.0 * exact * exact * x.norm_sqr() / (4.0 * PI * air.impedance())
    };
    let density = frequency
        .iter()
        .zip(transform.apply(&derivative)?)
        .map(energy)
        .collect();
    Ok((frequency, density))
}
