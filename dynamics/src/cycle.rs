//! One nailing cycle.

use crate::{CycleError, CycleRecord, Parameters, Settings};

/// Computes one nailing cycle.
///
/// # Errors
/// See [`CycleError`].
pub fn simulate(parameters: &Parameters, settings: &Settings) -> Result<CycleRecord, CycleError> {
    let _ = (parameters, settings);
    Err(CycleError::Integration {
        time: 0.0,
        cause: "the cycle is not built yet".into(),
    })
}
