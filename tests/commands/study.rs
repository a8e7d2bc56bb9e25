//! `nailnoise study`: the draws as a user makes them.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use serde_json::Value;

use crate::common::{ROOT, SMALL, command, design, folder, json, over};

/// Shots of all outcomes count, so that few candidates are drawn.
pub(crate) const ANY: &str =
    "[study]\nscreening = 4\nrequire = [\"drives\", \"underdriven\", \"overdriven\", \"strikes_bumper\"]\n";

/// Runs the command on a design in a folder with a separate cache.
fn study(folder: &Path, design: &str, arguments: &[&str]) -> Output {
    let arguments = [&["study", design, "--out", "out"], arguments].concat();
    let cache = folder.join("cache");
    command(&arguments)
        .current_dir(folder)
        .env("NAILNOISE_CACHE", cache)
        .output()
        .unwrap()
}

/// The files of a study.
fn files(folder: &Path) -> [Vec<u8>; 2] {
    ["study.json", "draws.csv"].map(|name| fs::read(folder.join("out/study").join(name)).unwrap())
}

fn made(name: &str) -> (PathBuf, String) {
    let folder = folder(&format!("study/{name}"));
    let design = over(&folder, "drawn", ANY);
    (folder, design)
}

#[test]
fn more_draws_begin_with_those_that_are_kept_and_threads_change_nothing() {
    let (grown, design) = made("grown");
    json(&study(&grown, &design, &["-n", "3", "--threads", "1", "--json"]));
    json(&study(&grown, &design, &["-n", "6", "--threads", "2", "--json"]));
    let (once, design) = made("once");
    let result = json(&study(&once, &design, &["-n", "6", "--threads", "1", "--json"]));
    assert!(files(&grown) == files(&once), "the files differ");
    assert_eq!(result["draws"], 6);
    assert_eq!(result["sources"].as_array().unwrap().len(), 3);
    let orders = result["orders"].as_array().unwrap().iter();
    let sum: f64 = orders.map(|own| own["probability"]["value"].as_f64().unwrap()).sum();
    assert!((sum - 1.0).abs() < 1e-12, "{sum}");
    let page = fs::read_to_string(once.join("out/study/study.html")).unwrap();
    assert!(page.contains("study-levels") && page.contains("P(first)"));
    // A run of the design shows the results of the study.
    let cache = once.join("cache");
    let run = command(&["run", &design, "--out", "out"]);
    let output = { run }
        .current_dir(&once)
        .env("NAILNOISE_CACHE", cache)
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("6 draws dB") && text.contains("P(first)"), "{text}");
    let report = fs::read_to_string(once.join("out/report.html")).unwrap();
    assert!(report.contains("6 draws dB"));
    // Another seed draws others.
    let other = json(&study(&once, &design, &["-n", "3", "--seed", "2", "--json"]));
    assert_ne!(other["total"]["level_db"], result["total"]["level_db"]);
}

/// A design in a folder with ranges of no width, except for those of `other` keys, one on each line.
fn held(folder: &Path, other: &[(&str, &str)], model: &str) -> String {
    let mut text = format!("base = \"{ROOT}/{SMALL}\"\n");
    for entry in design(SMALL).entries() {
        let free = other.iter().any(|(key, _)| *key == entry.key);
        if let (Some(_), Ok(Value::Number(value)), false) = (entry.range, serde_json::to_value(&entry.value), free) {
            text += &format!("{} = {{ range = [{value}, {value}] }}\n", entry.key);
        }
    }
    // So that the area of the holes, which follows from it, is not drawn.
    text += "exhaust.hole_diameter = { range = \"exact\" }\n";
    for (key, range) in other {
        text += &format!("{key} = {{ range = \"{range}\" }}\n");
    }
    text += &format!("[study]\nscreening = 0\nrequire = []\n[study.model]\n{model}");
    let path = folder.join("held.toml");
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

/// The level is the sum of the method's error, uniform over 6 dB, and of the effect of the pressure: the error
/// contributes 1/12 36 dB2 to the variance.
#[test]
fn a_polynomial_gives_the_indices_of_independent_inputs() {
    let folder = folder("study/polynomial");
    let model = "workpiece = \"0 .. 0 dB\"\nexhaust = \"-3 .. 3 dB\"\nbody = \"0 .. 0 dB\"\n";
    let path = held(&folder, &[("supply.pressure", "700 .. 800 kPa")], model);
    let result = json(&study(&folder, &path, &["-n", "64", "--json"]));
    let of_exhaust = result["surrogates"].as_array().unwrap().iter();
    let found = of_exhaust.clone().find(|own| own["output"] == "exhaust").unwrap();
    assert!(found["q2"].as_f64().unwrap() > 0.9, "{found}");
    assert_eq!(found["not_resolved"], Value::Null);
    let variance = result["contributions"].as_array().unwrap().iter();
    let variance = variance.clone().find(|own| own["output"] == "exhaust").unwrap()["variance_db2"]
        .as_f64()
        .unwrap();
    let inputs = found["inputs"].as_array().unwrap();
    let of_error = inputs.iter().find(|own| own["variable"] == "method.exhaust").unwrap();
    for index in ["first_order", "total"] {
        let value = of_error[index]["value"].as_f64().unwrap();
        assert!(
            (value - 3.0 / variance).abs() < 0.05,
            "{index}: {found}, variance {variance}"
        );
        let [low, high] = [0, 1].map(|end| of_error[index]["interval"][end].as_f64().unwrap());
        assert!(low < value && value < high, "{low} .. {high}");
    }
}

/// The error of a method moves its level directly; a quantity has the same effect as a run with its value.
#[test]
fn changes_of_one_input_are_those_of_runs() {
    let folder = folder("study/one-at-a-time");
    let model = "workpiece = \"0 .. 0 dB\"\nexhaust = \"-3 .. 3 dB\"\nbody = \"0 .. 0 dB\"\n";
    let path = held(&folder, &[("supply.pressure", "760 .. 770 kPa")], model);
    let found = json(&study(&folder, &path, &["-n", "2", "--one-at-a-time", "--json"]));
    let found = &found["one_at_a_time"];
    let place = found["outputs"]
        .as_array()
        .unwrap()
        .iter()
        .position(|name| name == "exhaust")
        .unwrap();
    let change = |variable: &str, end: usize| {
        let mut inputs = found["inputs"].as_array().unwrap().iter();
        let input = inputs.find(|own| own["variable"] == variable).unwrap();
        input["ends"][end]["change_db"][place].as_f64().unwrap()
    };
    let of_method = [0, 1].map(|end| change("method.exhaust", end));
    assert!(
        (of_method[0] + 2.7).abs() < 1e-9 && (of_method[1] - 2.7).abs() < 1e-9,
        "{of_method:?}"
    );
    let level = |set: &[&str]| {
        let run = command(&[&["run", &path, "--json", "--out", "out"], set].concat());
        let run = json(&{ run }.current_dir(&folder).output().unwrap());
        let mut sources = run["ranking"].as_array().unwrap().iter();
        sources.find(|own| own["source"] == "exhaust").unwrap()["lwa_db"]
            .as_f64()
            .unwrap()
    };
    let of_run = level(&["--set", "supply.pressure=769.5 kPa"]) - level(&[]);
    assert!((change("supply.pressure", 1) - of_run).abs() < 1e-9, "{of_run}");
    let table = fs::read_to_string(folder.join("out/study/one-at-a-time.csv")).unwrap();
    assert!(
        table.starts_with("input,unit,value at P5") && table.lines().count() > 2,
        "{table}"
    );
}

/// Draws from ranges of no width are the design itself.
#[test]
fn ranges_of_no_width_reproduce_the_run() {
    let folder = folder("study/zero");
    let model = "workpiece = \"0 .. 0 dB\"\nexhaust = \"0 .. 0 dB\"\nbody = \"0 .. 0 dB\"\n";
    let path = &held(&folder, &[], model);
    let result = json(&study(&folder, path, &["-n", "3", "--json"]));
    let run = command(&["run", path, "--json", "--out", "out"])
        .current_dir(&folder)
        .output()
        .unwrap();
    let run = json(&run);
    for source in run["ranking"].as_array().unwrap() {
        let own = result["sources"]
            .as_array()
            .unwrap()
            .iter()
            .find(|own| own["source"] == source["source"]);
        let level = &own.unwrap()["level"];
        for quantile in ["p05", "p50", "p95"] {
            assert_eq!(
                level["level_db"][quantile]["value"], source["lwa_db"],
                "{}",
                source["source"]
            );
        }
        let bands = own.unwrap()["bands"].as_array().unwrap().iter();
        for (band, expected) in bands.zip(source["bands"].as_array().unwrap()) {
            assert_eq!(band["level_db"]["p50"]["value"], expected["lwa_db"]);
        }
    }
    assert!(
        result["variables"]
            .as_array()
            .unwrap()
            .iter()
            .all(|own| own["scope"] == "method")
    );
}

#[test]
fn what_cannot_be_drawn_is_refused_with_a_remedy() {
    let refused = |name: &str, text: &str, arguments: &[&str], words: &[&str]| {
        let folder = folder(&format!("study/{name}"));
        let design = over(&folder, "refused", text);
        let output = study(&folder, &design, arguments);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{name}: {message}");
        let flat = message.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.iter().all(|word| flat.contains(word)), "{name}: {message}");
    };
    refused("none", "", &["-n", "0"], &["0 is not in"]);
    refused(
        "outcome",
        "[study]\nrequire = \"flies\"",
        &[],
        &["study.require", "underdriven"],
    );
    refused(
        "key",
        "[study]\nrequires = \"drives\"",
        &[],
        &["study.requires", "study.require"],
    );
    let two = "[[study.correlation]]\nkeys = [\"piston.mass\", \"piston.mas\"]\nrank = 0.5";
    refused("correlated", two, &[], &["piston.mas", "with a range"]);
    let against = "[[study.correlation]]\nkeys = [\"piston.mass\", \"tool.mass\", \"piston.stroke\"]\nrank = -0.9";
    refused("against", against, &[], &["study.correlation.rank"]);
    refused(
        "distributed",
        "piston.mass = { value = \"0.2 kg\", range = \"129 .. 133 g\", distribution = \"triangular\" }",
        &[],
        &["piston.mass", "leaves out its value"],
    );
    refused(
        "word",
        "piston.mass = { distribution = \"gauss\" }",
        &[],
        &["normal", "log-uniform"],
    );
    refused("model", "[study.model]\nexhaust = \"4 dB\"", &[], &["low .. high dB"]);
    refused(
        "alternative",
        "[study.alternatives]\n\"support.kind\" = { table = 1 }",
        &[],
        &["worktable"],
    );
}

#[test]
fn alternatives_are_drawn_with_their_probabilities() {
    let (folder, _) = made("alternatives");
    let text = format!("{ANY}[study.alternatives]\nexhaust = [{{ holes = 5 }}, {{ holes = 3, weight = 3 }}]\n");
    let design = over(&folder, "alternatives", &text);
    let result = json(&study(&folder, &design, &["-n", "4", "--json"]));
    let variables = result["variables"].as_array().unwrap();
    let own = variables.iter().find(|own| own["name"] == "exhaust").unwrap();
    assert_eq!(own["distribution"], "holes 5 (25 %); holes 3 (75 %)");
    assert!(!variables.iter().any(|own| own["name"] == "exhaust.holes"));
    let table = fs::read_to_string(folder.join("out/study/draws.csv")).unwrap();
    let mut lines = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let _ = lines.next();
    assert!(table.contains("holes 3") || table.contains("holes 5"));
    assert_eq!(lines.count(), 4);
}

/// Designs that differ in only one value do not differ if the command line sets that value.
#[test]
fn a_comparison_over_draws_holds_the_values_of_the_command_line() {
    let (folder, first) = made("set");
    let second = over(&folder, "other", &format!("exhaust.holes = 4\n{ANY}"));
    let compare = |set: &[&str]| {
        let arguments = [
            &["compare", &first, &second, "--draws", "2", "--json", "--out", "out"],
            set,
        ]
        .concat();
        let output = command(&arguments)
            .current_dir(&folder)
            .env("NAILNOISE_CACHE", folder.join("cache"))
            .output();
        json(&output.unwrap())["paired"][0].clone()
    };
    assert_eq!(compare(&[])["decided"], serde_json::json!(["exhaust.holes"]));
    assert_eq!(compare(&["--set", "exhaust.holes=5"])["decided"], serde_json::json!([]));
}

/// Tasks that share a store make the draws of one study, to the byte; missing draws are counted and refused.
#[test]
fn tasks_and_their_collection_are_the_study() {
    let (folder, design) = made("tasks");
    let draw = |more: &[&str]| study(&folder, &design, &[&["-n", "5"], more].concat());
    let refused = draw(&["--store", "shared", "--collect"]);
    let message = String::from_utf8(refused.stderr).unwrap();
    assert_eq!(refused.status.code(), Some(2), "{message}");
    assert!(message.contains("5 of 5 draws are not in shared"), "{message}");
    let counts = ["1/2", "2/2"].map(|task| {
        let made = json(&draw(&["--store", "shared", "--task", task, "--json"]));
        made["draws"].as_u64().unwrap()
    });
    assert_eq!(counts, [3, 2]);
    json(&draw(&["--store", "shared", "--collect", "--json"]));
    let collected = files(&folder);
    json(&draw(&["--json"]));
    assert_eq!(files(&folder), collected);
}

#[test]
fn designs_are_compared_over_drawn_structures_too() {
    let (folder, reference) = made("structures");
    let other = over(&folder, "other", &format!("{ANY}[exhaust]\nholes = 3\n"));
    let arguments = [
        "compare",
        &reference,
        &other,
        "--draws",
        "4",
        "--structures=2",
        "--json",
        "--out",
        "out",
    ];
    let output = command(&arguments)
        .current_dir(&folder)
        .env("NAILNOISE_CACHE", folder.join("cache"))
        .output()
        .unwrap();
    let paired = &json(&output)["paired"][0];
    assert_eq!(
        (&paired["draws"], &paired["structures"]),
        (&Value::from(4), &Value::from(2))
    );
}

/// Every quantity that is drawn is in one group, every draw has two partners for each group, and threads change
/// nothing.
#[test]
fn groups_hold_every_quantity_and_each_draw_has_its_partners() {
    let (folder, design) = made("groups");
    let draw = |threads: &str| {
        let arguments = ["-n", "2", "--groups", "--threads", threads, "--json"];
        let result = json(&study(&folder, &design, &arguments));
        (result, fs::read_to_string(folder.join("out/study/groups.csv")).unwrap())
    };
    let (result, table) = draw("2");
    let names = |value: &Value| -> Vec<String> {
        let names = value.as_array().unwrap().iter();
        names.map(|name| name.as_str().unwrap().to_owned()).collect()
    };
    let groups = result["groups"]["groups"].as_array().unwrap();
    let mut grouped: Vec<String> = groups.iter().flat_map(|own| names(&own["variables"])).collect();
    let drawn = result["variables"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|own| own["drawn"] == true);
    let mut drawn: Vec<String> = drawn.map(|own| own["name"].as_str().unwrap().to_owned()).collect();
    grouped.sort();
    drawn.sort();
    assert_eq!(grouped, drawn);
    assert_eq!(result["groups"]["rows"], 2);
    assert_eq!(table.lines().count(), 1 + 2 * (1 + 2 * groups.len()));
    let outputs = result["groups"]["outputs"].as_array().unwrap();
    assert!(outputs.iter().any(|own| own["output"] == "total"));
    for own in outputs {
        assert_eq!(own["groups"].as_array().unwrap().len(), groups.len());
    }
    fs::remove_dir_all(folder.join("cache")).unwrap();
    let (again, same) = draw("1");
    assert!(table == same && result == again, "threads change the partners");
    let page = fs::read_to_string(folder.join("out/study/study.html")).unwrap();
    assert!(page.contains("Groups of inputs"));
}

#[test]
fn groups_over_drawn_structures_are_refused_with_a_remedy() {
    let (folder, design) = made("groups-structures");
    let output = study(&folder, &design, &["-n", "2", "--groups", "--structures"]);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(
        message.contains("exclude each other") && message.contains("without --structures"),
        "{message}"
    );
    assert!(!folder.join("out/study").exists());
}

/// The tool of a drawn structure is new geometry.
#[test]
fn a_study_without_the_levels_of_any_draw_ends_with_the_reason_and_its_remedy() {
    let folder = folder("study/no-mesher");
    let tool = format!("{ANY}[body]\nmodel = \"elastic\"\n");
    let design = over(&folder, "drawn", &tool);
    let arguments = ["study", &design, "--out", "out", "-n", "2", "--structures=1"];
    let cache = folder.join("cache");
    let output = command(&arguments)
        .current_dir(&folder)
        .env("NAILNOISE_CACHE", cache)
        .env("NAILNOISE_GMSH", "no-such-program")
        .output()
        .unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(3), "{message}");
    assert!(
        message.contains("none of 2 draws") && message.contains("install it with"),
        "{message}"
    );
    assert!(!folder.join("out/study").exists());
}

#[test]
fn a_study_to_come_with_the_program_is_of_a_shipped_design() {
    let (folder, design) = made("provided");
    let output = study(&folder, &design, &["-n", "1", "--provide", "study.json"]);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("`drawn` is none"), "{message}");
    assert!(!folder.join("study.json").exists());
}

/// Runs the command `run` on a design in a folder with a separate cache.
fn run(folder: &Path, design: &str, arguments: &[&str]) -> Output {
    let arguments = [&["run", design, "--out", "out"], arguments].concat();
    command(&arguments)
        .current_dir(folder)
        .env("NAILNOISE_CACHE", folder.join("cache"))
        .output()
        .unwrap()
}

/// Files in the folder of a run, without its subfolders.
fn files_of_run(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder.join("out"))
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let name = |path: &PathBuf| path.file_name().unwrap().to_str().unwrap().to_owned();
    let files = entries.filter(|path| path.is_file());
    files.map(|path| (name(&path), fs::read(&path).unwrap())).collect()
}

fn result_of(folder: &Path) -> Value {
    serde_json::from_slice(&fs::read(folder.join("out/result.json")).unwrap()).unwrap()
}

/// Result, ranking and report state the same intervals: without draws, of a screening, and of a larger study that
/// follows it.
#[test]
fn every_file_of_a_run_states_the_study_that_serves_it() {
    let (folder, design) = made("stated");
    let printed = run(&folder, &design, &["--json"]).stdout;
    assert_eq!(printed, fs::read(folder.join("out/result.json")).unwrap());
    let absent = result_of(&folder);
    assert_eq!(absent["study"]["state"], "absent");
    assert!(absent["study"]["reason"].as_str().unwrap().contains("no study serves"));
    assert_eq!(absent["declaration"]["k_not_stated"], absent["study"]["reason"]);
    let states = |draws: usize| {
        let result = result_of(&folder);
        let (study, declaration) = (&result["study"], &result["declaration"]);
        assert_eq!([&study["state"], &study["ends"]], ["known", "extremes"]);
        assert_eq!(study["draws"], draws);
        assert!(declaration["k_db"].is_null() && declaration["k_not_stated"].is_string());
        let report = fs::read_to_string(folder.join("out/report.html")).unwrap();
        assert!(report.contains(&format!("{draws} draws dB")));
        let ranking = fs::read_to_string(folder.join("out/ranking.csv")).unwrap();
        let spreads = study["sources"].as_array().unwrap().iter().chain([&study["total"]]);
        for own in spreads {
            let name = own["source"].as_str().unwrap();
            let row = ranking
                .lines()
                .find(|row| row.starts_with(&format!("{name},")))
                .unwrap();
            let cells: Vec<&str> = row.split(',').skip(5).collect();
            let number =
                |key: &str, digits: usize| own[key].as_f64().map_or_else(String::new, |x| format!("{x:.digits$}"));
            let silencing = |end: usize| {
                let fall = own["silencing_db"][end].as_f64();
                fall.map_or_else(String::new, |fall| format!("{fall:.3}"))
            };
            let expected = [
                number("low_db", 3),
                number("high_db", 3),
                number("first", 4),
                draws.to_string(),
                silencing(0),
                silencing(1),
                // K is stated for studies of enough draws.
                String::new(),
                "drives".to_owned(),
            ];
            assert_eq!(cells, expected, "{name}");
        }
        let printed = run(&folder, &design, &["--json"]).stdout;
        assert_eq!(printed, fs::read(folder.join("out/result.json")).unwrap());
    };
    let before = files_of_run(&folder);
    assert!(run(&folder, &design, &[]).status.success());
    states(4);
    let after = files_of_run(&folder);
    let changed = after.iter().filter(|(name, bytes)| before[*name] != **bytes);
    let changed: Vec<&str> = changed.map(|(name, _)| name.as_str()).collect();
    assert_eq!(changed, ["ranking.csv", "report.html", "result.json"]);
    let again = String::from_utf8(run(&folder, &design, &[]).stdout).unwrap();
    assert!(
        again.contains("unchanged design") && again.contains("4 draws dB"),
        "{again}"
    );
    json(&study(&folder, &design, &["-n", "6", "--json"]));
    let text = String::from_utf8(run(&folder, &design, &[]).stdout).unwrap();
    assert!(
        !text.contains("unchanged design") && text.contains("6 draws dB"),
        "{text}"
    );
    states(6);
}

/// The files of a run are complete before its screening begins.
#[test]
#[cfg(unix)]
fn an_interrupted_screening_leaves_a_complete_result_with_the_reason() {
    let (folder, design) = made("interrupted");
    let mut process = command(&["run", &design, "--out", "out"])
        .current_dir(&folder)
        .env("NAILNOISE_CACHE", folder.join("cache"))
        .stdout(std::process::Stdio::null())
        .spawn()
        .unwrap();
    while !folder.join("out/result.json").exists() {
        assert!(process.try_wait().unwrap().is_none(), "the run ends without a result");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let number = process.id().to_string();
    let sent = std::process::Command::new("kill").args(["-s", "INT", &number]).status();
    assert!(sent.unwrap().success());
    assert_eq!(process.wait().unwrap().code(), Some(130));
    let study = &result_of(&folder)["study"];
    assert!(
        study["reason"].as_str().unwrap().contains("4 draws has not ended"),
        "{study}"
    );
    let report = fs::read_to_string(folder.join("out/report.html")).unwrap();
    assert!(report.contains("4 draws has not ended") && report.ends_with("</html>"));
    // The next run makes up for it.
    assert!(run(&folder, &design, &[]).status.success());
    assert_eq!(result_of(&folder)["study"]["draws"], 4);
}

#[test]
fn a_screening_that_fails_is_named_in_a_complete_result() {
    let folder = folder("study/no-candidate");
    // No draw of the only alternative is a design.
    let alternatives = "[study.alternatives]\npiston = [{ bore = \"1 mm\" }]\n";
    let design = over(&folder, "drawn", &format!("{ANY}{alternatives}"));
    let output = run(&folder, &design, &[]);
    let text = String::from_utf8(output.stdout).unwrap();
    let result = result_of(&folder);
    let reason = result["study"]["reason"].as_str().unwrap();
    assert!(reason.contains("none of"), "{reason}");
    assert!(text.contains(reason), "{text}");
    assert_eq!(output.status.code(), Some(0));
}

/// `compare` shows the intervals of designs that studies serve, in the terminal, on the page and as JSON.
#[test]
fn a_comparison_of_a_design_with_a_study_shows_its_intervals() {
    let (folder, design) = made("compared");
    json(&study(&folder, &design, &["-n", "3", "--json"]));
    let other = format!("{ROOT}/{SMALL}");
    let compare = |more: &[&str]| {
        let arguments = [&["compare", &design, &other, "--out", "out"], more].concat();
        let output = command(&arguments)
            .current_dir(&folder)
            .env("NAILNOISE_CACHE", folder.join("cache"))
            .output()
            .unwrap();
        (String::from_utf8(output.stdout).unwrap(), output.status)
    };
    let (text, status) = compare(&["--json"]);
    assert!(status.success());
    let compared: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(compared["studies"][0]["draws"], 3);
    assert_eq!(compared["studies"][1], Value::Null);
    let total = &compared["studies"][0]["total"];
    let [low, high] = ["low_db", "high_db"].map(|end| total[end].as_f64().unwrap());
    let own = compared["total"]["level_db"][0].as_f64().unwrap();
    assert!(low <= own && own <= high, "{low} .. {own} .. {high}");
    let interval = format!("{low:.1} .. {high:.1}");
    let (text, _) = compare(&[]);
    assert!(
        text.contains("intervals of the levels") && text.contains(&interval),
        "{text}"
    );
    assert!(text.contains("lowest to highest level of 3 draws"), "{text}");
    let page = text
        .lines()
        .find_map(|line| line.trim().strip_prefix("as a page: "))
        .unwrap();
    let page = fs::read_to_string(folder.join(page)).unwrap();
    assert!(page.contains("Intervals of the levels") && page.contains(&interval));
}
