//! Reference bodies: the shape of a design's bodies with the materials, the nail and its place, the tool's walls,
//! lumped masses and places of loads of the N80CB.
//!
//! The boundary-element equations are solved for the modes of these bodies, and the solution is stored. Assumption: on
//! the outer surface, the modes of any body of this shape are combinations of them. The error is stated for every
//! design. If the first structure is not good enough, a second one with other materials, and for the tool also with
//! other walls, is added ([`varied`]). If the walls of the two differ, it is added from the start
//! ([`ReferenceStructures::walls_differ`]). If both together are not good enough either, the radiation is solved for
//! the design's modes. For a design with the N80CB's materials, the standard bodies are the design's bodies, and no
//! assumption is needed.

use std::sync::OnceLock;

use nailnoise_meshes::ToolDimensions;

use super::bodies::geometry;
use crate::design::{Design, Entry, Value, worktables};
use crate::error::Error;
use crate::shipped;
use crate::stages::bodies::{BodyKind, MeshSource};

/// Name of the shipped design from which the materials are taken.
const STANDARD: &str = "n80cb";

/// Name of the worktable in the catalogue from which the wall thickness of tubular legs is taken.
const STANDARD_TUBES: &str = "B";

/// Materials of block and table: groups of keys, and single keys.
const MATERIALS: [&str; 7] = [
    "wood.density",
    "wood.elastic.",
    "support.worktable.top.",
    "support.worktable.top_density",
    "support.worktable.legs.",
    "support.worktable.leg_density",
    "support.worktable.metal.",
];

/// Walls of the tool inside its outer surface, and its materials.
const WITHIN_TOOL: [&str; 8] = [
    "body.cap_wall",
    "body.handle_wall",
    "body.magazine_wall",
    "body.nose_wall",
    "body.housing.",
    "body.cap.",
    "body.nose.",
    "body.sleeve.",
];

/// Positions in the ranges of [`MATERIALS`], used alternately. In ten draws of the N80CB's materials, one structure
/// missed up to 3.7e-3 of the energy. With a second structure, up to 6e-4 was missed, at these positions as well as at
/// 0.1 and 0.9, in either order.
const RANGE_SHARES: [f64; 2] = [0.75, 0.25];

/// Positions in the ranges of [`WITHIN_TOOL`], used alternately. In ten draws of walls, materials and lumped masses,
/// one structure missed up to 4.5e-3, and more than 1e-3 in five draws; with a second structure, these five missed
/// 2.3e-4 to 4.2e-4, and one 1.3e-3. For a magazine wall of 2 mm, one structure misses 6.4e-3 and two miss 3.5e-4,
/// whereas positions 0.75 and 0.25 leave 2.1e-3. For 1.5 mm, at the end of its range, one misses 3.1e-2 and two miss
/// 1.4e-3; with positions 0.25 and 0.75 two miss 2.7e-3, and with 0.02 and 0.98 1.9e-3.
const TOOL_SHARES: [f64; 2] = [0.1, 0.9];

/// Differences of the barrel's radii up to this value \[m\] are due to rounding.
const SAME_RADIUS: f64 = 1e-9;

/// The shipped design, read once; `None` only if it does not parse, which a test excludes.
fn shipped_design() -> Option<&'static Design> {
    static READ: OnceLock<Option<Design>> = OnceLock::new();
    let read = || {
        let (path, text) = shipped::design(STANDARD)?;
        Design::parse(text, path).ok()
    };
    READ.get_or_init(read).as_ref()
}

/// Wall thickness of the tubular legs of the standard table \[m\], read once; `None` only if the catalogue has no such
/// table, which a test excludes.
fn tube_wall() -> Option<f64> {
    static READ: OnceLock<Option<f64>> = OnceLock::new();
    let read = || {
        let table = worktables()
            .ok()?
            .into_iter()
            .find(|table| table.name == STANDARD_TUBES)?;
        let wall = table
            .sets
            .into_iter()
            .find(|own| own.key == "support.worktable.leg_wall")?;
        match wall.value {
            Value::Number(wall) => Some(wall),
            _ => None,
        }
    };
    *READ.get_or_init(read)
}

/// The shipped design with other materials and tool walls, each quantity at one of [`RANGE_SHARES`] or [`TOOL_SHARES`]
/// in its range, and without lumped masses of the tool.
fn varied() -> Option<&'static Design> {
    static READ: OnceLock<Option<Design>> = OnceLock::new();
    let read = || {
        let mut design = shipped_design()?.clone();
        let entries = design.entries();
        let of_block_and_table = at_shares(&entries, &MATERIALS, RANGE_SHARES);
        let of_tool = at_shares(&entries, &WITHIN_TOOL, TOOL_SHARES);
        let changes: Vec<(&str, Value)> = of_block_and_table.chain(of_tool).collect();
        design.set(&changes).ok()?;
        // Its mass need not equal that of the tool.
        design.body.lumped = false;
        Some(design)
    };
    READ.get_or_init(read).as_ref()
}

/// Keys with these names or in these groups, with values at two positions in their ranges, alternately.
fn at_shares<'a>(
    entries: &'a [Entry],
    names: &'static [&'static str],
    shares: [f64; 2],
) -> impl Iterator<Item = (&'a str, Value)> {
    let is_named = |key: &str| {
        names
            .iter()
            .any(|own| key == *own || own.ends_with('.') && key.starts_with(own))
    };
    let ranges = entries
        .iter()
        .filter(move |entry| is_named(&entry.key))
        .filter_map(|entry| Some((entry.key.as_str(), entry.range?)));
    ranges
        .zip(shares.into_iter().cycle())
        .map(|((key, [low, high]), share)| (key, Value::Number(low + share * (high - low))))
}

/// The design with materials, nail, and the tool's walls, masses and loads taken from `from`; its bodies keep the outer
/// surfaces of `design`. The loads matter because the static corrections of the modes depend on them.
fn with_materials_of(design: &Design, from: &Design) -> Design {
    let mut standard = design.clone();
    let (wood, own) = (&mut standard.wood, &from.wood);
    (wood.density, wood.elastic, wood.driven) = (own.density, own.elastic.clone(), own.driven);
    let (nail, own) = (&mut standard.nail, &from.nail);
    (nail.offset_along, nail.offset_across) = (own.offset_along, own.offset_across);
    // The nail has the same relative depth in the block.
    standard.nail.length = from.nail.length * (design.workpiece.thickness / from.workpiece.thickness);
    let (table, own) = (&mut standard.support.worktable, &from.support.worktable);
    (table.top, table.top_density) = (own.top.clone(), own.top_density);
    (table.legs, table.leg_density) = (own.legs.clone(), own.leg_density);
    table.metal = own.metal.clone();
    if table.leg_wall > 0.0 {
        table.leg_wall = tube_wall().unwrap_or(table.leg_wall);
    }
    let (body, own) = (&mut standard.body, &from.body);
    (body.housing, body.cap) = (own.housing.clone(), own.cap.clone());
    (body.nose, body.sleeve) = (own.nose.clone(), own.sleeve.clone());
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
        // A housing of other dimensions may be heavier than the tool of `from`.
        body.lumped = false;
    }
    standard
}

/// Dimensions of a housing with the walls and interior of another one.
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

/// Designs with reference bodies in the shape of a design's.
pub(crate) struct ReferenceStructures {
    /// Has the materials and the nail of the N80CB.
    pub(crate) first: Design,
    /// Has other materials, and other walls if the tool has the outer dimensions of the N80CB. It is for motion that
    /// the first does not represent.
    pub(crate) second: Option<Design>,
}

impl ReferenceStructures {
    /// Whether the tool of the second design has different walls and so a separate mesh, which is the case for the
    /// outer surface of the N80CB. Designers change walls, and one structure does not represent the motion of others;
    /// so both are solved together from the start.
    pub(crate) fn walls_differ(&self) -> bool {
        let [first, second] = [Some(&self.first), self.second.as_ref()].map(|design| design.map(|design| &design.body));
        first
            .zip(second)
            .is_some_and(|(first, second)| second.mesh.is_empty() && second.dimensions != first.dimensions)
    }
}

/// Reference bodies of these kinds; `None` if the mesh of a body depends on its material, so that another material
/// gives another surface.
///
/// # Errors
/// The errors of the bodies' materials and mesh files.
pub(crate) fn references(design: &Design, kinds: &[BodyKind]) -> Result<Option<ReferenceStructures>, Error> {
    let Some(shipped) = shipped_design() else {
        return Ok(None);
    };
    let first = with_materials_of(design, shipped);
    if !same_meshes(design, &first, kinds)? {
        return Ok(None);
    }
    let mut second = varied().map(|varied| with_materials_of(design, varied));
    if let Some(varied) = &second
        && !same_meshes(&first, varied, kinds)?
    {
        second = None;
    }
    Ok(Some(ReferenceStructures { first, second }))
}

/// Whether gmsh meshes one of these bodies.
///
/// # Errors
/// The errors of the bodies' materials and mesh files.
pub(crate) fn needs_gmsh(design: &Design, kinds: &[BodyKind]) -> Result<bool, Error> {
    kinds.iter().try_fold(false, |needed, &kind| {
        Ok(needed || geometry(design, kind, false)?.mesh.needs_gmsh())
    })
}

/// Whether the bodies of two designs have the same outer surfaces.
fn same_meshes(design: &Design, other: &Design, kinds: &[BodyKind]) -> Result<bool, Error> {
    for &kind in kinds {
        let [own, other] = [design, other].map(|design| Ok::<_, Error>(geometry(design, kind, false)?.mesh));
        let alike = match (own?, other?) {
            // Their walls may differ.
            (MeshSource::Worktable(own, _), MeshSource::Worktable(other, _)) => own == other,
            // So may those of the tool, which the standard's walls replace.
            (MeshSource::Tool(..), MeshSource::Tool(..)) => true,
            (own, other) => own == other,
        };
        if !alike {
            return Ok(false);
        }
    }
    Ok(true)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn the_standard_bodies_of_the_n80cb_are_its_own() {
        let own = shipped_design().unwrap();
        let references = references(own, &BodyKind::ALL).unwrap().unwrap();
        assert_eq!(own.digest(), references.first.digest());
    }

    #[test]
    fn the_second_standard_tool_differs_in_every_wall_and_material_within_the_same_outside() {
        let own = shipped_design().unwrap();
        let second = references(own, &[BodyKind::Tool]).unwrap().unwrap().second.unwrap();
        assert!(second.conflict().is_none());
        let of = |design: &Design, name: &str| {
            let entries = design.entries().into_iter();
            let named = entries.filter(|entry| entry.key.starts_with(name));
            named.map(|entry| entry.value).collect::<Vec<_>>()
        };
        for name in WITHIN_TOOL {
            let [own, second] = [own, &second].map(|design| of(design, name));
            assert!(
                !own.is_empty() && own.iter().zip(&second).all(|(own, second)| own != second),
                "{name}"
            );
        }
        let (outside, inside) = (&own.body.dimensions, &second.body.dimensions);
        assert_eq!(with_inside_of(outside, inside), *inside);
        let radii = [own, &second].map(|design| design.body.dimensions.barrel_radius(0.5 * design.piston.bore));
        assert!((radii[0] - radii[1]).abs() < SAME_RADIUS);
        assert!(!second.body.lumped);
    }

    #[test]
    fn the_second_standard_bodies_differ_in_every_material() {
        let (own, varied) = (shipped_design().unwrap(), varied().unwrap());
        assert!(varied.conflict().is_none());
        for group in MATERIALS {
            let of_group = |design: &Design| {
                let entries = design
                    .entries()
                    .into_iter()
                    .filter(|entry| entry.key.starts_with(group));
                entries.map(|entry| entry.value).collect::<Vec<_>>()
            };
            println!("{group} {:?} {:?}", of_group(own), of_group(varied));
            assert_ne!(of_group(own), of_group(varied), "{group}");
        }
        let kinds = [BodyKind::Workpiece, BodyKind::Worktable];
        let second = references(own, &kinds).unwrap().unwrap().second.unwrap();
        for kind in kinds {
            let [own, second] = [own, &second].map(|design| geometry(design, kind, false).unwrap().mesh);
            assert_eq!(own, second, "the same mesh");
        }
    }
}
