//! The N80CB as an assembly against the equations of the fixed cycle, for all forms and options.

use nailnoise_dynamics::network::{Numerics, Record};
use nailnoise_dynamics::{CycleRecord, Form, Method, Outcome, Parameters, Settings, network, simulate};
use nailnoise_penetration::{ForceTable, HeadLaw, PenetrationLaw, RateLaw, ResistanceLaw};

use crate::common::n80cb;
use crate::n80cb_assembly::n80cb_assembly;

/// A law of plywood.
const PLYWOOD: ResistanceLaw = ResistanceLaw::Published(PenetrationLaw::Smooth);
/// Tolerance of the integration.
const TOLERANCE: f64 = 1e-9;

fn both(p: &Parameters) -> (CycleRecord, Record) {
    let settings = Settings {
        relative_tolerance: TOLERANCE,
        ..Settings::default()
    };
    let numerics = Numerics {
        method: Method::Bdf,
        relative_tolerance: TOLERANCE,
        sample_interval: Some(settings.sample_interval),
    };
    let assembly = n80cb_assembly(p, settings.end, settings.tail);
    (
        simulate(p, &settings).unwrap(),
        network::simulate(&assembly, &numerics).unwrap_or_else(|error| panic!("{error}")),
    )
}

/// Asserts that both engines give the same shot; events to `apart` \[s\], peaks and masses to `part`.
fn agree(p: &Parameters, apart: f64, part: f64) {
    let (old, new) = both(p);
    let mut worst: (f64, String) = (0.0, String::new());
    for (i, time) in old.events.to_array().into_iter().enumerate() {
        let name = format!("t{i}");
        match (time, new.event(&name)) {
            (None, None) => {}
            (Some(a), Some(b)) => {
                if (a - b).abs() >= worst.0 {
                    worst = ((a - b).abs(), name);
                }
            }
            (a, b) => panic!("{name}: {a:?} {b:?}"),
        }
    }
    let s = &old.summary;
    let mass = |passage: &str| new.integral(&format!("mass.{passage}")).unwrap_or(0.0);
    let mut rows = vec![
        ("nail", new.peak("nail").unwrap(), s.peak_penetration_force),
        ("bumper", new.peak("bumper").unwrap(), s.peak_bumper_force),
        ("stopper", new.peak("stopper").unwrap(), s.peak_stopper_force),
        ("cap", new.peak("cap").unwrap(), s.peak_cap_force),
        ("seat", new.peak("seat").unwrap(), s.peak_seat_force),
        ("nose", new.peak("nose").unwrap(), s.peak_nose_force),
        ("support", new.peak("support").unwrap(), s.peak_support_force),
        ("exhaust", mass("exhaust"), s.exhaust_mass),
        ("vent", mass("vent"), s.vent_mass),
        ("leak", mass("leak"), s.leak_mass),
        ("refill", mass("refill"), s.supply_mass),
        ("end", new.end, (old.len() - 1) as f64 * old.sample_interval),
    ];
    if let (Some(before), Some(strike)) = (s.speed_before_impact, new.strikes.first()) {
        rows.push(("before", strike.before, before));
        rows.push(("after", strike.after, s.speed_after_impact.unwrap()));
    }
    let last = |channel: &str| new.get(channel).and_then(|values| values.last().copied()).unwrap();
    rows.push(("penetration", last("nail.deepest"), s.penetration));
    for (volume, own) in [
        ("above_piston", &old.above_piston),
        ("supply", &old.supply),
        ("above_valve", &old.above_valve),
    ] {
        rows.push((
            volume,
            last(&format!("{volume}.pressure")),
            *own.pressure.last().unwrap(),
        ));
        rows.push((
            volume,
            last(&format!("{volume}.temperature")),
            *own.temperature.last().unwrap(),
        ));
    }
    let outcome = serde_json::to_value(old.outcome).unwrap();
    let largest = rows
        .iter()
        .map(|(name, found, expected)| ((found - expected).abs() / expected.abs().max(1e-6), *name))
        .fold((0.0, ""), |a, b| if b.0 > a.0 { b } else { a });
    println!("{:e} s at {}, {:e} of {}", worst.0, worst.1, largest.0, largest.1);
    assert!(worst.0 <= apart, "{} differs by {:e} s", worst.1, worst.0);
    for (name, found, expected) in rows {
        let room = if name == "end" { old.sample_interval } else { 0.0 };
        assert!(
            (found - expected).abs() <= part * expected.abs() + 1e-12 + room,
            "{name}: {found} is not {expected}"
        );
    }
    assert_eq!(new.outcome.as_deref(), outcome.as_str());
}

fn changed(change: impl FnOnce(&mut Parameters)) -> Parameters {
    let mut p = n80cb();
    change(&mut p);
    p
}

macro_rules! agrees {
    ($($name:ident: $change:expr, $apart:expr, $part:expr;)+) => {$(
        #[test]
        fn $name() {
            agree(&changed($change), $apart, $part);
        }
    )+};
}

agrees! {
    base_design: |_| {}, 1e-8, 1e-5;
    resistance_over_speed: |p| p.wood.rate = RateLaw::Speed, 1e-8, 1e-5;
    a_head_that_yields: |p| p.wood.head_law = HeadLaw::Yields, 1e-8, 1e-5;
    a_coated_nail: |p| p.nail.coating = 0.7, 1e-8, 1e-5;
    a_staple: |p| { p.nail.legs = 2; p.nail.diameter = 0.002; p.wood.resistance_scale = 0.5; }, 1e-8, 1e-5;
    a_law_of_plywood: |p| p.wood.penetration_law = PLYWOOD, 1e-8, 1e-5;
    a_constant_force: constant_force, 1e-8, 1e-5;
    a_table: |p| p.penetration_table = Some(table()), 1e-8, 1e-5;
    a_muffler: |p| p.muffler_area = Some(2e-4), 1e-8, 1e-5;
    a_hand_with_mass: |p| p.hand.mass = 1.5, 1e-8, 1e-5;
    thrust: |p| p.exhaust.thrust_share = 0.5, 1e-8, 1e-5;
    release_by_the_operator: |p| p.trigger.release_after = 0.03, 1e-8, 1e-5;
    a_tool_that_hardly_recoils: low_recoil, 1e-8, 1e-5;
    published_gas: |p| p.model.gas = Form::Published, 1e-8, 1e-5;
    published_valve_underside: |p| p.model.valve_underside = Form::Published, 1e-8, 5e-4;
    published_nail: |p| p.model.nail = Form::Published, 1e-8, 1e-5;
    published_impact: |p| p.model.impact = Form::Published, 1e-8, 1e-5;
    published_contacts: |p| p.model.contacts = Form::Published, 1e-8, 1e-5;
    published_intake: |p| p.model.intake = Form::Published, 1e-8, 1e-5;
    published_delay: |p| p.model.delay = Form::Published, 1e-6, 5e-4;
    published_channel: |p| p.model.channel = Form::Published, 1e-8, 1e-5;
    published_refill: |p| p.model.refill = Form::Published, 1e-8, 1e-5;
    published_nail_only: |p| *p = n80cb().published_nail_only(), 1e-8, 1e-5;
    published_all: |p| *p = n80cb().published_all(), 1e-8, 1e-5;
    a_guided_nail: |p| p.nail.magazine_friction = 20.0, 1e-8, 1e-5;
}

fn constant_force(p: &mut Parameters) {
    p.wood.penetration_law = ResistanceLaw::Constant;
    p.wood.penetration_force = 900.0;
}

fn low_recoil(p: &mut Parameters) {
    p.contacts.guard_travel = 30e-3;
    p.hand.force = 300.0;
    p.trigger.release_after = 0.035;
}

fn table() -> ForceTable {
    ForceTable::new(
        vec![0.0, 0.01, 0.03, 0.06, 0.09],
        vec![0.0, 300.0, 900.0, 1600.0, 2500.0],
    )
    .unwrap()
}

#[test]
fn outcomes() {
    let soft = changed(|p| p.wood.hardness_modulus *= 0.9);
    let hard = changed(|p| p.wood.hardness_modulus *= 1.3);
    let stuck = changed(|p| p.head_valve.seat_diameter = 0.0655);
    let heavy = changed(|p| {
        p.hand.force = 1500.0;
        p.nail.overdrive_limit = 0.05;
    });
    let mut deep = soft.clone();
    deep.nail.overdrive_limit = 0.02;
    for (p, expected) in [
        (soft, Outcome::Overdriven),
        (deep, Outcome::StrikesBumper),
        (hard, Outcome::Underdriven),
        (stuck, Outcome::DoesNotOpen),
        (heavy, Outcome::DoesNotRelease),
    ] {
        let (old, new) = both(&p);
        assert_eq!(old.outcome, expected);
        let word = serde_json::to_value(expected).unwrap();
        assert_eq!(new.outcome.as_deref(), word.as_str());
    }
}
