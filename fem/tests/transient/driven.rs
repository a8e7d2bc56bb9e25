//! Runs in lock step with what drives them.

#![allow(clippy::unwrap_used)]

mod transient_case;

use nailnoise_fem::transient::{Driven, Loads, Motion, Settings, SupportLaw, TransientError, respond};

fn settings(duration: f64) -> Settings {
    Settings {
        duration,
        ..Settings::default()
    }
}

#[test]
fn a_run_driven_by_known_loads_is_the_run_with_these_loads() {
    let case = transient_case::block_on_table(60, 80, SupportLaw::Unilateral);
    let settings = settings(0.03);
    let driven_until = 4000;
    let interval = case.loads.interval;
    let loads = Loads {
        history: case.loads.history.columns(0, driven_until + 1).into_owned(),
        ..case.loads.clone()
    };
    let expected = respond(&case.bodies, &case.supports, &loads, &settings).unwrap();
    let first = loads.history.column(0);
    let mut driven = Driven::new(
        &case.bodies,
        &case.supports,
        first.as_slice(),
        &loads.final_values,
        &settings,
    )
    .unwrap();
    assert_eq!(interval, settings.step);
    let mut worst: f64 = 0.0;
    for n in 1..=driven_until {
        let loads = loads.history.column(n);
        // What was tried before leaves no trace.
        let other: Vec<f64> = loads.iter().map(|f| 1.7 * f - 20.0).collect();
        driven.trial(&other).unwrap();
        driven.trial(loads.as_slice()).unwrap();
        let tried: Vec<f64> = driven.motion().iter().chain(driven.rate()).copied().collect();
        driven.accept(loads.as_slice()).unwrap();
        let accepted = driven.motion().iter().chain(driven.rate());
        let size = accepted.clone().fold(0.0f64, |m, x| m.max(x.abs()));
        for (a, b) in tried.iter().zip(accepted) {
            worst = worst.max((a - b).abs() / size);
        }
    }
    assert!(worst < 1e-9, "a trial is the step itself: {worst:e}");
    let found = driven.finish().unwrap();
    assert_eq!(found.samples(), expected.samples());
    let peak = expected.contact_forces.amax();
    // The same step by the same numbers; only the warm start of the contact's search differs.
    assert!((&found.contact_forces - &expected.contact_forces).amax() < 1e-6 * peak);
    let velocity = |r: &nailnoise_fem::transient::ModalResponse| r.modal(0, 0..60, Motion::Velocity).unwrap();
    let (a, b) = (velocity(&found), velocity(&expected));
    assert!((&a - &b).amax() < 1e-6 * b.amax());
    assert!(found.checks.iter().all(|check| check.ok), "{:?}", found.checks);
}

#[test]
fn a_driver_that_outlasts_the_run_is_told_so() {
    let case = transient_case::block_on_table(10, 10, SupportLaw::Unilateral);
    let settings = settings(4e-4);
    let first = case.loads.history.column(0);
    let mut driven = Driven::new(
        &case.bodies,
        &case.supports,
        first.as_slice(),
        &case.loads.final_values,
        &settings,
    )
    .unwrap();
    while !driven.is_over() {
        driven.accept(first.as_slice()).unwrap();
    }
    let more = driven.accept(first.as_slice());
    assert!(matches!(more, Err(TransientError::Value { .. })));
    assert_eq!(driven.finish().unwrap().samples(), 101);
}
