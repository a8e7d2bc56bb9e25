//! Levels of single events from sound pressure records, as measured by a sound level meter.

use super::fourier::fast_length;
use super::{Level, Weighting};
use crate::checks::{InputError, finite, positive};
use realfft::RealFftPlanner;
use rustfft::num_complex::Complex;

/// Reference sound pressure in air \[Pa\] (ISO 1683).
pub const REFERENCE_PRESSURE: f64 = 20e-6;

/// Oversampling of the record for the peak search; without it, the peak is underestimated by up to 3 dB.
const PEAK_OVERSAMPLING: usize = 8;

/// Padding before the transform \[s\]. During this time, the slowest pole of the weightings, 20.6 Hz, decays by a
/// factor of 1e-11.
const RINGING: f64 = 0.2;

/// Sound exposure level L_E of a pressure record \[Pa\] sampled at intervals of `sample_interval` \[s\]; `None` for
/// silence.
///
/// ```text
/// L_E = 10 lg( int p_w^2 dt / ((20 uPa)^2 x 1 s) )
/// ```
///
/// IEC 61672-1:2013, 3.12. The pressure is assumed to be zero outside the record.
///
/// # Errors
/// If the interval is not positive or values are not finite.
pub fn exposure_level(pressure: &[f64], sample_interval: f64, weighting: Weighting) -> Result<Level, InputError> {
    let weighted = weighted(pressure, sample_interval, weighting, 1)?;
    let exposure = weighted.iter().map(|p| p * p).sum::<f64>() * sample_interval;
    Ok((exposure > 0.0).then(|| 10.0 * (exposure / REFERENCE_PRESSURE.powi(2)).log10()))
}

/// Peak sound level of a pressure record \[Pa\] sampled at intervals of `sample_interval` \[s\]; `None` for silence.
///
/// ```text
/// L_peak = 20 lg( max |p_w| / 20 uPa )
/// ```
///
/// IEC 61672-1:2013, 3.11; peaks between samples are included. The pressure is assumed to be zero outside the record.
///
/// # Errors
/// See [`exposure_level`].
pub fn peak_level(pressure: &[f64], sample_interval: f64, weighting: Weighting) -> Result<Level, InputError> {
    let weighted = weighted(pressure, sample_interval, weighting, PEAK_OVERSAMPLING)?;
    let peak = weighted.iter().fold(0.0, |peak: f64, p| peak.max(p.abs()));
    Ok((peak > 0.0).then(|| 20.0 * (peak / REFERENCE_PRESSURE).log10()))
}

/// The record after the causal weighting filter, with `finer` samples for each original one and time to ring out.
fn weighted(record: &[f64], dt: f64, weighting: Weighting, finer: usize) -> Result<Vec<f64>, InputError> {
    positive("sample interval [s]", dt)?;
    finite("pressure", record)?;
    let length = fast_length(record.len() + (RINGING / dt).ceil() as usize);
    let mut planner = RealFftPlanner::new();
    let (forward, inverse) = (
        planner.plan_fft_forward(length),
        planner.plan_fft_inverse(finer * length),
    );
    let mut padded = forward.make_input_vec();
    padded[..record.len()].copy_from_slice(record);
    let mut spectrum = forward.make_output_vec();
    let done = forward.process(&mut padded, &mut spectrum);
    debug_assert!(done.is_ok());
    let mut finer_spectrum = inverse.make_input_vec();
    let scale = 1.0 / length as f64;
    for (k, (to, from)) in finer_spectrum.iter_mut().zip(&spectrum).enumerate() {
        *to = from * weighting.response(k as f64 / (length as f64 * dt)) * scale;
    }
    // These values of a real record's transform are real.
    finer_spectrum[0].im = 0.0;
    if finer == 1 {
        finer_spectrum[length / 2].im = 0.0;
    } else {
        // The highest bin represents two frequencies that the finer transform separates.
        finer_spectrum[length / 2] *= Complex::from(0.5);
    }
    let mut out = inverse.make_output_vec();
    let done = inverse.process(&mut finer_spectrum, &mut out);
    debug_assert!(done.is_ok());
    Ok(out)
}
