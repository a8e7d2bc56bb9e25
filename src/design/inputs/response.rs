//! Inputs of the responses of workpiece, support and tool.

use nailnoise_dynamics::blow::BlowInput;
use nailnoise_dynamics::network::assembly::Base;
use nailnoise_dynamics::{BlowModel, blow_input};
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
        fastener: fastener(design, engine)?,
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

/// The elastic blows on the fasteners in the workpiece; none if all are rigid.
///
/// # Errors
/// Those of a cycle that are found before its run.
pub(crate) fn blows(design: &Design, engine: &Engine) -> Result<Vec<BlowInput>, Error> {
    Ok(fastener(design, engine)?.map_or_else(Vec::new, |fastener| fastener.blows))
}

/// The fastener in the workpiece; none for a tool that drives none.
///
/// # Errors
/// Those of a cycle that are found before its run.
fn fastener(design: &Design, engine: &Engine) -> Result<Option<DrivenFastener>, Error> {
    let (law, mut blows) = match engine {
        Engine::Keys(cycle) => {
            let parameters = &cycle.parameters;
            let blow = match parameters.model.blow {
                BlowModel::Rigid => None,
                BlowModel::Elastic => blow_input(parameters)?,
            };
            let law = FastenerLaw::Nail(Box::new(parameters.clone()));
            (law, blow.into_iter().collect::<Vec<_>>())
        }
        Engine::Assembly(cycle) => {
            let assembly = &cycle.assembly;
            let Some(workpiece) = body(assembly, WORKPIECE) else {
                return Ok(None);
            };
            let driven = || {
                let fasteners = assembly.fasteners.iter().enumerate();
                fasteners.filter(|(_, own)| own.into == Base::Body(workpiece))
            };
            let Some((_, first)) = driven().next() else {
                return Ok(None);
            };
            let blows = driven().filter_map(|(index, _)| BlowInput::of(assembly, index));
            (FastenerLaw::Fastener(first.clone()), blows.collect())
        }
    };
    let friction_share = design.wood.friction_share;
    for blow in &mut blows {
        blow.friction_share = friction_share;
    }
    Ok(Some(DrivenFastener {
        law,
        friction_share,
        blows,
    }))
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
