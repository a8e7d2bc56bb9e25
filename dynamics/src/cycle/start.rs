//! The state before the shot: valve closed, tool pressed on the wood, everything at rest.

use super::forces::{SPRING, SPRING_LIMIT};
use super::mode::{Channel, Contact, Mode, NailState, Penetration};
use super::state::*;
use super::system::System;
use super::wood::DrivenWood;
use crate::prf::ResistanceLaw;
use crate::{CycleError, Parameters, WoodMotion};

/// Refuses designs the model does not hold for.
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
    if p.nail.head_gap > p.nail.tip_gap {
        return Err(CycleError::GapOrder {
            head_gap: p.nail.head_gap,
            tip_gap: p.nail.tip_gap,
        });
    }
    if let ResistanceLaw::Tabulated(table) = &p.wood.law
        && table.last_depth() < p.nail.length * (1.0 - 1e-9)
    {
        return Err(CycleError::TableTooShort {
            last: table.last_depth(),
            length: p.nail.length,
        });
    }
    if p.nail.length > p.wood.thickness {
        return Err(CycleError::NailLongerThanBlock {
            length: p.nail.length,
            thickness: p.wood.thickness,
        });
    }
    Ok(())
}

fn check_numbers(p: &Parameters) -> Result<(), CycleError> {
    let positive = [
        ("supply.pressure", p.supply.pressure),
        ("piston.mass", p.piston.mass),
        ("piston.stroke", p.piston.stroke),
        ("piston.bore", p.piston.bore),
        ("piston.rod_diameter", p.piston.rod_diameter),
        ("head_valve.mass", p.head_valve.mass),
        ("head_valve.lift", p.head_valve.lift),
        ("head_valve.outer_diameter", p.head_valve.outer_diameter),
        ("head_valve.inner_diameter", p.head_valve.inner_diameter),
        ("head_valve.seat_diameter", p.head_valve.seat_diameter),
        ("head_valve.intake_angle", p.head_valve.intake_angle),
        ("head_valve.exhaust_angle", p.head_valve.exhaust_angle),
        ("head_valve.exhaust_seat_diameter", p.head_valve.exhaust_seat_diameter),
        ("chambers.above_piston", p.chambers.above_piston),
        ("chambers.below_piston", p.chambers.below_piston),
        ("chambers.return_volume", p.chambers.return_volume),
        ("chambers.above_valve", p.chambers.above_valve),
        ("chambers.supply_volume", p.chambers.supply_volume),
        ("chambers.return_hole_area", p.chambers.return_hole_area),
        ("chambers.discharge_coefficient", p.chambers.discharge_coefficient),
        ("exhaust.holes", f64::from(p.exhaust.holes)),
        ("exhaust.hole_diameter", p.exhaust.hole_diameter),
        ("trigger.channel_length", p.trigger.channel_length),
        ("trigger.channel_diameter", p.trigger.channel_diameter),
        ("trigger.vent_area", p.trigger.vent_area),
        ("trigger.fill_area", p.trigger.fill_area),
        ("nail.length", p.nail.length),
        ("nail.diameter", p.nail.diameter),
        ("nail.head_diameter", p.nail.head_diameter),
        ("nail.density", p.nail.density),
        ("nail.head_gap", p.nail.head_gap),
        ("wood.hardness_modulus", p.wood.hardness_modulus),
        ("wood.density", p.wood.density),
        ("wood.length", p.wood.length),
        ("wood.width", p.wood.width),
        ("wood.thickness", p.wood.thickness),
        ("wood.head_stiffness_scale", p.wood.head_stiffness_scale),
        ("wood.unloading_stiffness", p.wood.unloading_stiffness),
        ("contacts.bumper_stiffness", p.contacts.bumper_stiffness),
        ("contacts.stopper_stiffness", p.contacts.stopper_stiffness),
        ("contacts.cap_stiffness", p.contacts.cap_stiffness),
        ("contacts.seat_stiffness", p.contacts.seat_stiffness),
        ("contacts.nose_stiffness", p.contacts.nose_stiffness),
        ("contacts.guard_stiffness", p.contacts.guard_stiffness),
        ("contacts.guard_travel", p.contacts.guard_travel),
        ("tool.mass", p.tool.mass),
        ("support.stiffness", p.support.stiffness),
        ("ambient.pressure", p.ambient.pressure),
        ("ambient.temperature", p.ambient.temperature),
        ("ambient.gas_constant", p.ambient.gas_constant),
        ("ambient.viscosity", p.ambient.viscosity),
        ("model.polytropic", p.model.polytropic),
        ("model.polytropic_inflow", p.model.polytropic_inflow),
        ("model.polytropic_outflow", p.model.polytropic_outflow),
        ("model.friction_velocity", p.model.friction_velocity),
        ("model.stribeck_velocity", p.model.stribeck_velocity),
        ("model.orifice_linear", p.model.orifice_linear),
    ];
    let damping = match p.support.damping {
        crate::SupportDamping::Ratio(x) | crate::SupportDamping::Coefficient(x) => x,
    };
    let not_negative = [
        ("supply.hose_area", p.supply.hose_area),
        ("piston.friction.static_force", p.piston.friction.static_force),
        ("piston.friction.sliding_force", p.piston.friction.sliding_force),
        ("piston.friction.viscous", p.piston.friction.viscous),
        ("head_valve.friction.static_force", p.head_valve.friction.static_force),
        ("head_valve.friction.sliding_force", p.head_valve.friction.sliding_force),
        ("head_valve.friction.viscous", p.head_valve.friction.viscous),
        ("head_valve.intake_lap", p.head_valve.intake_lap),
        ("head_valve.exhaust_lap", p.head_valve.exhaust_lap),
        ("head_valve.spring_preload", p.head_valve.spring_preload),
        ("chambers.check_hole_area", p.chambers.check_hole_area),
        ("chambers.check_hole_position", p.chambers.check_hole_position),
        ("chambers.leak_area", p.chambers.leak_area),
        ("chambers.wall_heat_transfer", p.chambers.wall_heat_transfer),
        ("chambers.wall_above_piston", p.chambers.wall_above_piston),
        ("chambers.wall_below_piston", p.chambers.wall_below_piston),
        ("chambers.wall_return", p.chambers.wall_return),
        ("chambers.wall_above_valve", p.chambers.wall_above_valve),
        ("chambers.wall_supply", p.chambers.wall_supply),
        ("nail.head_thickness", p.nail.head_thickness),
        ("nail.tip_gap", p.nail.tip_gap),
        ("wood.resistance_scale", p.wood.resistance_scale),
        ("contacts.bumper_damping", p.contacts.bumper_damping),
        ("contacts.stopper_damping", p.contacts.stopper_damping),
        ("contacts.valve_damping_ratio", p.contacts.valve_damping_ratio),
        ("contacts.nose_damping_ratio", p.contacts.nose_damping_ratio),
        ("nail.magazine_friction", p.nail.magazine_friction),
        ("hand.force", p.hand.force),
        ("hand.mass", p.hand.mass),
        ("hand.damping", p.hand.damping),
        ("support.damping", damping),
        ("ambient.gravity", p.ambient.gravity),
    ];
    for (name, value) in positive {
        if !(value > 0.0 && value.is_finite()) {
            return Err(CycleError::Value {
                name,
                value,
                rule: "a positive finite number",
            });
        }
    }
    for (name, value) in not_negative {
        if !(value >= 0.0 && value.is_finite()) {
            return Err(CycleError::Value {
                name,
                value,
                rule: "a finite number that is not negative",
            });
        }
    }
    let finite = [
        ("wood.speed_term", p.wood.speed_term),
        ("wood.slenderness_term", p.wood.slenderness_term),
    ];
    for (name, value) in finite {
        if !value.is_finite() {
            return Err(CycleError::Value {
                name,
                value,
                rule: "a finite number",
            });
        }
    }
    if let ResistanceLaw::Constant(value) = p.wood.law
        && !(value >= 0.0 && value.is_finite())
    {
        return Err(CycleError::Value {
            name: "wood.law",
            value,
            rule: "a constant force that is finite and not negative",
        });
    }
    if p.hand.mass > 0.0 && !(p.hand.stiffness > 0.0 && p.hand.stiffness.is_finite()) {
        return Err(CycleError::Value {
            name: "hand.stiffness",
            value: p.hand.stiffness,
            rule: "a positive finite number where hand.mass is given",
        });
    }
    if !(-1.0..=1.0).contains(&p.exhaust.thrust_share) {
        return Err(CycleError::Value {
            name: "exhaust.thrust_share",
            value: p.exhaust.thrust_share,
            rule: "from -1 (all thrust up) to 1 (all thrust towards the wood)",
        });
    }
    if let Some(area) = p.exhaust.muffler_area
        && !(area > 0.0 && area.is_finite())
    {
        return Err(CycleError::Value {
            name: "exhaust.muffler_area",
            value: area,
            rule: "a positive finite number, or absent where there is no muffler",
        });
    }
    let gamma = p.ambient.heat_capacity_ratio;
    if !(gamma > 1.0 && gamma.is_finite()) {
        return Err(CycleError::Value {
            name: "ambient.heat_capacity_ratio",
            value: gamma,
            rule: "above 1",
        });
    }
    if p.supply.pressure < p.ambient.pressure {
        let rule = "at least ambient.pressure; give it as absolute pressure";
        return Err(CycleError::Value {
            name: "supply.pressure",
            value: p.supply.pressure,
            rule,
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
/// On a wood outside the cycle y_w is where that rests.
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
    let spring = SPRING
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
        released: false,
        wood: rest.map(DrivenWood::at_rest),
    };
    Ok((y, mode))
}
