//! `nailnoise calibrate --structures`: elastic constants of plates from tap tests.

use std::fs;
use std::path::Path;
use std::process::Output;

use serde_json::Value;

use crate::common::{command, folder, messages};

/// The example: ten plates, each with the first six peaks of its tap test.
const PLATES: &str = include_str!("../../examples/plates/spruce.toml");

/// The first plate of the example, 1L.
fn one_plate() -> String {
    let second = PLATES.find("[plate.1R]").unwrap();
    PLATES[..second].to_owned()
}

fn calibrate(folder: &Path, text: &str) -> Output {
    fs::write(folder.join("plate.toml"), text).unwrap();
    command(&[
        "calibrate",
        "--structures",
        "plate.toml",
        "--draws",
        "64",
        "--moves",
        "3",
        "--out",
        "out",
    ])
    .current_dir(folder)
    .output()
    .unwrap()
}

#[test]
fn the_peaks_of_a_plate_narrow_its_moduli() {
    let folder = folder("structures/plate");
    let output = calibrate(&folder, &one_plate());
    // 3: so few draws need not have converged.
    assert!(matches!(output.status.code(), Some(0 | 3)), "{}", messages(&output));
    let text = fs::read_to_string(folder.join("out/structures/structures.json")).unwrap();
    let result: Value = serde_json::from_str(&text).unwrap();
    let inputs = result["plates"][0]["inputs"].as_array().unwrap();
    let width = |own: &Value, when: &str| own[when][2].as_f64().unwrap() - own[when][0].as_f64().unwrap();
    for name in ["e_l", "e_r", "g_lr"] {
        let own = inputs.iter().find(|own| own["name"] == name).unwrap();
        assert!(width(own, "now") < 0.5 * width(own, "before"), "{own}");
    }
    let modes = fs::read_to_string(folder.join("out/structures/modes.csv")).unwrap();
    assert!(modes.lines().count() > 10, "{modes}");
}

#[test]
fn a_peak_in_another_unit_is_refused_with_its_place() {
    let folder = folder("structures/unit");
    let output = calibrate(&folder, &one_plate().replace("\"47.0 Hz\"", "\"47 mm\""));
    assert_eq!(output.status.code(), Some(2));
    let message = messages(&output);
    assert!(
        message.contains("plate.toml:") && message.contains("peaks"),
        "{message}"
    );
}
