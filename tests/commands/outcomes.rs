//! Shots that do not drive their nail: every output states it before the levels, with the figure and the inputs that
//! change it.

use std::fs;

use serde_json::Value;

use crate::common::{SMALL, folder, json, nailnoise, over};

/// Keys that make the small design miss, with the outcome.
const MISSED: [(&str, &str, &str); 4] = [
    ("low", "underdriven", "supply.pressure = \"500 kPa\""),
    (
        "heavy",
        "does_not_release",
        "contacts.guard_travel = \"30 mm\"\nhand.force = \"300 N\"",
    ),
    (
        "short",
        "strikes_bumper",
        "piston.rod_protrusion = \"1 mm\"\nnail.overdrive_limit = \"50 mm\"",
    ),
    ("shut", "does_not_open", "trigger.vent_area = \"0.002 mm2\""),
];

/// Output and status of a run of the small design with other keys.
fn run(name: &str, keys: &str, json: bool) -> (String, Option<i32>) {
    let folder = folder(&format!("outcome-{name}-{json}"));
    let design = over(&folder, name, keys);
    let out = folder.join("out");
    let mut arguments = vec!["run", &design, "--out", out.to_str().unwrap()];
    arguments.extend(json.then_some("--json"));
    let output = nailnoise(&arguments);
    let page = fs::read_to_string(out.join("report.html")).unwrap_or_default();
    let text = String::from_utf8(output.stdout).unwrap();
    (
        if json { text } else { format!("{text}\u{0}{page}") },
        output.status.code(),
    )
}

fn result(name: &str, keys: &str) -> Value {
    serde_json::from_str(&run(name, keys, true).0).unwrap()
}

#[test]
fn a_shot_that_drives_has_no_headline() {
    let result = result("drives", "");
    assert_eq!(result["outcome"], "drives");
    assert!(result["headline"].is_null(), "{}", result["headline"]);
}

#[test]
fn every_miss_has_its_headline() {
    for (name, outcome, keys) in MISSED {
        let result = result(name, keys);
        let headline = &result["headline"];
        assert_eq!(
            [&result["outcome"], &headline["outcome"]],
            [outcome, outcome],
            "{name}: {headline}"
        );
        assert!(
            headline["figure"]["value"].as_f64().unwrap() > 0.0,
            "{name}: {headline}"
        );
        assert_eq!(headline["text"], result["notes"][0], "{name}");
        assert_eq!(headline["exhaust_opens"], !result["events"]["t13"].is_null(), "{name}");
    }
}

#[test]
fn the_figure_of_an_underdriven_nail_is_the_length_that_protrudes() {
    let (name, _, keys) = MISSED[0];
    let result = result("figure", keys);
    let depth = result["cycle"]["head_depth"].as_f64().unwrap();
    let headline = &result["headline"];
    assert!(
        (headline["figure"]["value"].as_f64().unwrap() + depth).abs() < 1e-12,
        "{name}"
    );
    let text = headline["text"].as_str().unwrap();
    assert!(
        text.contains(&format!("{:.1} mm of the nail protrude", -1e3 * depth)),
        "{text}"
    );
}

/// Each named input has the stated effect: the cycle is computed anew with the value that is shown.
#[test]
fn the_named_inputs_change_the_shot_as_stated() {
    let (_, _, keys) = MISSED[0];
    let headline = &result("inputs", keys)["headline"];
    let inputs = headline["inputs"].as_array().unwrap();
    assert!((1..=3).contains(&inputs.len()), "{headline}");
    let folder = folder("outcome-inputs-cycle");
    let design = over(&folder, "low", keys);
    let here = headline["figure"]["value"].as_f64().unwrap();
    for input in inputs {
        let [key, to] = ["key", "to"].map(|name| input[name].as_str().unwrap());
        // An overdriven shot fails a check, so that the status is not checked here.
        let output = nailnoise(&["cycle", &design, "--json", "--set", &format!("{key}={to}")]);
        let other: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(other["outcome"], input["outcome"], "{input}");
        let protrusion = -other["summary"]["head_depth"].as_f64().unwrap();
        let stated = input["figure"].as_f64().unwrap();
        // The value is shown to six digits.
        assert!((protrusion - stated).abs() < 1e-5, "{input}: {protrusion}");
        assert!(protrusion < here, "{input}: {here}");
    }
}

#[test]
fn the_terminal_begins_and_ends_with_the_miss_and_the_page_shows_it_before_the_levels() {
    let (_, _, keys) = MISSED[1];
    let (text, status) = run("terminal", keys, false);
    let (text, page) = text.split_once('\u{0}').unwrap();
    // The shot is none that the draws of a study count.
    assert_eq!(status, Some(1));
    assert!(
        text.starts_with("the exhaust does not open: the tool rises by "),
        "{text}"
    );
    assert!(text.contains("that of the trigger vent"), "{text}");
    assert!(
        !text
            .lines()
            .any(|line| line.contains("all ") && line.contains("checks ok")),
        "{text}"
    );
    let end = text.find("numerical checks ok").unwrap();
    assert!(
        text[..end]
            .trim_end()
            .lines()
            .rev()
            .nth(2)
            .unwrap()
            .contains("does not open"),
        "{text}"
    );
    // Output that is not a terminal is without colour.
    assert!(!text.contains('\u{1b}'), "{text}");
    let (miss, level) = (
        page.find("class=\"missed\"").unwrap(),
        page.find("class=\"total\"").unwrap(),
    );
    assert!(miss < level, "{miss} {level}");
    assert!(
        page[miss..level].contains("The exhaust does not open"),
        "{}",
        &page[miss..level]
    );
}

#[test]
fn an_operator_who_lets_go_opens_the_exhaust_of_a_tool_that_hardly_recoils() {
    let (_, _, keys) = MISSED[1];
    let never = result("never", keys);
    let released = result("released", &format!("{keys}\ntrigger.release_after = \"40 ms\""));
    assert_eq!(released["outcome"], "drives");
    assert!((released["events"]["t12"].as_f64().unwrap() - 0.04).abs() < 1e-12);
    let exhaust = |result: &Value| {
        let sources = result["ranking"].as_array().unwrap();
        let own = sources.iter().find(|own| own["source"] == "exhaust").unwrap();
        own["lwa_db"].as_f64().unwrap()
    };
    // The blow-down carries some hundred times the air of the vent.
    assert!(
        exhaust(&released) > exhaust(&never) + 5.0,
        "{} {}",
        exhaust(&released),
        exhaust(&never)
    );
}

#[test]
fn a_comparison_of_unlike_shots_begins_with_a_warning() {
    let folder = folder("outcome-compare");
    let out = folder.join("out").to_str().unwrap().to_owned();
    let low = over(&folder, "low", MISSED[0].2);
    let output = nailnoise(&["compare", SMALL, &low, "--out", &out]);
    let text = String::from_utf8(output.stdout).unwrap();
    let first = text.lines().next().unwrap();
    assert!(
        first.starts_with("the shots do not end alike (small drives, low is underdriven"),
        "{first}"
    );
    let page = fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().path());
    let pages: Vec<String> = page
        .filter(|path| path.extension().is_some_and(|end| end == "html"))
        .map(|path| fs::read_to_string(path).unwrap())
        .collect();
    assert!(pages.iter().any(|page| page.contains("The shots do not end alike")));
    let compared = json(&nailnoise(&["compare", SMALL, &low, "--out", &out, "--json"]));
    assert_eq!(compared["headlines"][0], Value::Null);
    assert_eq!(compared["headlines"][1]["outcome"], "underdriven");
    // Alike shots have no warning.
    let same = json(&nailnoise(&["compare", SMALL, SMALL, "--out", &out, "--json"]));
    assert_eq!(same["unlike"], Value::Null);
}

#[test]
fn a_sweep_across_outcomes_begins_with_a_warning() {
    let out = folder("outcome-sweep").to_str().unwrap().to_owned();
    let vary = "supply.pressure=500kPa,763.2kPa";
    let output = nailnoise(&["sweep", SMALL, "--vary", vary, "--out", &out]);
    let text = String::from_utf8(output.stdout).unwrap();
    let first = text.lines().next().unwrap();
    assert!(
        first.starts_with("the shots do not end alike (500kPa is underdriven"),
        "{first}"
    );
    assert!(text.contains("mm of the nail protrude"), "{text}");
}

#[test]
fn a_test_of_a_design_that_does_not_drive_says_so_first() {
    let folder = folder("outcome-test");
    let low = over(&folder, "low", MISSED[0].2);
    let output = nailnoise(&["test", &low, "--energies"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.starts_with("the nail is not driven to its length: "), "{text}");
}

/// The sections of `check`, in their order.
const SECTIONS: [&str; 7] = [
    "can it run: ",
    "does it drive: ",
    "what is missing: ",
    "values outside plausible ranges: ",
    "inputs by their effect: ",
    "what to measure first",
    "cost of each stage",
];

#[test]
fn a_check_says_first_whether_the_design_runs_and_drives() {
    let folder = folder("outcome-check");
    let design = over(&folder, "odd", &format!("{}\npiston.mass = \"700 g\"", MISSED[0].2));
    let output = nailnoise(&["check", &design]);
    let text = String::from_utf8(output.stdout).unwrap();
    let places = SECTIONS.map(|section| text.find(section).unwrap_or_else(|| panic!("no {section} in\n{text}")));
    assert!(places.is_sorted(), "{places:?}\n{text}");
    assert!(text.contains("piston.mass") && text.contains("kg or g?"), "{text}");
    // The table replaces the warnings.
    let messages = String::from_utf8(output.stderr).unwrap();
    assert!(!messages.contains("outside its range"), "{messages}");
}

#[test]
fn a_check_leaves_out_what_the_design_does_not_use() {
    let folder = folder("outcome-unused");
    let keys = |design: &str| {
        let told = json(&nailnoise(&["check", design, "--json"]));
        let of = |list: &str| -> Vec<String> {
            let own = told[list].as_array().unwrap().iter();
            own.map(|own| own["key"].as_str().unwrap().to_owned()).collect()
        };
        assert!(of("measure_first").iter().all(|key| {
            let effects = told["effects"]["inputs"].as_array().unwrap();
            effects.iter().any(|own| own["key"] == **key)
        }));
        of("estimates")
    };
    let has = |keys: &[String], key: &str| keys.iter().any(|own| own == key);
    let table = keys(SMALL);
    assert!(
        has(&table, "piston.bore") && !has(&table, "exhaust.muffler.tail_length"),
        "{table:?}"
    );
    assert!(!has(&table, "support.sand.shear_modulus"), "{table:?}");
    let sand = keys(&over(
        &folder,
        "sand",
        "support.kind = \"sandbox\"\nexhaust.muffler.kind = \"chamber\"\nanalysis.exhaust_max_frequency = \"6.5 kHz\"",
    ));
    assert!(
        has(&sand, "exhaust.muffler.tail_length") && has(&sand, "support.sand.shear_modulus"),
        "{sand:?}"
    );
}

#[test]
fn bands_without_the_exhaust_are_named_by_check_and_run() {
    let folder = folder("outcome-exhaust-top");
    let design = over(&folder, "low", "analysis.exhaust_max_frequency = \"1 kHz\"");
    let out = folder.join("out");
    let run = ["run", design.as_str(), "--json", "--out", out.to_str().unwrap()];
    for arguments in [&["check", design.as_str()][..], &run] {
        let output = nailnoise(arguments);
        let said = String::from_utf8_lossy(&output.stderr).replace("\n  |", " ");
        let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(said.contains("bands from 1000 to 2000 Hz is missing"), "{said}");
        if arguments[0] == "run" {
            let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
            let notes = result["notes"].to_string();
            assert!(
                notes.contains("`analysis.exhaust_max_frequency` = 1000 Hz only"),
                "{notes}"
            );
        }
    }
}

#[test]
fn a_check_of_a_dry_fire_states_all_else() {
    let folder = folder("outcome-dry");
    let keys = "supply.pressure = \"1000 kPa\"\nnail.length = \"40 mm\"\npiston.rod_protrusion = \"1 mm\"";
    let output = nailnoise(&["check", &over(&folder, "dry", keys)]);
    assert_eq!(output.status.code(), Some(2));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("dry fire"), "{text}");
    assert!(SECTIONS.iter().all(|section| text.contains(section)), "{text}");
}
