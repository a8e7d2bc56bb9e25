//! Lengths and volumes of a design that are inconsistent in the drawing.
//!
//! The nailing cycle and the vibrating housing use different keys. A run does not need them to agree, but they do in a
//! real tool: a misfit reveals a wrong key, or a housing that still belongs to another tool.

use std::f64::consts::PI;

use super::layout::Layout;
use crate::design::Values;
use crate::wording::rounded;

/// Keys that are inconsistent.
#[derive(Debug, Clone, PartialEq)]
pub struct Misfit {
    /// The keys.
    pub keys: Vec<&'static str>,
    /// Description of the misfit, with numbers.
    pub text: String,
}

fn mm(length: f64) -> String {
    format!("{} mm", rounded(1e3 * length, 4, 1e6))
}

fn cm3(volume: f64) -> String {
    format!("{} cm\u{b3}", rounded(1e6 * volume, 3, 1e6))
}

/// All misfits of a design.
pub(super) fn misfits(v: &Values, l: &Layout) -> Vec<Misfit> {
    let (b, valve, c) = (&v.body, &v.head_valve, &v.chambers);
    let mut found = Vec::new();
    let mut check = |broken: bool, keys: &[&'static str], text: String| {
        if broken {
            let keys = keys.to_vec();
            found.push(Misfit { keys, text });
        }
    };
    check(
        v.piston.stroke + 12e-3 > b.sleeve_height,
        &["piston.stroke", "body.sleeve_height"],
        format!(
            "the sleeve of {} leaves less than 12 mm for piston and bumper beyond the stroke of {}",
            mm(b.sleeve_height),
            mm(v.piston.stroke)
        ),
    );
    check(
        valve.seat_diameter <= v.piston.bore,
        &["head_valve.seat_diameter", "piston.bore"],
        format!(
            "the seat of {} is not wider than the bore of {}: the ring has no seat on the cylinder",
            mm(valve.seat_diameter),
            mm(v.piston.bore)
        ),
    );
    check(
        valve.outer_diameter > 2.0 * l.barrel[1],
        &["head_valve.outer_diameter", "piston.bore", "body.sleeve_gap"],
        format!(
            "the head valve of {} is wider than the barrel, {} outside",
            mm(valve.outer_diameter),
            mm(2.0 * l.barrel[1])
        ),
    );
    check(
        valve.outer_diameter > 2.0 * l.barrel[0] && valve.outer_diameter <= 2.0 * l.barrel[1],
        &["head_valve.outer_diameter", "body.barrel_wall"],
        format!(
            "the head valve of {} needs a recess in the barrel, {} inside; the housing that vibrates has none",
            mm(valve.outer_diameter),
            mm(2.0 * l.barrel[0])
        ),
    );
    check(
        valve.exhaust_seat_diameter > valve.inner_diameter,
        &["head_valve.exhaust_seat_diameter", "head_valve.inner_diameter"],
        format!(
            "the seat of the exhaust ({}) is wider than the ring's bore ({})",
            mm(valve.exhaust_seat_diameter),
            mm(valve.inner_diameter)
        ),
    );
    let passage = b.nose_width - 2.0 * b.nose_wall;
    for (key, what, diameter) in [
        ("piston.rod_diameter", "the rod", v.piston.rod_diameter),
        ("nail.head_diameter", "the nail's head", v.nail.head_diameter),
    ] {
        check(
            diameter > passage,
            &[key, "body.nose_width", "body.nose_wall"],
            format!(
                "{what} of {} is wider than the passage of the nose, {}",
                mm(diameter),
                mm(passage)
            ),
        );
    }
    check(
        v.piston.stroke - v.piston.rod_protrusion > b.nose_height + b.barrel_wall,
        &["piston.stroke", "piston.rod_protrusion", "body.nose_height"],
        format!(
            "the rod ends {} above the nose's face before the shot, above the barrel's floor at {}",
            mm(v.piston.stroke - v.piston.rod_protrusion),
            mm(b.nose_height + b.barrel_wall)
        ),
    );
    let around = PI * (l.barrel[0].powi(2) - (l.bore + b.sleeve_wall).powi(2)) * b.sleeve_height;
    check(
        c.return_volume > 1.2 * around,
        &["chambers.return_volume", "body.sleeve_gap"],
        format!(
            "the gap around the sleeve has {} of the return volume of {}; the section shows the gap",
            cm3(around),
            cm3(c.return_volume)
        ),
    );
    let tube = b.handle_radius - b.handle_wall;
    let handle = PI * tube * tube * (l.handle_end - b.handle_wall - l.barrel[1]).max(0.0);
    check(
        c.supply_volume > 1.2 * handle,
        &["chambers.supply_volume", "body.handle_length", "body.handle_radius"],
        format!(
            "the handle has {} of the supply side's {}; the housing has no jacket for the rest",
            cm3(handle),
            cm3(c.supply_volume)
        ),
    );
    let drawn = PI * l.bore * l.bore * (l.seat - l.piston[0]);
    check(
        (drawn / c.above_piston - 1.0).abs() > 1e-6,
        &["chambers.above_piston", "body.sleeve_height"],
        format!(
            "the sleeve has room for {} of the dead volume of {} above the piston",
            cm3(drawn),
            cm3(c.above_piston)
        ),
    );
    let drawn = PI * (l.bore * l.bore - l.bumper_radius * l.bumper_radius) * (l.bumper - l.floor).max(1e-3);
    check(
        (drawn / c.below_piston - 1.0).abs() > 1e-6,
        &["chambers.below_piston", "body.sleeve_height"],
        format!(
            "the sleeve has room for {} of the dead volume of {} below the piston",
            cm3(drawn),
            cm3(c.below_piston)
        ),
    );
    let channel = l.channel_length();
    check(
        (channel - v.trigger.channel_length).abs() > 1e-6,
        &["trigger.channel_length", "body.handle_length"],
        format!(
            "the trigger channel of {} is drawn {} long, so that the trigger valve is on the handle",
            mm(v.trigger.channel_length),
            mm(channel)
        ),
    );
    found
}
