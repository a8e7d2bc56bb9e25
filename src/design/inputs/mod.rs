//! Inputs of the stages. Only this module translates the design file into the fields of the stages.

use nailnoise_acoustics::Air;

use super::Design;
use crate::error::Error;

pub mod assembly;
pub mod bodies;
pub mod cycle;
pub(crate) mod exports;
pub(crate) mod microphones;
pub(crate) mod notes;
pub(crate) mod radiation;
pub(crate) mod recorded_surfaces;
pub(crate) mod reference_structures;
pub(crate) mod response;
pub(crate) mod sensors;

/// The ambient air of a design: the same gas for cycle, jets, muffler and radiation.
///
/// # Errors
/// If the state of the air is impossible.
pub(crate) fn air(design: &Design) -> Result<Air, Error> {
    let ambient = &design.ambient;
    let air = Air::at(ambient.temperature, ambient.pressure)?;
    Ok(air.of_gas(ambient.gas_constant, ambient.heat_capacity_ratio)?)
}

/// Adds the place in the design file to an error of a stage, if it has one.
pub fn located(design: &Design, error: Error) -> Error {
    match error {
        Error::Unusable { body, problems } => Error::Unusable {
            body,
            problems: problems.into_iter().map(|problem| located(design, problem)).collect(),
        },
        error => sensors::located(design, bodies::located(design, error)),
    }
}
