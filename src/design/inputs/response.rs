//! Inputs of the responses of workpiece, support and tool.

use nailnoise_fem::supports::{RectangularBase, Sand, contact_dashpot};
use nailnoise_fem::transient::{Support, SupportLaw};

use super::bodies::{self, added_sand, contact_cells};
use super::cycle::parameters;
use crate::design::{Design, SupportKind};
use crate::error::Error;
use crate::stages::response::Shot;
use crate::stages::tool_response::ToolShot;

/// Inputs of the response of workpiece and support, except the bodies and the cycle.
///
/// # Errors
/// [`Error::Sand`] when the sand's constants are outside the range of the foundation's formulas.
pub(crate) fn shot(design: &Design) -> Result<Shot, Error> {
    let added_sand = match design.support.kind {
        SupportKind::Sandbox => Some((added_sand(design)?.mass, contact_cells(design))),
        SupportKind::Worktable | SupportKind::Floor | SupportKind::Clamped | SupportKind::Springs => None,
    };
    Ok(Shot {
        added_sand,
        parameters: parameters(design)?,
        friction_share: design.wood.friction_share,
        supports: supports(design)?,
        step: design.analysis.time_step,
        duration: design.analysis.duration,
        start: 0,
    })
}

/// Springs and dashpots of the contact cells between the workpiece and its support, of the sand at its sides, those of
/// the user to the ground, and those of the joint of two pieces.
fn supports(design: &Design) -> Result<Vec<Support>, Error> {
    let mut supports = contact_supports(design)?;
    supports.extend(bodies::side_supports(design)?);
    supports.extend(bodies::spring_supports(design));
    supports.extend(bodies::joint_supports(design));
    Ok(supports)
}

fn contact_supports(design: &Design) -> Result<Vec<Support>, Error> {
    let (stiffness, dashpot, bonded) = match design.support.kind {
        SupportKind::Clamped | SupportKind::Springs => return Ok(Vec::new()),
        SupportKind::Worktable | SupportKind::Floor => {
            let c = &design.support.contact;
            let dashpot = contact_dashpot(c.stiffness_per_area, c.loss_ratio, c.loss_frequency);
            (c.stiffness_per_area, dashpot, c.bonded)
        }
        SupportKind::Sandbox => {
            let s = &design.support.sand;
            let sand = Sand::new(s.shear_modulus, s.density, s.poisson_ratio)?;
            let base = RectangularBase::new(design.workpiece.length, design.workpiece.width)?;
            (base.normal_bedding(&sand), sand.normal_dashpot(), s.bonded)
        }
    };
    let law = if bonded {
        SupportLaw::Bonded
    } else {
        SupportLaw::Unilateral
    };
    let cell = |&area: &f64| Support {
        stiffness: stiffness * area,
        damping: dashpot * area,
        gap: 0.0,
        law,
    };
    Ok(contact_cells(design).grid().areas.iter().map(cell).collect())
}

/// Inputs of the response of the tool, except its body and the cycle.
///
/// # Errors
/// As [`parameters`].
pub(crate) fn tool(design: &Design) -> Result<ToolShot, Error> {
    Ok(ToolShot {
        parameters: parameters(design)?,
        step: design.analysis.time_step,
        duration: design.analysis.duration,
    })
}
