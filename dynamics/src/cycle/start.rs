//! The state before the shot: valve closed, tool pressed on the wood, everything at rest.

use nailnoise_quantities::dimension::{AREA, DAMPING, NUMBER, STIFFNESS};
use nailnoise_quantities::{Kind, Value, nonnegative, positive};

use super::forces::{SPRING, SPRING_LIMIT};
use super::mode::{Channel, Contact, Mode, NailState, Penetration};
use super::state::*;
use super::system::System;
use super::wood::DrivenWood;
use crate::{CycleError, Parameters, SupportDamping, WoodMotion};
use nailnoise_penetration::ResistanceLaw;

/// Rejects designs outside the validity of the model.
pub(crate) fn check(p: &Parameters) -> Result<(), CycleError> {
    check_numbers(p)?;
    let valve = &p.head_valve;
    if valve.lift + valve.spring_preload > SPRING_LIMIT * (1.0 + 1e-12) {
        return Err(CycleError::SpringRange {
            lift: valve.lift,
            preload: valve.spring_preload,
            limit: SPRING_LIMIT,
        });
    }
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

/// Force of the seated tool on the wood, F_hm + (M_g + M_p + M_h) g.
pub(crate) fn seat_force(system: &System) -> Result<f64, CycleError> {
    let p = &system.p;
    let press = p.hand.force + (p.tool.mass + p.piston.mass + p.head_valve.mass) * p.ambient.gravity;
    let guard = system.guard_stiffness * p.contacts.guard_travel;
    if press <= guard {
        return Err(CycleError::NotSeated { guard, press });
    }
    Ok(press)
}

/// State and mode at the trigger pull.
///
/// ```text
/// y_w = [F_hm + (M_w + M_g + M_p + M_h) g]/k_ws
/// y_g = y_w + [F_hm + (M_g + M_p + M_h) g - k_esg y_msg]/(k_wsn + k_esg)
/// y_m = y_g + F_hm/k_m
/// y_hr = L_h + F_close/k_hc2,  F_close = P_h A_h1 - P_ext A_h2 - P_1 A_h3 + F_s(y_sp) + M_h g
/// ```
///
/// On external wood, y_w is its rest position.
pub(crate) fn start(system: &System, rest: Option<&WoodMotion>) -> Result<(State, Mode), CycleError> {
    let (p, geometry) = (&system.p, &system.geometry);
    let gravity = p.ambient.gravity;
    let tool = seat_force(system)?;
    let guard = system.guard_stiffness * p.contacts.guard_travel;
    let y_w = rest.map_or(
        (tool + geometry.workpiece_mass * gravity) / p.support.stiffness,
        |rest| rest.seat[0],
    );
    let y_g = y_w + (tool - guard) / (p.contacts.nose_stiffness + system.guard_stiffness);
    let (supply, ambient) = (p.supply.pressure, p.ambient.pressure);
    let spring = p.head_valve.spring_scale
        * SPRING
            .iter()
            .rev()
            .fold(0.0, |sum, c| sum * p.head_valve.spring_preload + c);
    let close = supply * (geometry.valve_control_area - geometry.valve_supply_area) - ambient * system.underside_area
        + spring
        + p.head_valve.mass * gravity;
    if close <= 0.0 {
        return Err(CycleError::ValveNotClosed { force: close });
    }

    let mut y = [0.0; SIZE];
    y[Y_P] = y_g;
    y[Y_G] = y_g;
    y[Y_H] = y_g + p.head_valve.lift + close / p.contacts.seat_stiffness;
    (y[Y_W], y[V_W]) = if rest.is_some() { (0.0, 1.0) } else { (y_w, 0.0) };
    if system.sprung_hand {
        y[Y_M] = y_g + p.hand.force / p.hand.stiffness;
    }
    let volume = system.instant(&y).volume;
    for (i, pressure) in [ambient, ambient, ambient, supply, supply].into_iter().enumerate() {
        y[ENERGY + i] = pressure * volume[i] / (system.air.gamma - 1.0);
        y[MASS + i] = pressure * volume[i] / (system.air.gas_constant * p.ambient.temperature);
    }
    let mut closed = [false; Contact::COUNT];
    closed[Contact::Seat as usize] = true;
    closed[Contact::Nose as usize] = true;
    closed[Contact::Support as usize] = rest.is_none();
    let mode = Mode {
        closed,
        guard: true,
        intake: false,
        exhaust: true,
        check_holes: p.chambers.check_hole_position <= 0.0,
        penetration: Penetration::Free {
            deepest: 0.0,
            force: 0.0,
        },
        nail: NailState::Waiting,
        channel: Channel::Closed,
        impact: system.envelope.usual_impact(),
        released: false,
        wood: rest.map(DrivenWood::at_rest),
    };
    Ok((y, mode))
}
