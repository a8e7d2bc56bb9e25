//! Counts of the integrator for the base design: a loss of efficiency fails the test.

use nailnoise_dynamics::{Parameters, Settings, simulate};

use crate::BASE;
use crate::common::n80cb;

/// Part by which a count may differ: another mathematical library moves a few steps by its last digit.
const ROUNDING: f64 = 0.01;

#[test]
fn the_integrator_needs_as_many_steps_as_before() {
    let work = BASE.work;
    let frozen = [
        ("steps", work.steps, 4678),
        ("rejected", work.rejected, 650),
        ("Newton iterations", work.newton_iterations, 8608),
        ("factorisations", work.factorisations, 1557),
    ];
    for (name, count, expected) in frozen {
        let part = (count as f64 / f64::from(expected) - 1.0).abs();
        assert!(
            part <= ROUNDING,
            "{name}: {count}, frozen at {expected}; state the cause and freeze anew"
        );
    }
    assert!(work.newton_failures <= 30 && work.jacobians <= 150, "{work:?}");
    assert_eq!(work.events, 52);
}

#[test]
fn a_record_serialises_with_its_events_and_histories() {
    let settings = Settings {
        end: 1e-3,
        ..Settings::default()
    };
    let record = simulate(&n80cb(), &settings).unwrap();
    let json = serde_json::to_value(&record).unwrap();
    assert_eq!(json["outcome"], "does_not_open");
    assert_eq!(json["events"]["t0"], 0.0);
    assert_eq!(json["events"]["t18"], serde_json::Value::Null);
    assert_eq!(json["piston"]["position"].as_array().unwrap().len(), record.len());
}

#[test]
fn parameters_are_read_back_from_json() {
    let parameters: Parameters = serde_json::from_value(serde_json::to_value(n80cb()).unwrap()).unwrap();
    assert_eq!(parameters, n80cb());
}
