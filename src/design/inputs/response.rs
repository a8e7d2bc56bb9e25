//! Inputs of the responses of workpiece, support and tool.

use nailnoise_fem::vibration::Support;

use super::bodies;
use super::cycle::parameters;
use crate::design::Design;
use crate::error::Error;
use crate::model::supports::{self, Contact};
use crate::stages::response::ShotInputs;
use crate::stages::tool_response::ToolShot;

/// Inputs of the response of workpiece and support, without the bodies and the cycle.
///
/// # Errors
/// [`Error::Sand`] when the sand's constants are outside the range of the foundation's formulas.
pub(crate) fn shot(design: &Design) -> Result<ShotInputs, Error> {
    let added_sand = supports::of(design).added_sand()?;
    let added_sand = added_sand.map(|sand| (sand.mass, supports::underside(design)));
    Ok(ShotInputs {
        added_sand,
        parameters: parameters(design)?,
        friction_share: design.wood.friction_share,
        supports: springs(design)?,
        step: design.analysis.time_step,
        duration: design.analysis.duration,
        start: 0,
    })
}

/// Springs and dashpots of the contact cells between workpiece and support, of the sand at the sides, of the user's
/// supports to the ground, and of the joint of two pieces.
fn springs(design: &Design) -> Result<Vec<Support>, Error> {
    let support = supports::of(design);
    let mut springs: Vec<Support> = support.contacts()?.iter().flat_map(Contact::springs).collect();
    springs.extend(support.sides()?.map(|sides| sides.springs).into_iter().flatten());
    springs.extend(bodies::spring_supports(design));
    springs.extend(bodies::joint_supports(design));
    Ok(springs)
}

/// Inputs of the response of the tool, without its body and the cycle.
///
/// # Errors
/// Same as [`parameters`].
pub(crate) fn tool(design: &Design) -> Result<ToolShot, Error> {
    Ok(ToolShot {
        parameters: parameters(design)?,
        step: design.analysis.time_step,
        duration: design.analysis.duration,
    })
}
