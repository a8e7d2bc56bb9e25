//! `nailnoise cycle` in its variants: as published, with figures, sensitivities and draws.

use crate::common::{ROOT, command, folder, json};
use std::path::{Path, PathBuf};
use std::process::Output;

use serde_json::Value;

/// Runs the command in a separate folder, the parent of `out/`.
fn nailnoise(name: &str, arguments: &[&str]) -> (Output, PathBuf) {
    let folder = folder(&format!("cycle/{name}"));
    let design = format!("{ROOT}/designs/n80cb.toml");
    let arguments = [&["cycle", &design], arguments].concat();
    let output = command(&arguments).current_dir(&folder).output().unwrap();
    (output, folder)
}

#[test]
fn published_forms_strike_the_bumper_and_are_named() {
    for (argument, preset, words) in [
        ("--as-published", "published_all", "every form as published"),
        ("--as-published=all", "published_all", "every form as published"),
        ("--as-published=nail", "published_nail_only", "nail as published"),
    ] {
        let result = json(&nailnoise(preset, &[argument, "--json"]).0);
        assert_eq!([&result["preset"], &result["outcome"]], [preset, "strikes_bumper"]);
        let (output, folder) = nailnoise(preset, &[argument]);
        let text = String::from_utf8(output.stdout).unwrap();
        assert!(text.starts_with(&format!("n80cb, {words}: strikes bumper")), "{text}");
        // Beside the design's own files, not over them.
        assert!(folder.join("out/n80cb").join(preset).join("events.csv").exists());
        assert!(!folder.join("out/n80cb/events.csv").exists());
    }
    let own = json(&nailnoise("own", &["--json"]).0);
    assert_eq!(
        [&own["preset"], &own["outcome"]],
        [&Value::Null, &Value::from("drives")]
    );
}

#[test]
fn a_value_on_the_command_line_is_computed_and_a_wrong_one_is_named() {
    let own = json(&nailnoise("set", &["--json"]).0);
    let weak = json(&nailnoise("set", &["--json", "--set", "supply.pressure=60psig"]).0);
    assert_eq!([&own["outcome"], &weak["outcome"]], ["drives", "underdriven"]);
    let (output, _) = nailnoise("set", &["--set", "supply.pressure=60 mm"]);
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(
        text.contains("supply.pressure") && text.contains("command line:1:"),
        "{text}"
    );
}

#[test]
fn figures_are_written_and_listed() {
    let (output, folder) = nailnoise("figures", &["--figures", "--json"]);
    let figures = json(&output)["figures"].as_array().unwrap().clone();
    assert_eq!(figures.len(), 6);
    for figure in figures {
        let path = folder.join(figure.as_str().unwrap());
        assert!(
            std::fs::read_to_string(&path).unwrap().contains("n80cb: drives"),
            "{}",
            path.display()
        );
    }
}

#[test]
fn energy_and_log_are_in_the_result() {
    let result = json(&nailnoise("energy", &["--json"]).0);
    let energy = |name: &str| result["energy"][name].as_f64().unwrap();
    assert!(energy("penetration") > 50.0 && energy("penetration") < energy("piston_work"));
    assert!(result["energy"]["contacts"]["bumper"].as_f64().unwrap() > 0.0);
    let log = result["log"].as_array().unwrap();
    assert!(log.len() > 20);
    let (_, folder) = nailnoise("log", &[]);
    let csv = std::fs::read_to_string(folder.join("out/n80cb/log.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + log.len());
    assert!(csv.lines().all(|line| line.split(',').count() == 15));
    for words in ["the piston meets the bumper", "hole", "trigger", "turns"] {
        assert!(csv.contains(words), "{words}");
    }
}

#[test]
fn a_table_takes_the_place_of_the_designs_law() {
    let table = Path::new(env!("CARGO_TARGET_TMPDIR")).join("weak.csv");
    std::fs::write(&table, "# soft at the surface\n0,100\n0.0889,2300\n").unwrap();
    let table = table.to_str().unwrap();
    let weak = json(&nailnoise("table", &["--penetration-table", table, "--json"]).0);
    let own = json(&nailnoise("own-law", &["--json"]).0);
    let speed = |result: &Value| result["summary"]["mean_drive_speed"].as_f64().unwrap();
    assert!(speed(&weak) > speed(&own));
    assert_eq!(weak["penetration_table"], table);
    assert!(
        weak["checks"]
            .as_array()
            .unwrap()
            .iter()
            .all(|check| check["ok"] == true)
    );
    let text = String::from_utf8(nailnoise("table-text", &["--penetration-table", table]).0.stdout).unwrap();
    assert!(text.contains("penetration law of"), "{text}");
    let (output, _) = nailnoise("table-missing", &["--penetration-table", "none.csv"]);
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn sensitivity_ranks_the_parameters_asked_for() {
    let arguments = [
        "--sensitivity",
        "--outputs",
        "mean_drive_speed,exhaust_mass",
        "--parameters",
        "supply.pressure,piston.bore",
    ];
    let (output, folder) = nailnoise("sensitivity", &[&arguments[..], &["--json"]].concat());
    let result = json(&output);
    assert_eq!(result["schema"], "nailnoise-sensitivity/1");
    let outputs = result["outputs"].as_array().unwrap();
    assert_eq!(
        outputs.iter().map(|o| o["name"].as_str().unwrap()).collect::<Vec<_>>(),
        ["mean_drive_speed", "exhaust_mass"]
    );
    for output in outputs {
        let ranking = output["ranking"].as_array().unwrap();
        assert_eq!(ranking[0]["key"], "supply.pressure", "{output}");
        assert!(
            ranking.iter().all(|d| d["derivative"].as_f64().unwrap() > 0.0),
            "{output}"
        );
    }
    let csv = std::fs::read_to_string(folder.join("out/n80cb/sensitivity.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + 2 * 2);
    let text = String::from_utf8(nailnoise("sensitivity-text", &arguments).0.stdout).unwrap();
    for word in [
        "n80cb: drives; sensitivity to 2 parameters",
        "supply.pressure",
        "underdriven",
        "overdriven",
    ] {
        assert!(text.contains(word), "{word}\n{text}");
    }
}

#[test]
fn draws_are_counted_and_listed() {
    let (output, folder) = nailnoise("draw", &["--draw", "20", "--seed", "5", "--json"]);
    let result = json(&output);
    let sum = |name: &str| -> u64 {
        result[name]
            .as_object()
            .unwrap()
            .values()
            .map(|n| n.as_u64().unwrap())
            .sum()
    };
    assert_eq!(sum("counts"), 20);
    assert_eq!(sum("refused") + 20, result["candidates"].as_u64().unwrap());
    let csv = std::fs::read_to_string(folder.join("out/n80cb/draws.csv")).unwrap();
    assert_eq!(csv.lines().count(), 21);
    let columns = csv.lines().next().unwrap().split(',').count();
    assert_eq!(columns as u64, 5 + result["parameters"].as_u64().unwrap());
    assert!(csv.lines().all(|line| line.split(',').count() == columns));
    let text = String::from_utf8(nailnoise("draw-text", &["--draw", "20", "--seed", "5"]).0.stdout).unwrap();
    assert!(text.contains("20 designs drawn") && text.contains("refused"), "{text}");
}

#[test]
fn unknown_or_conflicting_options_are_refused() {
    for (arguments, words) in [
        (
            &["--sensitivity", "--outputs", "loudness"][..],
            vec!["no output \"loudness\"", "mean_drive_speed"],
        ),
        (
            &["--sensitivity", "--parameters", "supply.presure"],
            vec!["`supply.presure`", "is it `supply.pressure`?"],
        ),
        (
            &["--sensitivity", "--parameters", "body.cap_height"],
            vec!["not a quantity of the nailing cycle", "--parameters"],
        ),
        (&["--outputs", "speed"], vec!["--sensitivity"]),
        (&["--sensitivity", "--draw", "5"], vec!["cannot be used with"]),
        (&["--draw", "0"], vec!["0 is not in"]),
        (&["--as-published=some"], vec!["all, nail"]),
    ] {
        let (output, _) = nailnoise("refused", arguments);
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(words.iter().all(|word| error.contains(word)), "{arguments:?}: {error}");
    }
}
