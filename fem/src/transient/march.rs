//! The march in time.

use super::error::TransientError;
use super::model::{Loads, ModalBody, Settings, Support};
use super::response::ModalResponse;

/// Response of one or two bodies to applied loads and supports.
///
/// # Errors
/// See [`TransientError`].
pub fn respond(
    bodies: &[ModalBody],
    supports: &[Support],
    loads: &Loads,
    settings: &Settings,
) -> Result<ModalResponse, TransientError> {
    let _ = (bodies, supports, loads);
    Err(TransientError::Value {
        what: "duration".into(),
        value: settings.duration,
        range: "positive",
    })
}
