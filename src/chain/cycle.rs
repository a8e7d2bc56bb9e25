//! The nailing cycle of a design.

use nailnoise_dynamics::CycleRecord;

use crate::design::{Design, inputs};
use crate::error::Error;
use crate::stages::cycle::{Cycle, Engine, Preset, ShotRecord};

/// Computes the nailing cycle of a design.
///
/// # Errors
/// [`Error::Cycle`] if the design cannot be computed.
pub fn cycle(design: &Design) -> Result<CycleRecord, Error> {
    cycle_stage(design)?.record()
}

/// Computes the shot of a design, whichever engine computes its cycle.
///
/// # Errors
/// As [`cycle`]; [`Error::Network`] for an assembly that cannot be computed.
pub fn shot(design: &Design) -> Result<ShotRecord, Error> {
    engine(design)?.shot()
}

/// The engine of a design's cycle.
///
/// # Errors
/// Values of the design that do not yield inputs.
pub(crate) fn engine(design: &Design) -> Result<Engine, Error> {
    Ok(match inputs::assembly::cycle(design)? {
        Some(assembled) => Engine::Assembly(Box::new(assembled)),
        None => Engine::Keys(Box::new(cycle_stage(design)?)),
    })
}

/// Computes the nailing cycle of a design in a published form.
///
/// # Errors
/// Same as [`cycle`].
pub fn cycle_as_published(design: &Design, preset: Preset) -> Result<CycleRecord, Error> {
    cycle_stage(design)?.published(preset).record()
}

/// The cycle with a lumped workpiece.
///
/// # Errors
/// Values of the design that do not yield inputs.
fn cycle_stage(design: &Design) -> Result<Cycle, Error> {
    Ok(Cycle {
        parameters: inputs::cycle::parameters(design)?,
        settings: inputs::cycle::cycle_settings(design),
    })
}
