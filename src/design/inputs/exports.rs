//! Inputs of the exports: what the bodies in the report stand in and on.

use super::air;
use super::radiation::nose;
use crate::design::Design;
use crate::error::Error;
use crate::report::Surroundings;

/// What the bodies stand in and on.
///
/// # Errors
/// Air that cannot be.
pub(crate) fn surroundings(design: &Design) -> Result<Surroundings, Error> {
    Ok(Surroundings {
        support: design.support.kind,
        half_sides: [0.5 * design.workpiece.length, 0.5 * design.workpiece.width],
        nose: nose(design).into(),
        air: air(design)?,
    })
}
