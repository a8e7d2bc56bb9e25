use crate::air::Air;
use crate::checks::positive;
use crate::error::AcousticsError;
use crate::signals::fourier::{Transform, TransformSettings};
use crate::signals::{PowerSignals, SourceSpectrum};
use nalgebra::DMatrix;
use rustfft::num_complex::Complex;
use std::f64::consts::PI;

/// Acceleration noise of a body in rigid motion along one axis, modelled as a sphere of equal volume.
///
/// ```text
/// E(f) = 2 |A/omega|^2 rho0 c0 (4 pi a^2 / 3) (k a)^4 / (4 + (k a)^4)       a = (3 V / 4 pi)^{1/3}
/// ```
///
/// The radiation resistance of an oscillating sphere is exact. A velocity step v radiates rho0 V v² / 4. Only rigid
/// motion in free space is included, without wall vibration or reflection from a surface below.
///
/// `acceleration` \[m/s²\] at intervals of `sample_interval` \[s\], `volume` \[m³\].
///
/// # Errors
/// See [`Transform::new`] and [`Transform::apply`]; also if the volume is not positive.
pub fn rigid_body_energy(
    source: impl Into<String>,
    acceleration: &[f64],
    sample_interval: f64,
    volume: f64,
    air: &Air,
    settings: &TransformSettings,
) -> Result<SourceSpectrum, AcousticsError> {
    let (frequency, signal) = radiated(acceleration, sample_interval, volume, air, settings)?;
    let density = signal.iter().map(|x| 2.0 * x.norm_sqr()).collect();
    Ok(SourceSpectrum::new(
        source,
        "rigid motion only",
        frequency,
        density,
        settings.range_hz,
    )?)
}

/// The signal of [`rigid_body_energy`], for its energy over time.
///
/// # Errors
/// See [`rigid_body_energy`].
pub fn rigid_body_signals(
    acceleration: &[f64],
    sample_interval: f64,
    volume: f64,
    air: &Air,
    settings: &TransformSettings,
) -> Result<PowerSignals, AcousticsError> {
    let (_, signal) = radiated(acceleration, sample_interval, volume, air, settings)?;
    let spectrum = rigid_body_energy("", acceleration, sample_interval, volume, air, settings)?;
    Ok(PowerSignals::new(
        &spectrum,
        DMatrix::from_row_slice(1, signal.len(), &signal),
    )?)
}

/// Bins, and sqrt(R) A / (j omega) of the sphere.
fn radiated(
    acceleration: &[f64],
    sample_interval: f64,
    volume: f64,
    air: &Air,
    settings: &TransformSettings,
) -> Result<(Vec<f64>, Vec<Complex<f64>>), AcousticsError> {
    positive("volume of the body [m3]", volume)?;
    let transform = Transform::new(acceleration.len(), sample_interval, settings)?;
    let frequency = transform.frequencies();
    let a = (3.0 * volume / (4.0 * PI)).cbrt();
    let signal = |(hz, acceleration): (&f64, Complex<f64>)| {
        let omega = 2.0 * PI * hz;
        let ka4 = (omega * a / air.sound_speed).powi(4);
        let resistance = air.impedance() * 4.0 * PI * a * a / 3.0 * ka4 / (4.0 + ka4);
        acceleration * Complex::new(0.0, -resistance.sqrt() / omega)
    };
    let signals = frequency
        .iter()
        .zip(transform.apply(acceleration)?)
        .map(signal)
        .collect();
    Ok((frequency, signals))
}
