//! The base design: events, peaks and masses of the reference implementations, conservation, and the order of events.

use std::sync::LazyLock;

use nailnoise_dynamics::{CycleRecord, Method, Outcome, Settings, simulate};

use crate::common::n80cb;
use crate::{BASE, internal_forces_cancel};

/// The same cycle recorded to 100 ms, where the reference masses were taken.
static LONG: LazyLock<CycleRecord> = LazyLock::new(|| {
    let settings = Settings {
        tail: 1.0,
        ..Settings::default()
    };
    simulate(&n80cb(), &settings).unwrap()
});

/// Published table of the reference implementations \[ms\].
const TABLE: [f64; 19] = [
    0.0, 11.526, 11.740, 14.369, 15.073, 17.188, 17.401, 18.308, 19.430, 21.831, 24.174, 26.033, 28.826, 42.972,
    44.774, 65.067, 75.648, 76.495, 80.658,
];
/// Thresholds on slow or decaying motion.
const LOOSE: [usize; 4] = [2, 10, 11, 18];

fn apart(a: &CycleRecord, b: &CycleRecord) -> [f64; 19] {
    let (a, b) = (a.figures.events.to_array(), b.figures.events.to_array());
    std::array::from_fn(|i| (a[i].unwrap() - b[i].unwrap()).abs())
}

#[test]
fn events_equal_the_reference_table() {
    for (i, (event, expected)) in BASE.figures.events.to_array().into_iter().zip(TABLE).enumerate() {
        let limit = if LOOSE.contains(&i) { 60e-6 } else { 10e-6 };
        let event = event.unwrap();
        assert!(
            (event - expected * 1e-3).abs() < limit,
            "t{i}: {event} s, table {expected} ms"
        );
    }
}

#[test]
fn the_nail_is_driven() {
    assert_eq!(BASE.figures.outcome, Outcome::Drives);
}

#[test]
fn events_hold_at_a_hundredfold_tolerance() {
    let tight = Settings {
        relative_tolerance: 1e-2 * Settings::default().relative_tolerance,
        ..Settings::default()
    };
    let tight = simulate(&n80cb(), &tight).unwrap();
    for (i, apart) in apart(&BASE, &tight).into_iter().enumerate() {
        assert!(apart < 5e-6, "t{i} moves by {apart} s");
    }
}

/// What two runs may differ by in each event \[s\]: t11 and t18 are thresholds on decaying motion.
fn limit(event: usize) -> f64 {
    if event == 11 || event == 18 { 20e-6 } else { 1e-6 }
}

#[test]
fn b11_halving_the_tolerance_moves_no_event_by_1_us() {
    for method in [Method::Switching, Method::Bdf, Method::Esdirk34] {
        let run = |part: f64| {
            let settings = Settings {
                method,
                relative_tolerance: part * Settings::default().relative_tolerance,
                ..Settings::default()
            };
            simulate(&n80cb(), &settings).unwrap()
        };
        for (i, apart) in apart(&run(1.0), &run(0.5)).into_iter().enumerate() {
            assert!(apart < limit(i), "{method:?}: t{i} moves by {apart} s");
        }
    }
}

#[test]
fn all_methods_agree() {
    for method in [Method::Bdf, Method::Esdirk34] {
        let settings = Settings {
            method,
            ..Settings::default()
        };
        let other = simulate(&n80cb(), &settings).unwrap();
        for (i, apart) in apart(&BASE, &other).into_iter().enumerate() {
            assert!(apart < limit(i), "{method:?}: t{i} differs by {apart} s");
        }
        assert!(other.is_certified(), "{method:?}: {:?}", other.figures.checks);
    }
}

#[test]
fn peaks_equal_the_reference() {
    let s = &BASE.figures.summary;
    let close = |name, value: f64, expected: f64, part: f64| {
        assert!(
            (value / expected - 1.0).abs() < part,
            "{name}: {value}, reference {expected}"
        );
    };
    close("penetration", s.peak_penetration_force, 3345.0, 1e-3);
    close("cap", s.peak_cap_force, 10_235.0, 2e-3);
    close("seat", s.peak_seat_force, 1768.0, 2e-3);
    close("bumper", s.peak_bumper_force, 762.0, 2e-3);
    close("stopper", s.peak_stopper_force, 1521.0, 2e-3);
    close("support", s.peak_support_force, 8332.0, 2e-3);
}

#[test]
fn masses_at_100_ms_equal_the_reference() {
    let s = &LONG.figures.summary;
    let close = |name, value: f64, expected: f64| {
        assert!(
            (value - expected).abs() < 0.6e-6,
            "{name}: {value} kg, reference {expected} kg"
        );
    };
    close("exhaust", s.exhaust_mass, 2.269e-3);
    close("vent", s.vent_mass, 0.072e-3);
    close("leak", s.leak_mass, 0.046e-3);
    close("supply", s.supply_mass, 1.642e-3);
}

#[test]
fn b1_events_are_in_order() {
    let events = BASE.figures.events.to_array();
    assert!(
        events.windows(2).all(|pair| pair[0].unwrap() <= pair[1].unwrap()),
        "{events:?}"
    );
}

#[test]
fn b2_mass_gas_energy_momentum_and_shot_energy_are_conserved() {
    assert_eq!(BASE.figures.checks.len(), 6);
    assert!(BASE.is_certified() && LONG.is_certified(), "{:?}", BASE.figures.checks);
}

#[test]
fn b14_forces_between_bodies_cancel_at_every_sample() {
    internal_forces_cancel(&n80cb(), &BASE);
}

#[test]
fn accelerations_follow_from_the_recorded_forces() {
    let (p, r) = (n80cb(), &*BASE);
    let f = |name: &str, i: usize| r.history(&format!("{name}.force"))[i];
    for i in (0..r.len()).step_by(7) {
        let piston = r.history("piston_gas_force")[i]
            - f("bumper", i)
            - f("stopper", i)
            - f("nail", i)
            - f("piston_friction", i);
        let tool = f("hand", i) - r.history("piston_gas_force")[i] - r.history("valve_gas_force")[i] - f("spring", i)
            + f("bumper", i)
            + f("stopper", i)
            + f("cap", i)
            + f("seat", i)
            + f("piston_friction", i)
            + f("valve_friction", i)
            - f("nose", i)
            - f("guard", i);
        let g = p.ambient.gravity;
        assert!((piston / r.history("piston.moving_mass")[i] + g - r.history("piston.acceleration")[i]).abs() < 1e-6);
        assert!((tool / p.tool.mass + g - r.history("tool.acceleration")[i]).abs() < 1e-6);
    }
}

#[test]
fn the_record_ends_5_ms_after_t18() {
    let r = &*BASE;
    let end = r.figures.events.t18.unwrap() + 5e-3;
    assert!(
        (r.time(r.len() - 1) - end).abs() <= r.sample_interval(),
        "{}",
        r.time(r.len() - 1)
    );
}

#[test]
fn the_record_ends_at_the_end_of_the_settings_if_the_tail_is_longer() {
    assert!((LONG.time(LONG.len() - 1) - 0.1).abs() <= 1e-9);
}

#[test]
fn velocity_is_the_derivative_of_position() {
    let r = &*BASE;
    let h = r.sample_interval();
    let jump = (r.figures.events.t5.unwrap() / h) as usize;
    for i in 1..r.len() - 1 {
        if i.abs_diff(jump) > 1 {
            let slope = (r.history("piston.position")[i + 1] - r.history("piston.position")[i - 1]) / (2.0 * h);
            assert!(
                (slope - r.history("piston.velocity")[i]).abs() < 0.02,
                "{i}: {slope} {}",
                r.history("piston.velocity")[i]
            );
        }
    }
}

#[test]
fn a_run_is_reproducible_to_the_bit() {
    assert_eq!(*BASE, simulate(&n80cb(), &Settings::default()).unwrap());
}
