//! Designs side by side, through the command.

use std::sync::LazyLock;

use crate::common::{SMALL, folder, json, nailnoise, over};
use serde_json::Value;

fn close(a: &Value, b: f64) {
    assert!((a.as_f64().unwrap() - b).abs() < 1e-9, "{a} is not {b}");
}

/// The small design beside one with less supply pressure: the comparison, and the folder of the two runs.
static COMPARISON: LazyLock<(Value, String)> = LazyLock::new(|| {
    let folder = folder("compare");
    let out = folder.join("out").to_str().unwrap().to_owned();
    let quiet = over(&folder, "quiet", "supply.pressure = \"600 kPa\"");
    let comparison = json(&nailnoise(&["compare", SMALL, &quiet, "--json", "--out", &out]));
    (comparison, out)
});

/// The stored results of the two runs.
fn results() -> [String; 2] {
    let out = &COMPARISON.1;
    [format!("{out}/small"), format!("{out}/quiet/result.json")]
}

fn exhaust() -> &'static Value {
    let sources = COMPARISON.0["sources"].as_array().unwrap();
    sources.iter().find(|s| s["source"] == "exhaust").unwrap()
}

/// Exit status and output of a comparison with a limit between the levels of the two exhausts.
fn limited(before: &str, after: &str) -> (Option<i32>, String) {
    let level = |k: usize| exhaust()["level_db"][k].as_f64().unwrap();
    let limit = format!("exhaust={:.2}", 0.5 * (level(0) + level(1)));
    let output = nailnoise(&["compare", before, after, "--fail-above", &limit]);
    (output.status.code(), String::from_utf8(output.stdout).unwrap())
}

#[test]
fn a_comparison_names_its_designs() {
    assert_eq!(COMPARISON.0["designs"], serde_json::json!(["small", "quiet"]));
}

#[test]
fn a_comparison_lists_only_the_inputs_that_differ() {
    let inputs = COMPARISON.0["inputs"].as_array().unwrap();
    assert_eq!(inputs.len(), 1, "{inputs:#?}");
    assert_eq!(
        (&inputs[0]["key"], &inputs[0]["unit"]),
        (&"supply.pressure".into(), &"Pa".into())
    );
    assert_eq!(inputs[0]["values"], serde_json::json!([763_200.0, 600_000.0]));
}

#[test]
fn changes_are_differences_from_the_first_design() {
    let (changes, levels) = (&exhaust()["change_db"], &exhaust()["level_db"]);
    close(&changes[0], 0.0);
    close(&changes[1], levels[1].as_f64().unwrap() - levels[0].as_f64().unwrap());
}

#[test]
fn less_pressure_lowers_the_exhaust_noise() {
    let change = exhaust()["change_db"][1].as_f64().unwrap();
    assert!(change < -1.0, "{change} dB");
}

#[test]
fn stored_results_compare_like_their_runs() {
    let [first, second] = results();
    let again = json(&nailnoise(&["compare", &first, &second, "--json"]));
    assert!(COMPARISON.0 == again);
}

#[test]
fn a_proposal_below_the_limit_passes_and_one_above_it_fails() {
    let [loud, quiet] = results();
    assert_eq!(limited(&loud, &quiet).0, Some(0));
    assert_eq!(limited(&quiet, &loud).0, Some(1));
}

#[test]
fn the_table_shows_inputs_sources_and_events() {
    let [loud, quiet] = results();
    let text = limited(&loud, &quiet).1;
    for part in [
        "supply.pressure [Pa]",
        "exhaust",
        "ranking",
        "total",
        "speed before impact",
        "t7 [ms]",
    ] {
        assert!(text.contains(part), "no {part} in\n{text}");
    }
}

#[test]
fn a_file_that_is_not_a_result_is_refused() {
    let folder = folder("compare-refused");
    let other = folder.join("other.json");
    std::fs::write(&other, "{\"schema\": \"nailnoise-run/0\"}").unwrap();
    let cut = folder.join("cut.json");
    std::fs::write(&cut, "{\"schema\": \"nailno").unwrap();
    let empty = folder.join("empty");
    std::fs::create_dir(&empty).unwrap();
    for (path, part) in [
        (&other, "nailnoise-run/0"),
        (&cut, "no result"),
        (&empty, "cannot read"),
    ] {
        let output = nailnoise(&["compare", path.to_str().unwrap(), SMALL]);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.contains(part) && text.contains("help"), "{text}");
    }
}

#[test]
fn a_limit_for_an_unknown_source_is_refused() {
    let output = nailnoise(&["compare", SMALL, SMALL, "--fail-above", "muffler=3"]);
    assert_eq!(output.status.code(), Some(2));
}
