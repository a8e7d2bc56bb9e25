//! The cycle against an independent fixed-step integration.

use nailnoise_dynamics::{CycleRecord, Method, Parameters, Settings, simulate};

use crate::common::n80cb;
use crate::reference;

/// Most by which an event may differ \[s\].
const LIMIT: f64 = 1e-6;
/// The same where a slow motion passes a threshold: t11 and t18.
const LIMIT_REST: f64 = 20e-6;

fn run(p: &Parameters, method: Method, part: f64, end: f64) -> CycleRecord {
    let settings = Settings {
        method,
        relative_tolerance: part * Settings::default().relative_tolerance,
        end,
        ..Settings::default()
    };
    simulate(p, &settings).unwrap()
}

/// All methods agree with the reference on every event up to `end`, and with themselves at half the tolerance.
fn agree(p: &Parameters, end: f64) {
    agree_within(p, end, LIMIT);
}

fn agree_within(p: &Parameters, end: f64, limit: f64) {
    let reference = reference::integrate(p, 1e-7, end);
    for method in [Method::Switching, Method::Bdf, Method::Esdirk34] {
        let (record, half) = (run(p, method, 1.0, end), run(p, method, 0.5, end));
        let others = [
            ("the reference", reference.events),
            ("half the tolerance", half.figures.events.to_array()),
        ];
        for (name, other) in others {
            for (i, (a, b)) in record.figures.events.to_array().into_iter().zip(other).enumerate() {
                match (a, b) {
                    (Some(a), Some(b)) => {
                        let limit = if matches!(i, 11 | 18) { LIMIT_REST } else { limit };
                        assert!((a - b).abs() < limit, "{method:?}, t{i}: {a} s, {name} {b} s");
                    }
                    (None, None) => {}
                    _ => panic!("{method:?}, t{i}: {a:?}, {name} {b:?}"),
                }
            }
        }
        match (record.figures.summary.full_penetration, reference.full) {
            (Some(a), Some(b)) => assert!((a - b).abs() < 1e-6, "full depth: {a} s, reference {b} s"),
            (None, None) => {}
            other => panic!("full depth: {other:?}"),
        }
    }
}

#[test]
fn base_design_to_the_end() {
    agree(&n80cb(), 0.0835);
}

#[test]
fn a_soft_wood() {
    let mut p = n80cb();
    p.wood.hardness_modulus *= 0.85;
    agree(&p, 0.030);
}

#[test]
fn a_light_tool() {
    let mut p = n80cb();
    p.tool.mass = 3.4;
    p.contacts.nose_stiffness = 1e7;
    agree(&p, 0.045);
}

#[test]
fn a_low_supply_pressure() {
    let mut p = n80cb();
    p.supply.pressure = 600e3;
    agree(&p, 0.045);
}

#[test]
fn a_trigger_released_by_the_operator() {
    let mut p = n80cb();
    // A tool that does not rise far enough to release the trigger itself.
    p.contacts.guard_travel = 30e-3;
    p.hand.force = 300.0;
    p.trigger.release_after = 0.035;
    agree(&p, 0.055);
}

#[test]
fn a_hand_with_mass_a_magazine_with_friction_and_a_jet_with_thrust() {
    let mut p = n80cb();
    p.hand.mass = 1.2;
    p.wood.speed_term = -118.0;
    p.wood.slenderness_term = -1.12;
    p.nail.magazine_friction = 20.0;
    p.exhaust.thrust_share = 0.7;
    // ESDIRK is 1.2 us off at t14, where the piston has just begun to move.
    agree_within(&p, 0.070, 2.0 * LIMIT);
}

/// The published forms: a polytropic gas, flows of the trigger's channel that arrive late, contacts that pull, an
/// elastic nail without an impact.
#[test]
fn the_published_variant() {
    let p = n80cb().published_all();
    let end = 0.120;
    let reference = reference::integrate(&p, 1e-7, end);
    let record = run(&p, Method::Switching, 0.01, end);
    let events = record.figures.events.to_array().into_iter().zip(reference.events);
    for (i, (found, expected)) in events.enumerate() {
        match (found, expected) {
            (Some(found), Some(expected)) => {
                assert!(
                    (found - expected).abs() < 4e-6,
                    "t{i}: {found} s, the reference {expected} s"
                );
            }
            (None, None) => {}
            other => panic!("t{i}: {other:?}"),
        }
    }
    assert!(reference.events.iter().flatten().count() > 12, "{:?}", reference.events);
}
