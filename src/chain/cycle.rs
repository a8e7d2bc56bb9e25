//! The nailing cycle of a design.

use nailnoise_dynamics::CycleRecord;

use crate::design::{Design, inputs};
use crate::error::Error;
use crate::stages::cycle::{Cycle, Preset};
use crate::stages::{Progress, Stage};

/// Computes the nailing cycle of a design.
///
/// # Errors
/// [`Error::Cycle`] if the design cannot be computed.
pub fn cycle(design: &Design) -> Result<CycleRecord, Error> {
    cycle_stage(design)?.compute(&Progress::silent())
}

/// Computes the nailing cycle of a design in a published form.
///
/// # Errors
/// Same as [`cycle`].
pub fn cycle_as_published(design: &Design, preset: Preset) -> Result<CycleRecord, Error> {
    cycle_stage(design)?.published(preset).compute(&Progress::silent())
}

/// The cycle with a lumped workpiece.
///
/// # Errors
/// If the values of the design do not yield valid inputs.
pub(crate) fn cycle_stage(design: &Design) -> Result<Cycle, Error> {
    Ok(Cycle {
        parameters: inputs::cycle::parameters(design)?,
        settings: inputs::cycle::cycle_settings(design),
    })
}
