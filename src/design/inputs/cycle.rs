//! Inputs of the nailing cycle: its parameters, and the settings of its integration.

use std::path::Path;

use nailnoise_dynamics as dynamics;
use nailnoise_dynamics::BlowModel;
use nailnoise_penetration::fit::{Conditions, Driving, FittedLaw};
use nailnoise_penetration::{HeadLaw, NailedWood, RateLaw, ResistanceLaw, Specimen};

use crate::design::{Design, MufflerKind};
use crate::error::Error;
use crate::model::supports;
use crate::penetration::{self, PenetrationError};

/// Settings for integrating and recording the cycle of a design.
pub fn cycle_settings(design: &Design) -> dynamics::Settings {
    let analysis = &design.analysis;
    dynamics::Settings {
        relative_tolerance: analysis.cycle_tolerance,
        sample_interval: analysis.time_step,
        end: analysis.cycle_end,
        tail: analysis.cycle_tail,
        ..dynamics::Settings::default()
    }
}

/// Parameters of the cycle of a design.
///
/// # Errors
/// [`Error::Sand`] when the sand's constants are outside the range of the foundation's formulas; [`Error::Design`] for
/// a design with its own assembly.
pub fn parameters(design: &Design) -> Result<dynamics::Parameters, Error> {
    design.refuse_assembly()?;
    let muffler = &design.exhaust.muffler;
    Ok(dynamics::Parameters {
        supply: design.supply.clone(),
        piston: piston(design),
        head_valve: design.head_valve.clone(),
        chambers: design.chambers.clone(),
        exhaust: design.exhaust.cycle.clone(),
        muffler_area: (muffler.kind != MufflerKind::None).then_some(muffler.flow_area),
        trigger: design.trigger.clone(),
        nail: design.nail.cycle.clone(),
        wood: wood(design),
        friction_share: design.wood.friction_share,
        penetration_table: None,
        penetration_fit: fitted_law(design)?,
        workpiece: design.workpiece.block.clone(),
        contacts: design.contacts.clone(),
        tool: design.tool.clone(),
        hand: design.hand.clone(),
        support: supports::of(design).lumped()?,
        ambient: design.ambient.clone(),
        model: design.model.clone(),
    })
}

/// Valid values of the keys that a cycle does not use \[m\], \[Pa\], \[m/s\].
const UNUSED_LENGTH: f64 = 1.0;
const UNUSED_MODULUS: f64 = 2e11;
const UNUSED_SPEED: f64 = 1000.0;
const UNUSED_WIDTH: f64 = 4e-3;

/// The piston without the values that only an elastic blow uses, if the blow is rigid. Values that a cycle does not use
/// are not part of its key, so that no study draws them.
fn piston(design: &Design) -> dynamics::Piston {
    let mut piston = design.piston.clone();
    if design.model.blow == BlowModel::Rigid {
        piston.rod_length = UNUSED_LENGTH;
        piston.rod_modulus = UNUSED_MODULUS;
    }
    piston
}

/// The wood without the values of laws that the design does not use, like [`piston`].
fn wood(design: &Design) -> NailedWood {
    let mut wood = design.wood.cycle.clone();
    if design.model.blow == BlowModel::Rigid {
        wood.shear_speed = UNUSED_SPEED;
    }
    if wood.rate == RateLaw::None {
        wood.crushing_rate = 0.0;
        wood.friction_at_rest = 1.0;
        wood.friction_sliding = 1.0;
        wood.friction_speed = 1.0;
    }
    if wood.head_law == HeadLaw::Linear {
        wood.head_yield_scale = 1.0;
    }
    if wood.ring_amplitude == 0.0 {
        (wood.ring_width, wood.ring_seed) = (UNUSED_WIDTH, 1);
    }
    wood
}

/// The fitted penetration law of a design, if the design uses one.
///
/// # Errors
/// [`Error::Penetration`] if the file contains no law, or if the nail and wood are outside the range of its data and
/// extrapolation is not allowed.
pub fn fitted_law(design: &Design) -> Result<Option<FittedLaw>, Error> {
    let wood = &design.wood;
    if wood.penetration_law != ResistanceLaw::Fitted || wood.penetration_fit.is_empty() {
        return Ok(None);
    }
    let path = Path::new(&wood.penetration_fit);
    let law = penetration::fitted(path)?;
    if !law.file().extrapolate {
        // The cycle checks the impact speed, which is one of its results.
        let outside = law
            .placement(&conditions(design, &law, None))
            .into_iter()
            .find(|place| !place.inside);
        if let Some(place) = outside {
            return Err(PenetrationError::Beyond {
                path: path.to_owned(),
                variable: place.variable,
                value: place.value,
                range: place.range,
            }
            .into());
        }
    }
    Ok(Some(match design.law_scores() {
        [] => law,
        scores => law.drawn(scores),
    }))
}

/// Conditions of a design's shot in the variables of the law; `impact` is the speed of the rod when it meets the nail
/// \[m/s\].
pub fn conditions(design: &Design, law: &FittedLaw, impact: Option<f64>) -> Conditions {
    Conditions {
        specimen: Specimen {
            length: design.nail.length,
            diameter: design.nail.diameter,
            hardness_modulus: design.wood.hardness_modulus,
            density: design.wood.density,
        },
        driving: match impact {
            Some(speed) => Driving::Impact {
                mass: design.piston.mass,
                speed,
            },
            None => Driving::Constant {
                speed: law.reference_speed(),
            },
        },
    }
}
