//! The nailing cycle of a design.

use nailnoise_dynamics::{CycleRecord, simulate};

use crate::design::Design;
use crate::design::inputs::cycle::{cycle_settings, parameters};
use crate::error::Error;

/// Computes the nailing cycle of a design.
///
/// # Errors
/// [`Error::Cycle`] when the design cannot be computed.
pub fn cycle(design: &Design) -> Result<CycleRecord, Error> {
    Ok(simulate(&parameters(design)?, &cycle_settings(design))?)
}
