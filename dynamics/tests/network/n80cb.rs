//! The N80CB as a network against the fixed cycle.

use nailnoise_dynamics::network::{Numerics, Record, simulate};
use nailnoise_dynamics::{CycleRecord, Method, Settings};

use crate::common::n80cb;
use crate::n80cb_assembly::n80cb_assembly;

fn both(tolerance: f64) -> (CycleRecord, Record) {
    let p = n80cb();
    let settings = Settings {
        relative_tolerance: tolerance,
        ..Settings::default()
    };
    let numerics = Numerics {
        method: Method::Bdf,
        relative_tolerance: tolerance,
        sample_interval: Some(settings.sample_interval),
    };
    let assembly = n80cb_assembly(&p, settings.end, settings.tail);
    (
        nailnoise_dynamics::simulate(&p, &settings).unwrap(),
        simulate(&assembly, &numerics).unwrap(),
    )
}

#[test]
fn events_and_peaks_equal_those_of_the_fixed_cycle() {
    let (fixed, network) = both(1e-9);
    assert!(network.is_certified(), "{:#?}", network.checks);
    for (i, time) in fixed.events.to_array().into_iter().enumerate() {
        let found = network.event(&format!("t{i}"));
        println!(
            "t{i}: {time:?} {found:?} {:e}",
            found.unwrap_or(0.0) - time.unwrap_or(0.0)
        );
    }
    println!("{:?}\n{:?}", fixed.work, network.work);
    println!("{} {}", fixed.len(), network.channels[0].values.len());
    for (i, time) in fixed.events.to_array().into_iter().enumerate() {
        let found = network.event(&format!("t{i}"));
        assert!(
            (found.unwrap() - time.unwrap()).abs() < 1e-6,
            "t{i}: {found:?} {time:?}"
        );
    }
    let s = &fixed.summary;
    for (name, expected) in [
        ("nail", s.peak_penetration_force),
        ("bumper", s.peak_bumper_force),
        ("stopper", s.peak_stopper_force),
        ("cap", s.peak_cap_force),
        ("seat", s.peak_seat_force),
        ("nose", s.peak_nose_force),
        ("support", s.peak_support_force),
    ] {
        let found = network.peak(name).unwrap();
        println!("{name} {found} {expected}");
        assert!((found / expected - 1.0).abs() < 1e-4, "{name}: {found} {expected}");
    }
}
