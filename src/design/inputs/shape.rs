//! Standard bodies: the shape of a design's bodies with the materials, the nail, the tool's walls, lumped masses
//! and places of loads of the N80CB.
//!
//! The radiation of boundary elements is solved for the modes of these bodies, and kept. Assumption: on the outer surface
//! the modes of any body of this shape combine from them. How well is stated for every design; where it does not hold, the
//! radiation is solved for the design's own modes. For a design with the N80CB's own materials the standard bodies are its
//! bodies, and nothing is assumed.

use std::sync::OnceLock;

use nailnoise_meshes::ToolDimensions;

use super::bodies::geometry;
use crate::design::Design;
use crate::error::Error;
use crate::shipped;
use crate::stages::bodies::{BodyKind, MeshSource};

/// Name of the shipped design that gives the materials.
const STANDARD: &str = "n80cb";

/// Largest difference of the barrel's radii \[m\] that is rounding.
const SAME_RADIUS: f64 = 1e-9;

/// The shipped design, read once; none only if it does not parse, which a test excludes.
fn shipped_design() -> Option<&'static Design> {
    static READ: OnceLock<Option<Design>> = OnceLock::new();
    let read = || {
        let (path, text) = shipped::design(STANDARD)?;
        Design::parse(text, path).ok()
    };
    READ.get_or_init(read).as_ref()
}

/// The design with standard materials, nail, and walls, masses and loads of the tool; its bodies have the outer surfaces of
/// the design's. The loads count because the static corrections of the modes depend on them.
fn standard(design: &Design) -> Option<Design> {
    let from = shipped_design()?;
    let mut standard = design.clone();
    let (wood, own) = (&mut standard.wood, &from.wood);
    (wood.density, wood.elastic, wood.driven) = (own.density, own.elastic.clone(), own.driven);
    // As deep in the block as the N80CB's.
    standard.nail.length = from.nail.length * (design.workpiece.thickness / from.workpiece.thickness);
    let (table, own) = (&mut standard.support.worktable, &from.support.worktable);
    (table.top, table.top_density) = (own.top.clone(), own.top_density);
    (table.legs, table.leg_density) = (own.legs.clone(), own.leg_density);
    (table.steel.material, table.steel.tube_wall) = (own.steel.material.clone(), own.steel.tube_wall);
    let (body, own) = (&mut standard.body, &from.body);
    (body.housing, body.nose, body.sleeve) = (own.housing.clone(), own.nose.clone(), own.sleeve.clone());
    let sleeve = 0.5 * design.piston.bore;
    let as_wide = (body.dimensions.barrel_radius(sleeve) - own.dimensions.barrel_radius(sleeve)).abs() < SAME_RADIUS;
    if as_wide && with_inside_of(&body.dimensions, &own.dimensions) == own.dimensions {
        body.dimensions = own.dimensions.clone();
    }
    if body.mesh.is_empty() && body.dimensions == own.dimensions {
        (body.lumped, body.lumped_nose, body.lumped_magazine) = (own.lumped, own.lumped_nose, own.lumped_magazine);
        standard.tool.mass = from.tool.mass;
        standard.head_valve.inner_diameter = from.head_valve.inner_diameter;
        standard.head_valve.outer_diameter = from.head_valve.outer_diameter;
        standard.chambers.check_hole_position = from.chambers.check_hole_position;
    } else {
        // A housing of other dimensions may be heavier than that tool.
        body.lumped = false;
    }
    Some(standard)
}

/// Dimensions of a housing with walls and all that they enclose from another one.
fn with_inside_of(dimensions: &ToolDimensions, from: &ToolDimensions) -> ToolDimensions {
    ToolDimensions {
        barrel_wall: from.barrel_wall,
        cap_wall: from.cap_wall,
        handle_wall: from.handle_wall,
        magazine_wall: from.magazine_wall,
        nose_wall: from.nose_wall,
        nose_overlap: from.nose_overlap,
        sleeve_wall: from.sleeve_wall,
        sleeve_height: from.sleeve_height,
        sleeve_gap: from.sleeve_gap,
        sleeve_fit: from.sleeve_fit,
        ..dimensions.clone()
    }
}

/// The design with the standard bodies of these kinds; none where a body is meshed for its material, so that another
/// material has another surface.
///
/// # Errors
/// Those of the bodies' materials and mesh files.
pub(crate) fn standard_bodies(design: &Design, kinds: &[BodyKind]) -> Result<Option<Design>, Error> {
    let Some(standard) = standard(design) else {
        return Ok(None);
    };
    for &kind in kinds {
        let [own, other] = [design, &standard].map(|design| Ok::<_, Error>(geometry(design, kind, false)?.mesh));
        let alike = match (own?, other?) {
            // Their walls may differ.
            (MeshSource::Worktable(own, _), MeshSource::Worktable(other, _)) => own == other,
            // So may those of the tool, in whose place the standard's stand.
            (MeshSource::Tool(..), MeshSource::Tool(..)) => true,
            (own, other) => own == other,
        };
        if !alike {
            return Ok(None);
        }
    }
    Ok(Some(standard))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn the_standard_bodies_of_the_n80cb_are_its_own() {
        let own = shipped_design().unwrap();
        let standard = standard(own).unwrap();
        assert_eq!(own.digest(), standard.digest());
    }
}
