//! Limits of the published laws.

use thiserror::Error;

/// A speed or depth outside the range of the quasi-static laws.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum RangeError {
    /// A penetration speed outside the range of the quasi-static laws.
    #[error(
        "penetration speed {speed} m/s is outside {lowest} .. {highest} m/s, the range of the quasi-static laws \
         (Eq. 2.2); use REFERENCE_SPEED for a dynamic run"
    )]
    PenetrationSpeed {
        /// Requested speed \[m/s\].
        speed: f64,
        /// Lowest speed \[m/s\].
        lowest: f64,
        /// Highest speed \[m/s\].
        highest: f64,
    },
    /// A depth beyond the nail's length.
    #[error("depth {depth} m is beyond the nail's length {length} m, where the penetration law ends")]
    PenetrationDepth {
        /// Requested depth \[m\].
        depth: f64,
        /// Nail length \[m\].
        length: f64,
    },
}
