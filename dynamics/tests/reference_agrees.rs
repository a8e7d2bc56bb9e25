//! The cycle against an independent fixed-step integration.

#![allow(clippy::unwrap_used)]

mod reference;

use nailnoise_dynamics::{CycleRecord, Parameters, Settings, simulate};

fn compared(record: &CycleRecord) -> [Option<f64>; 16] {
    let e = &record.events;
    let full = record.summary.full_penetration;
    [
        e.t1, e.t2, e.t3, e.t4, e.t5, e.t6, e.t7, e.t8, e.t9, e.t10, e.t12, e.t13, e.t15, e.t16, e.t17, full,
    ]
}

fn agree(p: &Parameters, end: f64, limit: f64) {
    let record = simulate(
        p,
        &Settings {
            end,
            ..Settings::default()
        },
    )
    .unwrap();
    let found = reference::integrate(p, 1e-7, end);
    for ((name, a), b) in reference::EVENTS.iter().zip(compared(&record)).zip(found) {
        match (a, b) {
            (Some(a), Some(b)) => assert!((a - b).abs() < limit, "{name}: {a} s, reference {b} s"),
            (None, None) => {}
            _ => panic!("{name}: {a:?}, reference {b:?}"),
        }
    }
}

#[test]
fn base_design_to_the_end_of_the_exhaust() {
    agree(&Parameters::n80cb(), 0.0768, 1e-6);
}

#[test]
fn a_soft_wood_a_light_tool_and_a_low_pressure() {
    let mut soft = Parameters::n80cb();
    soft.wood.hardness_modulus *= 0.85;
    agree(&soft, 0.030, 1e-6);
    let mut light = Parameters::n80cb();
    light.tool.mass = 3.4;
    light.contacts.nose_stiffness = 1e7;
    agree(&light, 0.045, 1e-6);
    let mut low = Parameters::n80cb();
    low.supply.pressure = 600e3;
    agree(&low, 0.045, 1e-6);
}
