//! Counts of the integrator for the base design: a loss of efficiency fails the test.

use nailnoise_dynamics::{Method, Parameters, Settings, simulate};

use crate::BASE;
use crate::common::n80cb;

/// Part by which a count may differ: another mathematical library moves a few steps by its last digit.
const ROUNDING: f64 = 0.01;

#[test]
fn the_integrator_needs_as_many_steps_as_before() {
    let work = BASE.record.work;
    let frozen = [
        ("steps", work.steps, 3302),
        ("rejected", work.rejected, 605),
        ("Newton iterations", work.newton_iterations, 5550),
        ("factorisations", work.factorisations, 883),
    ];
    for (name, count, expected) in frozen {
        let part = (count as f64 / f64::from(expected) - 1.0).abs();
        assert!(
            part <= ROUNDING,
            "{name}: {count}, frozen at {expected}; state the cause and freeze anew"
        );
    }
    // Some of the Jacobians only serve for their spectral radius.
    assert!(work.newton_failures <= 30 && work.jacobians <= 190, "{work:?}");
    assert_eq!(work.events, 52);
}

#[test]
fn an_explicit_pair_takes_fewer_steps_where_the_equations_are_not_stiff() {
    let settings = Settings {
        method: Method::Bdf,
        ..Settings::default()
    };
    let implicit = simulate(&n80cb(), &settings).unwrap().record.work;
    assert!(BASE.record.work.steps < 3 * implicit.steps / 4, "{implicit:?}");
    assert!(
        BASE.record.work.factorisations < 2 * implicit.factorisations / 3,
        "{implicit:?}"
    );
}

#[test]
fn a_record_serialises_with_its_events_and_histories() {
    let settings = Settings {
        end: 1e-3,
        ..Settings::default()
    };
    let record = simulate(&n80cb(), &settings).unwrap();
    let json = serde_json::to_value(&record).unwrap();
    let figures = &json["figures"];
    assert_eq!(figures["outcome"], "does_not_open");
    assert_eq!(figures["events"]["t0"], 0.0);
    assert_eq!(figures["events"]["t18"], serde_json::Value::Null);
    let channels = json["record"]["channels"].as_array().unwrap();
    let position = channels.iter().find(|own| own["name"] == "piston.position").unwrap();
    assert_eq!(position["values"].as_array().unwrap().len(), record.len());
}

#[test]
fn parameters_are_read_back_from_json() {
    let parameters: Parameters = serde_json::from_value(serde_json::to_value(n80cb()).unwrap()).unwrap();
    assert_eq!(parameters, n80cb());
}
