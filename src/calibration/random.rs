//! Standard normal random numbers of a calibration.

use nailnoise_acoustics::random::uniform;
use nailnoise_calibration::normal;

/// A standard normal number, a function of a seed and two indices.
pub(super) fn standard_normal(seed: u64, index: u64, variable: u64) -> f64 {
    // `uniform` is in [0, 1).
    normal::quantile(uniform(seed, index, variable).max(f64::EPSILON))
}
