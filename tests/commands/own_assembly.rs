//! `run --set`, `compare`, `sweep`, `study`, `optimise` and `test` of a tool that its own file describes: the tacker of
//! the page.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::common::{command, folder, json, messages, over};

/// Area of the exhaust of the tacker and a smaller one \[m2\].
const AREAS: [f64; 2] = [30e-6, 15e-6];
const KEY: &str = "cycle.passage.exhaust.area";

/// The tacker in a folder, on the small design, with further lines.
fn tacker(folder: &Path, name: &str, more: &str) -> String {
    let parts = crate::assembly::blocks();
    let (_, tacker) = parts.split_last().unwrap();
    over(folder, name, &format!("{}\n{more}", tacker.concat()))
}

fn made(name: &str) -> (PathBuf, String) {
    let folder = folder(&format!("own_assembly/{name}"));
    let design = tacker(&folder, "tacker", "[study]\nscreening = 0\nrequire = []");
    (folder, design)
}

/// The JSON value that a command prints in a folder.
fn printed(folder: &Path, arguments: &[&str]) -> Value {
    let all = [arguments, &["--json", "--out", "out"]].concat();
    json(&command(&all).current_dir(folder).output().unwrap())
}

/// Level of the exhaust of a run \[dB\].
fn exhaust(ranking: &Value) -> f64 {
    let mut sources = ranking.as_array().unwrap().iter();
    let own = sources.find(|own| own["source"] == "exhaust").unwrap();
    own["lwa_db"].as_f64().unwrap()
}

/// A sweep, a comparison and a run with `--set` of the same literal have the same levels.
#[test]
fn a_literal_of_a_block_is_set_swept_and_compared_alike() {
    let (folder, design) = made("alike");
    let set = format!("{KEY}=15mm2");
    let [base, narrow] = [&[][..], &["--set", &set]].map(|set| {
        let result = printed(&folder, &[&["run", &design], set].concat());
        exhaust(&result["ranking"])
    });
    assert!(narrow < base - 0.5, "{narrow} dB against {base} dB");
    let swept = printed(&folder, &["sweep", &design, "--vary", &format!("{KEY}=30mm2,15mm2")]);
    for (point, level) in swept["points"].as_array().unwrap().iter().zip([base, narrow]) {
        let found = exhaust(&point["levels"]["sources"]);
        assert!((found - level).abs() < 1e-6, "{found} dB against {level} dB: {point}");
    }
    let text = fs::read_to_string(&design).unwrap();
    let (before, after) = text.split_once("[cycle.passage.exhaust]").unwrap();
    let after = after.replacen("area = \"30 mm2\"", "area = \"15 mm2\"", 1);
    let other = folder.join("narrow.toml");
    fs::write(&other, format!("{before}[cycle.passage.exhaust]{after}")).unwrap();
    let compared = printed(&folder, &["compare", &design, other.to_str().unwrap()]);
    let inputs = compared["inputs"].as_array().unwrap();
    assert_eq!(inputs.len(), 1, "{inputs:#?}");
    assert_eq!((&inputs[0]["key"], &inputs[0]["unit"]), (&KEY.into(), &"m2".into()));
    for (value, area) in inputs[0]["values"].as_array().unwrap().iter().zip(AREAS) {
        assert!((value.as_f64().unwrap() / area - 1.0).abs() < 1e-12, "{value}");
    }
    let mut rows = compared["sources"].as_array().unwrap().iter();
    let row = rows.find(|own| own["source"] == "exhaust").unwrap();
    for (value, level) in row["level_db"].as_array().unwrap().iter().zip([base, narrow]) {
        assert!((value.as_f64().unwrap() - level).abs() < 1e-6, "{row}");
    }
}

#[test]
fn a_literal_that_no_block_has_is_refused_with_the_nearest() {
    let (folder, design) = made("unknown");
    for arguments in [
        ["run", &design, "--set", "cycle.passage.exhaust.aera=15mm2"],
        ["sweep", &design, "--vary", "cycle.passage.exhaust.aera=15mm2,30mm2"],
    ] {
        let output = command(&arguments).current_dir(&folder).output().unwrap();
        let message = messages(&output);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains("did you mean \"area\"?"), "{message}");
    }
}

#[test]
fn a_study_draws_the_range_of_a_literal() {
    let (folder, design) = made("drawn");
    let result = printed(&folder, &["study", &design, "-n", "3"]);
    assert_eq!(result["draws"], 3);
    let mut table = csv::Reader::from_path(folder.join("out/study/draws.csv")).unwrap();
    let header = table.headers().unwrap().clone();
    let place = header.iter().position(|name| name.starts_with("cycle.let.bore"));
    let place = place.unwrap_or_else(|| panic!("{header:?}"));
    let bores: Vec<f64> = table
        .records()
        .map(|record| record.unwrap()[place].parse().unwrap())
        .collect();
    assert_eq!(bores.len(), 3);
    for bore in &bores {
        assert!((24e-3..=32e-3).contains(bore), "{bores:?}");
        assert_eq!(bores.iter().filter(|other| *other == bore).count(), 1, "{bores:?}");
    }
    for name in ["piston.mass", "supply.pressure", "nail.length"] {
        assert!(!header.iter().any(|own| own.starts_with(name)), "{name} has no effect");
    }
}

/// The best design is that of the page's table, and has the level that was stated.
#[test]
fn a_literal_is_optimised_under_a_limit_of_a_figure_of_the_assembly() {
    let (folder, design) = made("optimised");
    let vary = format!("{KEY}=15mm2..30mm2");
    let search = [
        "--vary",
        &vary,
        "--trials",
        "6",
        "--minimise",
        "exhaust",
        "--subject-to",
        "staple_depth >= 1 mm",
    ];
    let found = printed(&folder, &[&["optimise", &design], &search[..]].concat());
    let all = found["trials"].as_array().unwrap();
    assert!(all.iter().all(|own| own["refused"] == ""), "{all:#?}");
    let best = &all[found["front"][0].as_u64().unwrap() as usize];
    assert!(best["figures"]["staple_depth"].as_f64().unwrap() >= 1e-3, "{best}");
    assert!(
        best["figures"]["flush_energy"].is_number() || best["figures"]["head_depth"].is_number(),
        "{best}"
    );
    let file = found["files"][0].as_str().unwrap();
    let result = printed(&folder, &["run", file]);
    let stated = exhaust(&best["levels"]["sources"]);
    assert!((exhaust(&result["ranking"]) - stated).abs() < 0.01, "{stated} dB");
}

/// The virtual test measures the exhaust, and states which scatter the tool does not have.
#[test]
fn a_virtual_test_of_an_assembly_has_its_sources() {
    let (folder, design) = made("tested");
    let exact = |area: &str| {
        let set = format!("{KEY}={area}");
        let result = printed(&folder, &["test", &design, "--energies", "--set", &set]);
        let levels = &result["exact"]["sources_db"];
        assert!(levels.as_array().unwrap().iter().all(Value::is_number), "{levels}");
        let keys = result["without_scatter"].as_array().unwrap().clone();
        (levels[1].as_f64().unwrap(), keys)
    };
    let ((wide, keys), (narrow, _)) = (exact("30mm2"), exact("15mm2"));
    assert!(narrow < wide - 0.5, "{narrow} dB against {wide} dB");
    assert_eq!(keys, ["supply.pressure", "wood.resistance_scale"]);
}

/// A run removes the outputs that an earlier run left in its folder and that it does not have itself.
#[test]
fn outputs_of_an_earlier_run_are_removed() {
    let (folder, design) = made("outdated");
    let transducer = "[transducers.P1]\nchamber = \"vessel\"\nposition = \"0 mm\"\ndischarge_time = \"1 s\"\n";
    let text = fs::read_to_string(&design).unwrap();
    let with = folder.join("with.toml");
    fs::write(&with, format!("{text}\n{transducer}")).unwrap();
    let readings = folder.join("out/transducers.csv");
    // The second time, the files of both runs come from the cache.
    for _ in 0..2 {
        printed(&folder, &["run", with.to_str().unwrap()]);
        assert!(readings.is_file());
        printed(&folder, &["run", &design]);
        assert!(!readings.exists());
        assert!(folder.join("out/modes.csv").is_file() && folder.join("out/report.html").is_file());
    }
}

/// A tool that a force lifts off its work, with a trigger that nothing follows.
const LIFTED: &str = r#"[cycle]
assembly = { name = "lifted", schema = 1 }
gas = { constant = "287.05 J/(kg K)", ratio = 1.4 }
end = "10 ms"
gravity = "9.81 m/s2"
reservoir.atmosphere = { pressure = "101.325 kPa", temperature = "20 degC" }
trigger.pressed = { starts = true }
body.tool = { mass = "1 kg", start = { rest_on = "nose" } }
force.pull = { on = "tool", force = "-50 N" }
contact.nose = { on = "tool", against = "ground", stop = "below", stiffness = "1 kN/mm", damping_ratio = 0.1 }
"#;

#[test]
fn an_error_of_a_run_and_an_unused_block_are_shown_at_their_places() {
    let folder = folder("own_assembly/places");
    fs::write(folder.join("lifted.toml"), LIFTED).unwrap();
    let message = |arguments: &[&str], status: i32| {
        let output = command(arguments).current_dir(&folder).output().unwrap();
        let message = messages(&output);
        assert_eq!(output.status.code(), Some(status), "{message}");
        message.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let cycle = message(&["cycle", "lifted.toml"], 2);
    for part in [
        "lifted.toml, line 10: `cycle.contact.nose`: nothing presses \"nose\" at rest (-40.2 N)",
        "lifted.toml:10:",
        "`cycle.trigger.pressed` has no effect: nothing names it",
        "lifted.toml:7:",
    ] {
        assert!(cycle.contains(part), "lacks {part}: {cycle}");
    }
    let check = message(&["check", "lifted.toml"], 2);
    assert!(check.contains("nothing presses \"nose\" at rest (-40.2 N)"), "{check}");
    assert!(check.contains("`cycle.trigger.pressed` has no effect"), "{check}");
    assert!(check.contains("open = { when = \"pressed\" }"), "{check}");
}

/// Rows of a comparison of the tacker with itself after a change.
fn differences(name: &str, more: &str) -> Vec<(String, Vec<Value>)> {
    let (folder, design) = made(name);
    let other = folder.join("changed.toml");
    fs::write(&other, format!("base = \"tacker.toml\"\n{more}")).unwrap();
    let compared = printed(&folder, &["compare", &design, other.to_str().unwrap()]);
    assert_eq!(compared["without_assembly"], serde_json::json!([]));
    let rows = compared["inputs"].as_array().unwrap().iter();
    rows.map(|row| {
        (
            row["key"].as_str().unwrap().to_owned(),
            row["values"].as_array().unwrap().clone(),
        )
    })
    .collect()
}

/// A switch that is not given is off.
#[test]
fn a_comparison_names_a_switch_of_a_block() {
    let on = "[cycle.passage.exhaust]\none_way = true\n";
    let path = "cycle.passage.exhaust.one_way".to_owned();
    assert_eq!(
        differences("switched", on),
        [(path, vec!["false".into(), "true".into()])]
    );
    assert_eq!(differences("not-switched", &on.replace("true", "false")), []);
}

#[test]
fn a_comparison_names_new_blocks_once_with_their_fields() {
    let more = "[cycle.volume.side]\ndead = \"20 cm3\"\npressure = \"=ambient.pressure\"\n\
                [cycle.passage.neck]\nbetween = [\"side\", \"vessel\"]\narea = \"2 mm2\"\none_way = true\n";
    let mut rows = differences("chamber", more);
    rows.sort_by(|a, b| a.0.cmp(&b.0));
    let names: Vec<&str> = rows.iter().map(|row| row.0.as_str()).collect();
    assert_eq!(names, ["cycle.passage.neck", "cycle.volume.side"]);
    assert_eq!(
        rows[1].1,
        [Value::Null, "dead 20 cm3, pressure =ambient.pressure".into()]
    );
    let neck = rows[0].1[1].as_str().unwrap();
    for field in ["between.0 side", "between.1 vessel", "area 2 mm2", "one_way true"] {
        assert!(neck.contains(field), "{neck}");
    }
}

#[test]
fn a_comparison_names_a_removed_block_once() {
    let rows = differences("removed", "[cycle.friction]\nseal = false\n");
    assert_eq!(rows.len(), 1, "{rows:?}");
    assert_eq!(rows[0].0, "cycle.friction.seal");
    assert!(rows[0].1[0].is_string() && rows[0].1[1].is_null(), "{rows:?}");
}

/// A design without a base that changes a number of its tool: `cycle` and `check` read its keys, as `run` does.
#[test]
fn a_complete_design_may_change_its_assembly() {
    let folder = folder("own_assembly/complete");
    let text = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb.toml")).unwrap();
    let change = "\n[cycle.passage.leak]\ncoefficient = 0.7\n";
    fs::write(folder.join("complete.toml"), text + change).unwrap();
    let [own, set] = [
        vec!["cycle", "complete.toml"],
        vec!["cycle", "complete.toml", "--set", "cycle.passage.leak.coefficient=0.9"],
    ]
    .map(|arguments| {
        let result = printed(&folder, &arguments);
        let mut events = result["events"].as_array().unwrap().iter();
        events.find(|event| event["name"] == "t9").unwrap()["time"]
            .as_f64()
            .unwrap()
    });
    assert!((own - set).abs() > 1e-9 && own > 0.01, "{own} s, {set} s");
    let checked = command(&["check", "complete.toml"])
        .current_dir(&folder)
        .output()
        .unwrap();
    assert!(checked.status.success(), "{}", messages(&checked));
}
