//! Measurement files as users write them, right and wrong.

#![allow(clippy::unwrap_used)]

use super::*;
use crate::calibration::level_quantities::LevelQuantity;

/// A file with one condition and this measurement.
fn file(measured: &str) -> String {
    format!(
        "schema = \"{SCHEMA}\"\n[instrument]\ncaliper = {{ error = \"1 % + 0.05 mm\" }}\n\
         gauge = {{ error = \"2 %\" }}\n\
         [condition]\na = {{ set = {{ \"supply.pressure\" = \"96 psig\" }}, \
         instrument = {{ \"supply.pressure\" = \"gauge\" }}, outcome = \"drives\" }}\n[measured]\n{measured}\n"
    )
}

fn read(text: &str) -> Result<Measurements, CalibrationError> {
    let design = Design::shipped("n80cb.toml").unwrap();
    let with = |own: &[Assignment]| Design::load_with(concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb.toml"), own);
    Reader {
        design: &design,
        assembly: None,
        with: &with,
    }
    .read(&Document::new(Path::new("shots.toml"), text))
}

fn one(measured: &str) -> Measured {
    read(&file(measured)).unwrap().data.remove(0)
}

#[test]
fn readings_have_si_units_and_errors_of_their_mean() {
    let own = one(
        "m = { condition = \"a\", quantity = \"head_depth\", value = \"2 mm\", shots = 4, scatter = \"1 mm\", \
         error = \"0.5 mm\", k = 2, instrument = \"caliper\", discrepancy = \"10 %\" }",
    );
    assert_eq!(own.reading, Reading::Value(2e-3));
    let expected = ((0.25e-3_f64.powi(2) + 1e-3_f64.powi(2)) / 4.0).sqrt();
    assert!((own.error / expected - 1.0).abs() < 1e-12);
    assert!((own.discrepancy - 2e-4).abs() < 1e-15);
    assert!((own.instrument.unwrap().deviation - 0.07e-3).abs() < 1e-15);
}

#[test]
fn repeats_mix_their_scatter_with_that_of_the_kind() {
    let own = one(
        "m = { condition = \"a\", quantity = \"head_depth\", values = [\"1 mm\", \"3 mm\", \"2 mm\"], \
         rounding = \"0.3 mm\" }",
    );
    assert_eq!(own.reading, Reading::Value(2e-3));
    let scatter = (4.0 * 1.5e-3_f64.powi(2) + 2e-6) / 6.0;
    let expected = ((scatter + 0.3e-3_f64.powi(2) / 3.0) / 3.0).sqrt();
    assert!((own.error / expected - 1.0).abs() < 1e-12, "{} {expected}", own.error);
}

#[test]
fn the_air_of_many_shots_is_read_once() {
    let own = one(
        "m = { condition = \"a\", quantity = \"air_per_shot\", value = \"24 l\", shots = 20, error = \"1 l\", \
         scatter = \"0 l\" }",
    );
    assert!(matches!(own.reading, Reading::Value(value) if (value / 1.2e-3 - 1.0).abs() < 1e-12));
    assert!((own.error / 5e-5 - 1.0).abs() < 1e-12);
}

#[test]
fn gauge_pressures_count_from_ambient_and_gauges_err_by_what_they_show() {
    let all = read(&file(
        "m = { condition = \"a\", quantity = \"peak_pressure\", of = \"supply\", value = \"90 psig\", \
         error = \"1 psi\" }",
    ))
    .unwrap();
    let psi = 6_894.757_293_168_361;
    let Reading::Value(value) = all.data[0].reading else {
        panic!("a value")
    };
    assert!((value - 90.0 * psi - 101_325.0).abs() < 2e3, "{value}");
    let shown = &all.conditions[0].shown[0];
    assert!((shown.deviation / (0.02 * 96.0 * psi) - 1.0).abs() < 1e-9);
}

#[test]
fn accelerations_and_levels_are_decibels() {
    let level = |measured: &str| read(&file(measured)).unwrap().levels.remove(0);
    let own = level(
        "m = { condition = \"a\", quantity = \"rms_acceleration\", sensor = \"block_top\", value = \"2 g\", \
         error = \"0.1 g\", k = 2, scatter = \"0 g\", discrepancy = \"10 %\" }",
    );
    assert!(matches!(own.reading, Reading::Value(x) if (x - 20.0 * (2.0 * 9.80665f64).log10()).abs() < 1e-9));
    assert!((own.error - 0.025 * 8.685_889_6).abs() < 1e-6, "{}", own.error);
    assert!((own.discrepancy - 0.868_588_96).abs() < 1e-6);
    let own = level(
        "m = { condition = \"a\", quantity = \"level\", source = \"exhaust\", of = \"microphone-3\", \
         values = [\"99 dB\", \"101 dB\"], error = \"0.7 dB\" }",
    );
    assert_eq!(own.reading, Reading::Value(100.0));
    let scatter = (4.0 * 0.25 + 2.0) / 5.0;
    assert!((own.error - ((0.49 + scatter) / 2.0_f64).sqrt()).abs() < 1e-9);
    assert_eq!(own.discrepancy, 1.0);
    let own = level("m = { condition = \"a\", quantity = \"level\", at_most = \"104 dB\", error = \"1 dB\" }");
    assert_eq!(own.reading, Reading::AtMost(104.0));
}

#[test]
fn efforts_are_minutes_by_quantity() {
    let depth = "m = { condition = \"a\", quantity = \"head_depth\", value = \"2 mm\", error = \"1 mm\" }";
    let with = |effort: &str| read(&file(&format!("{depth}\n[effort]\n{effort}")));
    let known = with("head_depth = 5\ndirect = 20").unwrap().effort;
    assert_eq!((known["head_depth"], known["direct"], known.len()), (5.0, 20.0, 2));
    let refused = |effort: &str| match with(effort).unwrap_err() {
        CalibrationError::Key(error) => format!("{error}; {}", error.help),
        other => other.to_string(),
    };
    let unknown = refused("head_dept = 5");
    assert!(
        unknown.contains("line 10") && unknown.contains("is it \"head_depth\"?"),
        "{unknown}"
    );
    assert!(refused("level = 0").contains("give minutes above 0"));
}

#[test]
fn censored_readings_are_bounds() {
    let of = |bounds: &str| {
        one(&format!(
            "m = {{ condition = \"a\", quantity = \"head_depth\", {bounds}, error = \"1 mm\" }}"
        ))
        .reading
    };
    assert_eq!(of("at_most = \"-10 mm\""), Reading::AtMost(-10e-3));
    assert_eq!(of("at_least = \"-10 mm\""), Reading::AtLeast(-10e-3));
    assert_eq!(
        of("at_least = \"-10 mm\", at_most = \"5 mm\""),
        Reading::Within([-10e-3, 5e-3])
    );
}

/// Problem and remedy for an invalid file.
fn fault(text: &str) -> String {
    match read(text).unwrap_err() {
        CalibrationError::Key(error) => format!("{error}; {}", error.help),
        other => other.to_string(),
    }
}

#[test]
fn every_fault_has_its_place_and_remedy() {
    let depth = "condition = \"a\", quantity = \"head_depth\", value = \"2 mm\"";
    for (measured, words) in [
        (format!("m = {{ {depth} }}"), &["line 8", "no instrument is exact"][..]),
        (
            format!("m = {{ {depth}, error = \"0 mm\" }}"),
            &["`measured.m.error` is 0", "rounding"],
        ),
        (format!("m = {{ {depth}, error = \"1 s\" }}"), &["a time", "a length"]),
        (
            format!("m = {{ {depth}, error = \"1 mm\", instrument = \"calliper\" }}"),
            &["is it \"caliper\"?"],
        ),
        (
            format!("m = {{ {depth}, error = \"1 mm\", values = [\"1 mm\"] }}"),
            &["several kinds"],
        ),
        (
            format!("m = {{ {depth}, error = \"1 mm\", events = [\"t1\", \"t2\"] }}"),
            &["does not belong"],
        ),
        (format!("m = {{ {depth}, eror = \"1 mm\" }}"), &["is it `error`?"]),
        (
            "m = { condition = \"b\", quantity = \"head_depth\", value = \"2 mm\" }".to_owned(),
            &["is not a known condition", "choose from a"],
        ),
        (
            "m = { condition = \"a\", quantity = \"head_dept\", value = \"2 mm\" }".to_owned(),
            &["is it \"head_depth\"?"],
        ),
        (
            "m = { condition = \"a\", quantity = \"interval\", events = [\"t6\", \"t19\"], value = \"4 ms\" }"
                .to_owned(),
            &["does not exist", "t0 to t18"],
        ),
        (
            format!("m = {{ {depth}, rounding = \"1 mm\", error = \"1 mm\" }}"),
            &["cannot be combined"],
        ),
        (
            format!("m = {{ {depth}, error = \"1 mm\", k = 0 }}"),
            &["is 0, outside 1 to 10"],
        ),
        (
            "m = { condition = \"a\", quantity = \"head_depth\", values = [], error = \"1 mm\" }".to_owned(),
            &["`measured.m.values` is empty"],
        ),
        (
            "m = { condition = \"a\", quantity = \"head_depth\", value = 0, error = \"2 %\", \
             scatter = \"0 mm\", discrepancy = \"5 %\" }"
                .to_owned(),
            &["is 0 at this value", "as an amount"],
        ),
        (
            "m = { condition = \"a\", quantity = \"interval\", events = [\"t6\", \"t9\"], \
             value = \"-4 ms\", error = \"1 ms\" }"
                .to_owned(),
            &["below 0", "correct the sign"],
        ),
        (
            "m = { condition = \"a\", quantity = \"pressure\", of = \"supply\", at = \"3 s\", \
             value = \"4 bar\", error = \"1 %\" }"
                .to_owned(),
            &["`measured.m.at` is 3 s", "analysis.cycle_end"],
        ),
        (
            "m = { condition = \"a\", quantity = \"head_depth\", at_most = \"1 mm\", at_least = \"2 mm\", \
             error = \"1 mm\" }"
                .to_owned(),
            &["is not below `at_most`"],
        ),
        (
            "m = { condition = \"a\", quantity = \"loss_factor\", value = \"100\" }".to_owned(),
            &["is a key of the design", "under [direct]"],
        ),
        (
            "m = { condition = \"a\", quantity = \"mode\", value = \"100 Hz\" }".to_owned(),
            &["this version cannot calibrate"],
        ),
        (
            "m = { condition = \"a\", quantity = \"level\", value = \"100\", error = 1, band = \"900 Hz\" }".to_owned(),
            &[
                "line 8",
                "`measured.m.band` is 900 Hz",
                "not a one-third octave within 50 to 10000 Hz",
                "choose from 63, 80,",
                "800, 1000,",
                "6300, 8000 Hz",
            ],
        ),
        (
            "m = { condition = \"a\", quantity = \"level\", value = \"100\", error = 1, band = \"10 kHz\" }".to_owned(),
            &["`measured.m.band` is 10000 Hz", "choose from 63,"],
        ),
        (
            "m = { condition = \"a\", quantity = \"rms_acceleration\", sensor = \"block_top\", value = \"9 g\", \
             error = \"5 %\", band = \"1 kHz\" }"
                .to_owned(),
            &["`measured.m.band`", "does not belong to `rms_acceleration`"],
        ),
        (
            "m = { condition = \"a\", file = \"nowhere.json\" }".to_owned(),
            &["line 8", "`measured.m.file`", "nowhere.json", "`nailnoise measure`"],
        ),
        (
            "m = { condition = \"a\", file = \"nowhere.json\", error = \"1 dB\" }".to_owned(),
            &["`measured.m.error`"],
        ),
        (
            "m = { condition = \"a\", quantity = \"level\", value = \"100 dB\" }".to_owned(),
            &["`measured.m.error`", "no instrument is exact"],
        ),
        (
            "m = { condition = \"a\", quantity = \"level\", value = \"100 dB\", error = \"1 %\" }".to_owned(),
            &["`measured.m.error`", "percentage of a level", "give it in dB"],
        ),
        (
            "m = { condition = \"a\", quantity = \"level\", source = \"exaust\", value = \"100 dB\", \
             error = \"1 dB\" }"
                .to_owned(),
            &[
                "line 8",
                "`measured.m.source`",
                "is it \"exhaust\"?",
                "workpiece, exhaust, body, total",
            ],
        ),
        (
            "m = { condition = \"a\", quantity = \"level\", of = \"microphone-10\", value = \"100 dB\", \
             error = \"1 dB\" }"
                .to_owned(),
            &[
                "line 8",
                "`measured.m.of`",
                "not a known position of a level",
                "microphone-9",
            ],
        ),
        (
            "m = { condition = \"a\", quantity = \"level\", value = \"9 g\", error = \"1 dB\" }".to_owned(),
            &["`measured.m.value`", "a level in dB"],
        ),
        (
            "m = { condition = \"a\", quantity = \"rms_acceleration\", sensor = \"block_to\", value = \"9 g\", \
             error = \"5 %\" }"
                .to_owned(),
            &["line 8", "`measured.m.sensor`", "is it \"block_top\"?", "table_centre"],
        ),
        (
            "m = { condition = \"a\", quantity = \"rms_acceleration\", sensor = \"block_top\", value = \"0 g\", \
             error = \"5 %\" }"
                .to_owned(),
            &["`measured.m.value`", "not above 0"],
        ),
        (
            "m = { condition = \"a\", quantity = \"peak_acceleration\", sensor = \"block_top\", of = \"ear\", \
             value = \"9 g\", error = \"5 %\" }"
                .to_owned(),
            &["`measured.m.of`", "does not belong to `peak_acceleration`"],
        ),
        (
            "m = { condition = \"a\", quantity = \"mode\", body = \"block\", hz = [100] }".to_owned(),
            &["`measured.m.body`", "this version cannot calibrate"],
        ),
    ] {
        let got = fault(&file(&measured));
        assert!(words.iter().all(|word| got.contains(word)), "{measured}\n{got}");
    }
}

#[test]
fn faults_outside_the_measurements_are_named_too() {
    let good = file("m = { condition = \"a\", quantity = \"head_depth\", value = \"2 mm\", error = \"1 mm\" }");
    for (from, to, words) in [
        ("schema = \"nailnoise-calibration/1\"", "", "`schema` is missing"),
        ("outcome = \"drives\"", "outcome = \"drive\"", "is it \"drives\"?"),
        (
            "\"supply.pressure\" = \"96 psig\"",
            "\"supply.presure\" = \"96 psig\"",
            "supply.pressure",
        ),
        (
            "\"supply.pressure\" = \"gauge\"",
            "\"supply.pressure\" = \"caliper\"",
            "a length",
        ),
        (
            "[instrument]",
            "[direct]\n\"piston.mas\" = { value = \"1 g\", error = \"1 g\" }\n[instrument]",
            "`piston.mass`",
        ),
        (
            "[instrument]",
            "[direct]\n\"supply.pressure\" = { value = \"96 psig\", error = \"1 kPa\" }\n[instrument]",
            "measured in [direct]",
        ),
        (
            "[instrument]",
            "correlation = [{ ids = [\"m\", \"n\"], r = 0.3 }]\n[instrument]",
            "is not a known measurement",
        ),
        (
            "[instrument]",
            "correlation = [{ ids = [\"m\", \"m\"], r = 0.3 }]\n[instrument]",
            "names a measurement twice",
        ),
        (
            "[instrument]",
            "correlation = [{ ids = [\"m\"], r = 0.3, rho = 1 }]\n[instrument]",
            "unknown key `rho`",
        ),
        (
            "[instrument]",
            "[direct]\npiston.mass = { value = \"131 g\", error = \"1 g\" }\n[instrument]",
            "\"piston.mass\" = { .. }",
        ),
        (
            "[instrument]",
            "[direct]\n\"wood.species\" = { value = \"pine\", error = \"1 g\" }\n[instrument]",
            "is not a quantity; set it in the design",
        ),
        (
            "caliper = { error = \"1 % + 0.05 mm\" }",
            "caliper = { error = \"0.0 mm\" }",
            "no instrument is exact",
        ),
        (
            "set = { \"supply.pressure\" = \"96 psig\" }",
            "set = { supply.pressure = \"96 psig\" }",
            "write the whole key in quotes",
        ),
    ] {
        assert!(good.contains(from), "{from}");
        let got = fault(&good.replacen(from, to, 1));
        assert!(got.contains(words), "{to}\n{got}");
    }
    assert!(fault(&file("")).contains("`nailnoise study` is enough"));
}
#[test]
fn third_octaves_have_twice_the_error_of_a_level() {
    let measured = "m = { condition = \"a\", quantity = \"level\", source = \"exhaust\", of = \"ear\", \
        band = \"1 kHz\", value = \"92 dB\", error = \"0.7 dB\", scatter = \"0 dB\" }";
    let own = read(&file(measured)).unwrap().levels.remove(0);
    assert!(matches!(own.quantity, LevelQuantity::Sound { band: Some(hz), .. } if hz == 1000.0));
    assert_eq!(
        (own.reading, own.error, own.discrepancy),
        (Reading::Value(92.0), 0.7, 2.0)
    );
}

/// A wrapping test on the worktable as `nailnoise measure` writes it.
fn test_result(range_high: f64) -> serde_json::Value {
    let level = |db: f64| {
        let mut own = serde_json::json!({"db": db, "repeats": 5, "standard_db": 0.2, "half_width_db": 0.5});
        own["expanded_db"] = 3.03.into();
        own
    };
    let bands = |db: f64| serde_json::json!([{"hz": 500.0, "lwa_db": db - 3.0}, {"hz": 1000.0, "lwa_db": db - 6.0}]);
    let source = |name: &str, db: f64, floor: f64| {
        serde_json::json!({"source": name, "configuration": "W", "level": level(db), "by_energy_db": db,
            "floor_db": floor, "zeroed_share": 0.0, "before_trigger_share": 0.0, "bands": [],
            "bands_by_energy": bands(db), "negative_bands": 0, "intervals": []})
    };
    serde_json::json!({
        "schema": "nailnoise-measurement/1", "manifest": "m.toml", "setup": "worktable", "area_m2": 13.4, "k2_db": 0.0,
        "range_hz": [50.0, range_high], "notes": [], "closure_db": 1.0,
        "processing": {"reading": "margin", "paired": false, "total_less_residual": false},
        "configurations": [{"configuration": "total", "name": "W-1", "level": level(105.0), "above_residual_db": 10.0,
            "bands": bands(105.0), "intervals": [], "accelerations": [], "markers": [], "delays_s": []}],
        "sources": [source("exhaust", 99.0, 94.0), source("body", 95.0, 93.0), source("workpiece", 101.0, 92.0)],
        "bound": {"level": level(103.0), "by_energy_db": 103.0, "bands": bands(103.0), "negative_bands": 0},
    })
}

/// The levels that a table reads from a test, and the problem if it is refused.
fn of_test(name: &str, result: &serde_json::Value, keys: &str) -> Result<Measurements, String> {
    let path = std::env::temp_dir().join(format!("nailnoise-levels-{}-{name}.json", std::process::id()));
    std::fs::write(&path, result.to_string()).unwrap();
    let text = file(&format!(
        "t = {{ condition = \"a\", file = '{}'{keys} }}",
        path.display()
    ));
    let found = read(&text).map_err(|error| match error {
        CalibrationError::Key(error) => format!("{error}; {}", error.help),
        other => other.to_string(),
    });
    std::fs::remove_file(&path).unwrap();
    found
}

#[test]
fn levels_of_a_wrapping_test_have_its_expanded_uncertainty() {
    let found = of_test("all", &test_result(10_000.0), "").unwrap();
    let readings: Vec<(&str, Reading)> = found
        .levels
        .iter()
        .map(|own| (own.name.as_str(), own.reading))
        .collect();
    // The body is less than 3 dB above a silent source, and the workpiece lies between its own reading and the bound.
    let expected = [
        ("t-total", Reading::Value(105.0)),
        ("t-workpiece", Reading::Within([101.0, 103.0])),
        ("t-exhaust", Reading::Value(99.0)),
        ("t-body", Reading::AtMost(95.0)),
    ];
    assert_eq!(readings, expected);
    for own in &found.levels {
        let instrument = own.instrument.unwrap();
        // The instruments of the file come first.
        assert_eq!((instrument.instrument, found.instruments.len()), (2, 3));
        let expanded = 2.0 * own.error.hypot(instrument.deviation);
        assert!((expanded - 2.0 * 1.5_f64.hypot(0.2)).abs() < 1e-12, "{expanded}");
        assert!((instrument.deviation - 1.5 / 2.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!(own.discrepancy, 1.0);
    }
    let one = of_test(
        "one",
        &test_result(10_000.0),
        ", source = \"exhaust\", discrepancy = \"1.5 dB\"",
    )
    .unwrap();
    assert_eq!((one.levels.len(), one.levels[0].discrepancy), (1, 1.5));
}

#[test]
fn bands_of_a_wrapping_test_are_read_by_name() {
    // The range of the test need not match; the bands only have to be within both ranges.
    let keys = ", source = \"exhaust\", band = [\"500 Hz\", \"1 kHz\"]";
    let found = of_test("bands", &test_result(2_000.0), keys).unwrap().levels;
    let readings: Vec<(&str, Reading)> = found.iter().map(|own| (own.name.as_str(), own.reading)).collect();
    assert_eq!(
        readings,
        [
            ("t-exhaust-500", Reading::Value(96.0)),
            ("t-exhaust-1000", Reading::Value(93.0))
        ]
    );
    assert!(found.iter().all(|own| own.discrepancy == 2.0));
    let refused = of_test("beyond", &test_result(2_000.0), ", band = \"4 kHz\"").unwrap_err();
    assert!(
        refused.contains("`measured.t.band` is 4000 Hz") && refused.contains("choose from 63,"),
        "{refused}"
    );
    let absent = of_test(
        "absent",
        &test_result(2_000.0),
        ", source = \"body\", band = \"800 Hz\"",
    )
    .unwrap_err();
    assert!(
        absent.contains("`measured.t.source` has no level in this test"),
        "{absent}"
    );
}

#[test]
fn a_test_that_the_design_does_not_predict_is_refused() {
    let range = of_test("range", &test_result(8_000.0), "").unwrap_err();
    assert!(
        range.contains("50 to 8000 Hz") && range.contains("\"analysis.range_high\" = \"8000 Hz\""),
        "{range}"
    );
    let mut sand = test_result(10_000.0);
    sand["setup"] = "sandbox".into();
    let setup = of_test("setup", &sand, "").unwrap_err();
    assert!(
        setup.contains("line 8") && setup.contains("`sandbox`") && setup.contains("support"),
        "{setup}"
    );
    let mut other = test_result(10_000.0);
    other["schema"] = "nailnoise-measured/1".into();
    assert!(
        of_test("layout", &other, "")
            .unwrap_err()
            .contains("nailnoise-measured/1")
    );
    let twice = of_test(
        "twice",
        &test_result(10_000.0),
        " }\nt-body = { condition = \"a\", quantity = \"level\", value = 9, \
        error = 1",
    )
    .unwrap_err();
    assert!(
        twice.contains("`measured.t-body`") && twice.contains("name of a reading from a file"),
        "{twice}"
    );
}
