//! A source at the microphones before its signals and spectra are combined.

use nailnoise_acoustics::signals::SourceSpectrum;
use nalgebra::DMatrix;

/// A part of a source with its own frequency grid.
pub(super) struct SourcePart {
    /// \[Hz\].
    pub(super) frequency: Vec<f64>,
    /// Density of the sound exposure, receivers x frequencies, with the ear after the microphones \[Pa² s/Hz\].
    pub(super) exposure: DMatrix<f64>,
}

/// A source at the microphones.
pub(super) struct Received<'a> {
    /// The source with its radiated energy.
    pub(super) radiated: &'a SourceSpectrum,
    /// Method by which its sound is propagated to a microphone.
    pub(super) how: &'static str,
    /// Range over which the sound at the microphones is given \[Hz\].
    pub(super) range: [f64; 2],
    /// Frequency up to which the signals have the phases of the source \[Hz\].
    pub(super) phases_to_hz: f64,
    /// Error of interpolated pressures over frequency, relative to the loudest mode at any microphone.
    pub(super) interpolation_error: Option<f64>,
    pub(super) parts: Vec<SourcePart>,
    /// Pressure at [`SAMPLE_RATE`](super::SAMPLE_RATE) from the trigger on, for each receiver \[Pa\].
    pub(super) signals: Vec<Vec<f64>>,
}
