use crate::checks::InputError;
use thiserror::Error;

/// Why a spectrum or its signals cannot be computed.
#[derive(Debug, Error)]
pub enum LevelsError {
    /// An invalid argument.
    #[error(transparent)]
    Input(#[from] InputError),
    /// Frequencies are not strictly ascending.
    #[error("the frequency {next} Hz follows {previous} Hz; a spectrum's frequencies rise strictly")]
    Frequencies {
        /// A frequency \[Hz\].
        previous: f64,
        /// The next frequency \[Hz\].
        next: f64,
    },
    /// A frequency is not a multiple of the bin width.
    #[error("{hz} Hz is no multiple of {resolution} Hz; signals over time need the bins of one transform")]
    NotABin {
        /// The frequency \[Hz\].
        hz: f64,
        /// Mean spacing of the frequencies \[Hz\].
        resolution: f64,
    },
}
