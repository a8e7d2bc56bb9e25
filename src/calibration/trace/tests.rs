//! Recorded histories as readings, right and wrong.

#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::super::measurements::Measurements;
use super::super::reader::{Reader, SCHEMA};
use super::*;
use crate::design::{Assignment, Design};

/// Reads this history with these further keys of its measurement.
fn read(csv: &str, keys: &str) -> Result<Measurements, String> {
    static FILES: AtomicUsize = AtomicUsize::new(0);
    let number = FILES.fetch_add(1, Ordering::Relaxed);
    let file = std::env::temp_dir().join(format!("nailnoise-trace-{}-{number}.csv", std::process::id()));
    std::fs::write(&file, csv).unwrap();
    let text = format!(
        "schema = \"{SCHEMA}\"\n[condition]\na = {{}}\n[measured]\np = {{ condition = \"a\", quantity = \
         \"pressure\", of = \"above_piston\", file = '{}', error = \"1 %\", {keys} }}\n",
        file.display()
    );
    let design = Design::shipped("n80cb.toml").unwrap();
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb.toml");
    let with = |own: &[Assignment]| Design::load_with(path, own);
    let reader = Reader {
        design: &design,
        assembly: None,
        with: &with,
    };
    let found = reader.read(&Document::new(Path::new("shots.toml"), &text));
    std::fs::remove_file(&file).unwrap();
    found.map_err(|error| error.to_string())
}

const HISTORY: &str = "time [ms];p1 [kPa];p2 [barg]\n-4;100;0\n0;500;4\n4;300;2\n";

#[test]
fn points_of_a_history_are_readings_around_their_event() {
    let keys = "column = \"p1\", align = \"t9\", points = 3, from = \"-2 ms\", to = \"2 ms\"";
    let found = read(HISTORY, keys).unwrap().data;
    let values: Vec<f64> = found.iter().map(|own| own.reading.nearest(0.0)).collect();
    assert_eq!(values, [3e5, 5e5, 4e5]);
    let names: Vec<&str> = found.iter().map(|own| own.name.as_str()).collect();
    assert_eq!(names, ["p-1", "p-2", "p-3"]);
}

/// The mean of the points is not known better than one reading.
#[test]
fn more_points_do_not_average_out_the_error_of_the_model() {
    let keys = |points: usize| {
        format!(
            "column = \"p2 [barg]\", align = \"t9\", points = {points}, discrepancy = \"4 kPa\", scatter = \"3 kPa\""
        )
    };
    let independent = |points: usize| {
        let own = read(HISTORY, &keys(points)).unwrap().data.remove(0);
        // Half of the variance of the model error is shared.
        own.error.powi(2) + 0.5 * own.discrepancy.powi(2) - (0.01 * own.reading.nearest(0.0)).powi(2)
    };
    let [one, ten] = [1, 10].map(independent);
    assert!((one / (9e6 + 8e6) - 1.0).abs() < 1e-9, "{one}");
    assert!((ten / (10.0 * one) - 1.0).abs() < 1e-9, "{ten}");
}

#[test]
fn a_wrong_history_is_refused_at_its_key() {
    for (csv, keys, expected) in [
        (HISTORY, "points = 3", "`measured.p.column` is missing"),
        (HISTORY, "column = \"p3\"", "`measured.p.column` is \"p3\""),
        (
            HISTORY,
            "column = \"p1\", align = \"t19\"",
            "`measured.p.align` names an event",
        ),
        (
            HISTORY,
            "column = \"p1\", from = \"9 ms\"",
            "`measured.p.from` is 0.009 s, outside",
        ),
        (
            HISTORY,
            "column = \"p1\"",
            "`measured.p.from` is -0.004 s, before the trigger pull",
        ),
        (HISTORY, "column = \"p1\", value = \"1 kPa\"", "`measured.p"),
        ("t [s];p [mm]\n0;1\n1;2\n", "points = 2", "the column \"p [mm]\""),
        ("t [s];p\n0;1\n1;2\n", "points = 2", "it has no unit"),
        (
            "t [s];p [Pa]\n0;1\n0;2\n",
            "points = 2",
            "line 3: the time does not increase",
        ),
    ] {
        let problem = read(csv, keys).map(|_| ()).unwrap_err();
        assert!(problem.contains(expected), "{problem}\n{expected}");
    }
}

fn condition() -> Condition {
    Condition {
        name: "a".to_owned(),
        design: Design::shipped("n80cb.toml").unwrap(),
        set: Vec::new(),
        shown: Vec::new(),
        outcomes: Vec::new(),
    }
}

#[test]
fn a_gauge_pressure_is_relative_to_the_ambient_pressure() {
    let (condition, pressure) = (condition(), Quantity::SupplyDrop);
    let of = |heading: &str| unit(&Heading::of(heading), &pressure, &condition).unwrap();
    assert_eq!(of("p [kPa]"), [1e3, 0.0]);
    let [factor, zero] = of("p [barg]");
    assert!((factor - 1e5).abs() < 1e-6 && (zero - condition.design.ambient.pressure).abs() < 1e-6);
    assert!(unit(&Heading::of("p"), &pressure, &condition).is_err());
    assert!(unit(&Heading::of("p [mm]"), &pressure, &condition).is_err());
}

#[test]
fn a_history_is_linear_between_its_samples() {
    let history = History {
        times: vec![0.0, 1.0, 3.0],
        values: vec![2.0, 4.0, 0.0],
    };
    let values = [0.0, 0.5, 1.0, 2.0, 3.0].map(|time| history.at(time));
    assert_eq!(values, [2.0, 3.0, 4.0, 2.0, 0.0]);
}
