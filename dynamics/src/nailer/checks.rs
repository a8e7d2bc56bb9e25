//! The limits of the model, in terms of a design's keys.

use nailnoise_penetration::ResistanceLaw;
use nailnoise_quantities::dimension::{AREA, DAMPING, NUMBER, STIFFNESS};
use nailnoise_quantities::{Kind, Value, nonnegative, positive};

use crate::{CycleError, Parameters, SupportDamping};

/// Rejects designs outside the validity of the model.
pub(super) fn check(p: &Parameters) -> Result<(), CycleError> {
    check_numbers(p)?;
    let valve = &p.head_valve;
    if valve.exhaust_lap > valve.intake_lap {
        return Err(CycleError::LapOverlap {
            exhaust: valve.exhaust_lap,
            intake: valve.intake_lap,
        });
    }
    let order = |inner_name, inner: f64, outer_name, outer: f64| {
        if inner < outer {
            Ok(())
        } else {
            Err(CycleError::DiameterOrder {
                inner_name,
                inner,
                outer_name,
                outer,
            })
        }
    };
    order(
        "piston.rod_diameter",
        p.piston.rod_diameter,
        "piston.bore",
        p.piston.bore,
    )?;
    order(
        "head_valve.seat_diameter",
        valve.seat_diameter,
        "head_valve.outer_diameter",
        valve.outer_diameter,
    )?;
    order(
        "head_valve.inner_diameter",
        valve.inner_diameter,
        "head_valve.seat_diameter",
        valve.seat_diameter,
    )?;
    order("head_valve.intake_lap", valve.intake_lap, "head_valve.lift", valve.lift)?;
    order(
        "nail.head_thickness",
        p.nail.head_thickness,
        "nail.length",
        p.nail.length,
    )?;
    if p.nail.length > p.workpiece.thickness - p.workpiece.groove {
        return Err(CycleError::NailLongerThanBlock {
            length: p.nail.length,
            thickness: p.workpiece.thickness - p.workpiece.groove,
        });
    }
    if p.nail.length > p.nail.feed_height {
        return Err(CycleError::NailBelowNose {
            length: p.nail.length,
            feed_height: p.nail.feed_height,
        });
    }
    if p.nail.head_gap(&p.piston) <= 0.0 {
        return Err(CycleError::NailAboveRod {
            feed_height: p.nail.feed_height,
            stroke: p.piston.stroke,
            protrusion: p.piston.rod_protrusion,
        });
    }
    if p.wood.penetration_law == ResistanceLaw::Fitted && p.penetration_table.is_none() && p.penetration_fit.is_none() {
        return Err(CycleError::NoFit);
    }
    if let Some(table) = &p.penetration_table
        && table.last_depth() < p.nail.length * (1.0 - 1e-9)
    {
        return Err(CycleError::TableTooShort {
            last: table.last_depth(),
            length: p.nail.length,
        });
    }
    Ok(())
}

fn check_numbers(p: &Parameters) -> Result<(), CycleError> {
    let mut problem = None;
    let mut check = |name: &str, value: f64, kind: Kind| {
        if !kind.allows(value) && problem.is_none() {
            problem = Some(CycleError::Value {
                name: name.to_owned(),
                value,
                rule: kind.allowed().into(),
            });
        }
    };
    let has_hand_mass = p.hand.mass > 0.0;
    p.visit(&mut |name, spec, value| match (spec.kind, value) {
        _ if name == "hand.stiffness" && !has_hand_mass => {}
        (Kind::Quantity { .. }, Value::Number(value)) => check(name, value, spec.kind),
        (Kind::Count(_), Value::Count(count)) => check(name, f64::from(count), spec.kind),
        _ => {}
    });
    check("support.stiffness", p.support.stiffness, positive(STIFFNESS));
    match p.support.damping {
        SupportDamping::Ratio(ratio) => check("support.damping", ratio, nonnegative(NUMBER)),
        SupportDamping::Coefficient(coefficient) => check("support.damping", coefficient, nonnegative(DAMPING)),
    }
    if let Some(area) = p.muffler_area {
        check("muffler_area", area, positive(AREA));
    }
    if let Some(problem) = problem {
        return Err(problem);
    }
    if p.supply.pressure < p.ambient.pressure {
        return Err(CycleError::Value {
            name: "supply.pressure".to_owned(),
            value: p.supply.pressure,
            rule: "at least ambient.pressure; give it as absolute pressure".into(),
        });
    }
    Ok(())
}
