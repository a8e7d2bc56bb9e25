//! Parses quantities given as options, with limits.

use nailnoise_quantities::{Dimension, measure};

/// Parses a quantity given as an option, within limits \[SI\].
///
/// # Errors
/// A description of the error in the text, or the limits.
pub(super) fn within(text: &str, dimension: Dimension, [low, high]: [f64; 2]) -> Result<f64, String> {
    let value = measure(text, dimension)?;
    if (low..=high).contains(&value) {
        return Ok(value);
    }
    Err(format!(
        "{value:?} {0} is outside {low:?} to {high:?} {0}",
        dimension.unit()
    ))
}
