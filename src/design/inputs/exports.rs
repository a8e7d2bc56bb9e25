//! Inputs of the exports: the surroundings of the bodies in the report.

use super::air;
use super::radiation::{covered_faces, nose};
use crate::design::Design;
use crate::error::Error;
use crate::report::Surroundings;

/// Surroundings and supports of the bodies.
///
/// # Errors
/// If the state of the air is impossible.
pub(crate) fn surroundings(design: &Design) -> Result<Surroundings, Error> {
    Ok(Surroundings {
        covered: covered_faces(design),
        nose: nose(design).into(),
        air: air(design)?,
    })
}
