use thiserror::Error;

/// Why a quantity cannot be sampled over frequency.
#[derive(Debug, Error)]
pub enum SamplingError {
    /// The range of frequencies is empty.
    #[error("the range {low} to {high} Hz is empty")]
    EmptyRange {
        /// Lower end \[Hz\].
        low: f64,
        /// Upper end \[Hz\].
        high: f64,
    },
    /// The radiation matrix was not resolved over frequency with the allowed number of samples.
    #[error(
        "the radiation matrix near {hz:.0} Hz is interpolated with error {error:.1e} after {samples} samples, \
         above the tolerance {tolerance:.1e}; allow more samples or a larger tolerance"
    )]
    Unresolved {
        /// Middle of the worst interval \[Hz\].
        hz: f64,
        /// Its estimated relative error.
        error: f64,
        /// Number of samples taken.
        samples: usize,
        /// Tolerance.
        tolerance: f64,
    },
}
