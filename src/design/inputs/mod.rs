//! The inputs of the stages, made from a design: the only place where a stage's fields and the design file meet.

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
pub(crate) mod reference_structures;
pub(crate) mod response;
pub(crate) mod sensors;

/// The ambient air of a design: one gas for cycle, jets, muffler and radiation.
///
/// # Errors
/// Air that cannot be.
pub(crate) fn air(design: &Design) -> Result<Air, Error> {
    let ambient = &design.ambient;
    let air = Air::at(ambient.temperature, ambient.pressure)?;
    Ok(air.of_gas(ambient.gas_constant, ambient.heat_capacity_ratio)?)
}

/// An error of a stage with its place in the design file, if it has one.
pub fn located(design: &Design, error: Error) -> Error {
    match error {
        Error::Unusable { body, problems } => Error::Unusable {
            body,
            problems: problems.into_iter().map(|problem| located(design, problem)).collect(),
        },
        error => sensors::located(design, bodies::located(design, error)),
    }
}
