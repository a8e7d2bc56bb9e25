use crate::checks::InputError;
use thiserror::Error;

/// Why a spectrum or its signals cannot be formed.
#[derive(Debug, Error)]
pub enum LevelsError {
    /// An invalid argument.
    #[error(transparent)]
    Input(#[from] InputError),
    /// Frequencies do not rise strictly.
    #[error("the frequency {next} Hz follows {previous} Hz; a spectrum's frequencies rise strictly")]
    Frequencies {
        /// A frequency \[Hz\].
        previous: f64,
        /// The one after it \[Hz\].
        next: f64,
    },
    /// A frequency is not a multiple of the bin width.
    #[error("{hz} Hz is no multiple of {resolution} Hz; signals over time need the bins of one transform")]
    NotABin {
        /// The frequency \[Hz\].
        hz: f64,
        /// Mean distance of the frequencies \[Hz\].
        resolution: f64,
    },
}
