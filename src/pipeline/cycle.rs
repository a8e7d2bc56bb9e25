//! The nailing cycle of a design.

use nailnoise_dynamics::CycleRecord;

use crate::design::Design;
use crate::design::inputs::cycle::{cycle_settings, parameters};
use crate::error::Error;
use crate::stages::cycle::Cycle;
use crate::stages::{Progress, Stage};

/// Computes the nailing cycle of a design.
///
/// # Errors
/// [`Error::Cycle`] when the design cannot be computed.
pub fn cycle(design: &Design) -> Result<CycleRecord, Error> {
    let cycle = Cycle {
        parameters: parameters(design)?,
        settings: cycle_settings(design),
    };
    cycle.compute(&Progress::silent())
}
