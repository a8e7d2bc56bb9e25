//! Runs that advance step by step with the source of their loads.

use std::sync::LazyLock;

use nailnoise_fem::vibration::{Driven, Loads, ModalResponse, Motion, Settings, SupportLaw, TransientError, respond};

use crate::block_on_table::block_on_table;

fn settings(duration: f64) -> Settings {
    Settings {
        duration,
        ..Settings::default()
    }
}

/// A run with known loads, once in one call and once step by step.
struct Comparison {
    expected: ModalResponse,
    found: ModalResponse,
    /// Largest relative difference between the motion of a trial and that of the accepted step.
    trial_error: f64,
}

static COMPARISON: LazyLock<Comparison> = LazyLock::new(|| {
    let case = block_on_table(60, 80, SupportLaw::Unilateral);
    let settings = settings(0.03);
    let driven_until = 4000;
    assert_eq!(case.loads.interval, settings.step);
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
    let mut trial_error: f64 = 0.0;
    for n in 1..=driven_until {
        let loads = loads.history.column(n);
        // A trial with other loads must not change the next one.
        let other: Vec<f64> = loads.iter().map(|f| 1.7 * f - 20.0).collect();
        driven.trial(&other).unwrap();
        driven.trial(loads.as_slice()).unwrap();
        let tried: Vec<f64> = driven.motion().iter().chain(driven.rate()).copied().collect();
        driven.accept(loads.as_slice()).unwrap();
        let accepted = driven.motion().iter().chain(driven.rate());
        let size = accepted.clone().fold(0.0f64, |m, x| m.max(x.abs()));
        for (a, b) in tried.iter().zip(accepted) {
            trial_error = trial_error.max((a - b).abs() / size);
        }
    }
    Comparison {
        expected,
        found: driven.finish().unwrap(),
        trial_error,
    }
});

#[test]
fn a_trial_has_the_motion_of_the_accepted_step() {
    let error = COMPARISON.trial_error;
    assert!(error < 1e-9, "{error:e}");
}

#[test]
fn a_run_driven_by_known_loads_equals_the_run_with_these_loads() {
    let Comparison { expected, found, .. } = &*COMPARISON;
    assert_eq!(found.samples(), expected.samples());
    let peak = expected.contact_forces.amax();
    // The steps are the same; only the initial guess of the contact search differs.
    assert!((&found.contact_forces - &expected.contact_forces).amax() < 1e-6 * peak);
    let velocity = |r: &ModalResponse| r.modal(0, 0..60, Motion::Velocity).unwrap();
    let (a, b) = (velocity(found), velocity(expected));
    assert!((&a - &b).amax() < 1e-6 * b.amax());
    crate::passes_its_checks(found);
}

#[test]
fn a_step_after_the_end_of_the_run_is_refused() {
    let case = block_on_table(10, 10, SupportLaw::Unilateral);
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
