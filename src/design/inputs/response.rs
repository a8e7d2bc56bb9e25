//! Inputs of the responses of workpiece, support and tool.

use nailnoise_dynamics::network::assembly::Base;
use nailnoise_fem::vibration::Support;

use super::assembly::{body, tool_mass};
use super::bodies;
use crate::design::Design;
use crate::error::Error;
use crate::model::supports::{self, Contact};
use crate::stages::cycle::{Engine, WORKPIECE, stops_on_housing};
use crate::stages::response::{DrivenFastener, FastenerLaw, ShotInputs};
use crate::stages::tool_response::{HousingContact, ToolShot};

/// Inputs of the response of workpiece and support, without the bodies and the cycle.
///
/// # Errors
/// [`Error::Sand`] when the sand's constants are outside the range of the foundation's formulas.
pub(crate) fn shot(design: &Design, engine: &Engine) -> Result<ShotInputs, Error> {
    let added_sand = supports::of(design).added_sand()?;
    let added_sand = added_sand.map(|sand| (sand.mass, supports::underside(design)));
    Ok(ShotInputs {
        added_sand,
        gravity: design.ambient.gravity,
        fastener: fastener(design, engine),
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

/// The fastener in the workpiece; none for a tool that drives none.
fn fastener(design: &Design, engine: &Engine) -> Option<DrivenFastener> {
    let law = match engine {
        Engine::Keys(cycle) => FastenerLaw::Nail(Box::new(cycle.parameters.clone())),
        Engine::Assembly(cycle) => {
            let workpiece = body(&cycle.assembly, WORKPIECE)?;
            let mut fasteners = cycle.assembly.fasteners.iter();
            FastenerLaw::Fastener(fasteners.find(|own| own.into == Base::Body(workpiece))?.clone())
        }
    };
    Some(DrivenFastener {
        law,
        friction_share: design.wood.friction_share,
    })
}

/// A contact of the cycle on a surface of the housing.
fn housing_contact(surface: &str, stiffness: f64) -> HousingContact {
    let place = match surface {
        "rim" => "cylinder's rim",
        own => own,
    };
    HousingContact {
        surface: surface.to_owned(),
        place: place.to_owned(),
        stiffness,
    }
}

/// Inputs of the response of the tool, without its body and the cycle.
pub(crate) fn tool(design: &Design, engine: &Engine) -> ToolShot {
    let contacts = match engine {
        Engine::Keys(cycle) => {
            let contacts = &cycle.parameters.contacts;
            vec![
                housing_contact("cap", contacts.cap_stiffness),
                housing_contact("rim", contacts.seat_stiffness),
            ]
        }
        Engine::Assembly(cycle) => stops_on_housing(&cycle.assembly)
            .into_iter()
            .map(|stop| housing_contact(stop.surface, stop.contact.stiffness))
            .collect(),
    };
    ToolShot {
        gravity: engine.gravity(),
        mass: tool_mass(engine),
        contacts,
        step: design.analysis.time_step,
        duration: design.analysis.duration,
    }
}
