use crate::checks::InputError;
use thiserror::Error;

/// Why a sound has no loudness by ISO 532-1.
#[derive(Debug, Error)]
pub enum LoudnessError {
    /// An invalid argument.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A low-frequency level exceeds the range of the standard.
    #[error(
        "{level:.1} dB in the third octave number {band} from 25 Hz; ISO 532-1 ends at 120 dB in the bands up to 250 Hz"
    )]
    TooLoud {
        /// Index of the band, 0 for 25 Hz.
        band: usize,
        /// Its level \[dB re 20 uPa\].
        level: f64,
    },
}
