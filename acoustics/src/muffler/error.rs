use crate::checks::InputError;
use thiserror::Error;

/// Why the insertion loss of a muffler cannot be determined.
#[derive(Debug, Error)]
pub enum MufflerError {
    /// An invalid argument.
    #[error(transparent)]
    Input(#[from] InputError),
    /// Cross modes propagate in the muffler at the given frequency.
    #[error(
        "a muffler element of {diameter} m carries plane waves alone up to {highest:.0} Hz only, not at {hz:.0} Hz; \
         analyse a lower range, or give the muffler's insertion loss by bands"
    )]
    NotPlaneWaves {
        /// The frequency \[Hz\].
        hz: f64,
        /// Inner diameter of the element \[m\].
        diameter: f64,
        /// Cut-on frequency of its first cross mode \[Hz\].
        highest: f64,
    },
    /// The muffler's insertion loss is not specified at a frequency.
    #[error(
        "the muffler's insertion loss has no value at {hz} Hz: give neighbouring one-third-octave bands in rising \
         order \
         that cover the analysed range"
    )]
    Bands {
        /// The frequency \[Hz\].
        hz: f64,
    },
}
