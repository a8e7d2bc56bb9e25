//! `nailnoise calibrate`: measurements as a user states them, and what becomes of those that contradict each other.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use serde_json::Value;

use crate::common::{command, folder, json, messages, over};
use crate::study::ANY;

/// Head depths of a tool at two pressures, and the air of a shot.
fn measurements(low: &str, high: &str) -> String {
    let depth = |name: &str, value: &str| {
        format!(
            "{name} = {{ condition = \"{name}\", quantity = \"head_depth\", value = \"{value}\", shots = 5, \
             scatter = \"1 mm\", error = \"0.5 mm\", discrepancy = \"1 mm\" }}\n"
        )
    };
    format!(
        "schema = \"nailnoise-calibration/1\"\n[condition]\n\
         low = {{ set = {{ \"supply.pressure\" = \"80 psig\" }} }}\n\
         high = {{ set = {{ \"supply.pressure\" = \"110 psig\" }} }}\n\
         [measured]\n{}{}\
         air = {{ condition = \"high\", quantity = \"air_per_shot\", value = \"1.5 l\", error = \"4 %\" }}\n",
        depth("low", low),
        depth("high", high)
    )
}

/// Two depths that contradict each other: the nail goes deeper at the lower pressure.
fn contradicting() -> String {
    measurements("1 mm", "-25 mm")
}

/// A folder with a design of any outcome and a file of measurements.
fn made(name: &str, measured: &str) -> (PathBuf, String) {
    let folder = folder(&format!("calibrate/{name}"));
    fs::write(folder.join("shots.toml"), measured).unwrap();
    let design = over(&folder, "tool", ANY);
    (folder, design)
}

fn calibrate(folder: &Path, design: &str, arguments: &[&str]) -> Output {
    let own = [
        "calibrate",
        design,
        "--measured",
        "shots.toml",
        "--out",
        "out",
        "--moves",
        "3",
    ];
    command(&[&own, arguments].concat())
        .current_dir(folder)
        .env("NAILNOISE_CACHE", folder.join("cache"))
        .output()
        .unwrap()
}

fn result(folder: &Path) -> Value {
    serde_json::from_slice(&fs::read(folder.join("out/calibration/calibration.json")).unwrap()).unwrap()
}

fn measurement_outcomes(result: &Value) -> Vec<(bool, &str)> {
    let rows = result["measurements"].as_array().unwrap().iter();
    rows.map(|own| (own["counts"].as_bool().unwrap(), own["verdict"].as_str().unwrap()))
        .collect()
}

#[test]
fn a_contradiction_is_named_as_a_pair_and_left_out_or_widened() {
    let (folder, design) = made("pair", &contradicting());
    let output = calibrate(&folder, &design, &["--draws", "128"]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(1), "{text}\n{}", messages(&output));
    let left_out = result(&folder);
    let conflicts = left_out["conflicts"].as_array().unwrap();
    assert_eq!(conflicts.len(), 1, "{text}");
    let mut pair = ["measurement", "partner"].map(|key| conflicts[0][key].as_str().unwrap());
    pair.sort_unstable();
    assert_eq!(pair, ["high", "low"]);
    assert!(conflicts[0]["probability"].as_f64().unwrap() < 0.01 && conflicts[0]["widened"].is_null());
    assert!(conflicts[0]["gain"].as_f64().unwrap() > 5.0, "{text}");
    assert_eq!(
        measurement_outcomes(&left_out),
        [(false, "conflict"), (false, "conflict"), (true, "met")]
    );
    for words in [
        "contradict each other",
        "left out of all intervals",
        "all intervals leave out",
    ] {
        assert!(text.contains(words), "{text}");
    }
    let page = fs::read_to_string(folder.join("out/calibration/calibration.html")).unwrap();
    assert!(page.contains("contradict"));

    // The draws with both readings are stored, so that only the widened ones are made.
    let output = calibrate(&folder, &design, &["--draws", "128", "--conflict", "widen"]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(1), "{text}\n{}", messages(&output));
    let widened = result(&folder);
    let factor = widened["conflicts"][0]["widened"].as_f64().unwrap();
    assert!(factor > 2.0, "{text}");
    assert_eq!(
        measurement_outcomes(&widened),
        [(true, "conflict"), (true, "conflict"), (true, "met")]
    );
    assert!(text.contains(&format!("widened by a factor {factor:.1}")), "{text}");
}

/// A stapler of the assembly's own words on the small design, with a reading of its staple and its cylinder.
#[test]
fn a_tool_of_its_own_assembly_is_calibrated_by_the_names_of_its_blocks() {
    let shots = |of: &str| {
        format!(
            "schema = \"nailnoise-calibration/1\"\n[condition]\n\
             a = {{ set = {{ \"supply.pressure\" = \"90 psig\" }}, outcome = \"drives\" }}\n[measured]\n\
             depth = {{ condition = \"a\", quantity = \"staple_depth\", value = \"11 mm\", shots = 5, scatter = \
             \"0.3 mm\", error = \"0.2 mm\", discrepancy = \"0.3 mm\" }}\n\
             peak = {{ condition = \"a\", quantity = \"peak_pressure\", of = \"{of}\", value = \"7.2 bar\", \
             scatter = \"1 %\", error = \"2 %\" }}\n"
        )
    };
    let folder = folder("calibrate/assembly");
    let text = "[cycle]\nassembly = \"stapler\"\n[cycle.outcome]\nmisfires = \"no strike\"\ndrives = \"strike\"\n";
    let design = over(&folder, "tool", text);
    fs::write(folder.join("shots.toml"), shots("cylinder")).unwrap();
    let refused = calibrate(&folder, &design, &["--draws", "64"]);
    assert_eq!(refused.status.code(), Some(2));
    let message = messages(&refused);
    assert!(
        message.contains("line 6") && message.contains("choose from handle, above, below"),
        "{message}"
    );

    fs::write(folder.join("shots.toml"), shots("above")).unwrap();
    let output = calibrate(&folder, &design, &["--draws", "64"]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        folder.join("out/calibration/calibration.json").exists(),
        "{text}\n{}",
        messages(&output)
    );
    let result = result(&folder);
    assert_eq!(measurement_outcomes(&result), [(true, "met"), (true, "met")]);
    let width = |row: &Value, key: &str| row[key][2].as_f64().unwrap() - row[key][0].as_f64().unwrap();
    let rows = result["figures"].as_array().unwrap();
    let depth = rows.iter().find(|own| own["name"] == "staple depth").unwrap();
    assert!(width(depth, "now") < 0.5 * width(depth, "before"), "{depth}");
    let calibrated = folder.join("out/calibration/calibrated.toml");
    let shot = json(
        &command(&["cycle", calibrated.to_str().unwrap(), "--json"])
            .output()
            .unwrap(),
    );
    assert_eq!(shot["outcome"], "drives");
}

#[test]
fn a_reading_beyond_the_outcome_names_the_limit_that_would_have_to_give() {
    let shots = "schema = \"nailnoise-calibration/1\"\n[condition]\n\
        a = { set = { \"supply.pressure\" = \"110 psig\" }, outcome = [\"drives\", \"underdriven\"] }\n\
        [measured]\ndepth = { condition = \"a\", quantity = \"head_depth\", value = \"20 mm\", error = \"1 mm\", \
        shots = 5, scatter = \"1 mm\", discrepancy = \"1 mm\" }\n";
    let (folder, design) = made("beyond", shots);
    let output = calibrate(&folder, &design, &["--draws", "64"]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    // Without the only reading, the draws are the candidates.
    assert_eq!(output.status.code(), Some(1), "{text}\n{}", messages(&output));
    let result = result(&folder);
    let conflict = &result["conflicts"][0];
    assert_eq!(measurement_outcomes(&result), [(false, "not_reached")]);
    assert!(conflict["nearest"].as_f64().unwrap() < 6e-3 && conflict["distance"].as_f64().unwrap() > 3.0);
    assert!(
        conflict["remedies"].to_string().contains("nail.overdrive_limit"),
        "{text}"
    );
    assert!(text.contains("NOT REACHED"), "{text}");
}

#[test]
fn a_study_of_the_calibrated_design_draws_the_rows_of_the_posterior() {
    let (folder, design) = made("study", &measurements("-17 mm", "-1 mm"));
    let one = calibrate(&folder, &design, &["--draws", "64", "--threads", "1"]);
    assert!(matches!(one.status.code(), Some(0 | 3)), "{}", messages(&one));
    let out = folder.join("out/calibration");
    let draws = fs::read(out.join("calibrated.draws")).unwrap();
    let two = command(&[
        "calibrate",
        &design,
        "--measured",
        "shots.toml",
        "--draws",
        "64",
        "--moves",
        "3",
    ])
    .current_dir(&folder)
    .args(["--out", "again", "--threads", "2", "--no-cache"])
    .output()
    .unwrap();
    assert_eq!(one.status.code(), two.status.code());
    assert!(
        draws == fs::read(folder.join("again/calibration/calibrated.draws")).unwrap(),
        "threads"
    );

    let joint: Value = serde_json::from_slice(&draws).unwrap();
    let column = |key: &str| {
        let names = joint["names"].as_array().unwrap();
        let place = names.iter().position(|name| name == key).unwrap();
        let rows = joint["rows"].as_array().unwrap().iter();
        rows.map(|row| row[place].as_f64().unwrap()).collect::<Vec<_>>()
    };
    let calibrated = out.join("calibrated.toml");
    let study = |arguments: &[&str]| {
        let own = ["study", calibrated.to_str().unwrap(), "--json", "--out", "out"];
        command(&[&own, arguments].concat())
            .current_dir(&folder)
            .env("NAILNOISE_CACHE", folder.join("cache"))
            .output()
            .unwrap()
    };
    let made = study(&["-n", "3"]);
    let studied = json(&made);
    let notes = studied["notes"].to_string();
    assert!(
        notes.contains("joint draws of a calibration with shots.toml"),
        "{notes}"
    );
    let mut drawn = csv::Reader::from_path(folder.join("out/study/draws.csv")).unwrap();
    let header = drawn.headers().unwrap().clone();
    let rows: Vec<csv::StringRecord> = drawn.records().collect::<Result<_, _>>().unwrap();
    for key in ["head_valve.lift", "piston.mass", "chambers.return_volume"] {
        let place = header.iter().position(|name| name.starts_with(key)).unwrap();
        let known = column(key);
        for row in &rows {
            let value: f64 = row[place].parse().unwrap();
            let is_row = known.iter().any(|own| (value / own - 1.0).abs() < 1e-5);
            assert!(is_row, "{key} = {value} is in no row");
        }
    }

    let refused = study(&["-n", "3", "--structures"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        messages(&refused).contains("leave out --structures"),
        "{}",
        messages(&refused)
    );
    let again = calibrate(&folder, calibrated.to_str().unwrap(), &["--draws", "64"]);
    assert_eq!(again.status.code(), Some(2));
    assert!(messages(&again).contains("calibrated already"), "{}", messages(&again));
    let outdated = String::from_utf8(draws)
        .unwrap()
        .replacen("\"code\":\"", "\"code\":\"0", 1);
    fs::write(out.join("calibrated.draws"), outdated).unwrap();
    let refused = study(&["-n", "3"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        messages(&refused).contains("calibrate the design again"),
        "{}",
        messages(&refused)
    );
    fs::remove_file(out.join("calibrated.draws")).unwrap();
    let missing = messages(&study(&["-n", "3"]));
    assert!(
        missing.contains("study.draws") && missing.contains("cannot be read"),
        "{missing}"
    );
}

/// A file of measured levels under the values of the design.
fn levels(measured: &str) -> String {
    format!("schema = \"nailnoise-calibration/1\"\n[condition]\nown = {{}}\n[measured]\n{measured}\n")
}

/// The row of the total in a result, and the width of an interval of it.
fn total(result: &Value) -> (&Value, impl Fn(&str) -> f64) {
    let rows = result["levels"].as_array().unwrap();
    let row = rows.iter().find(|own| own["output"] == "total").unwrap();
    let end = move |key: &str, place: usize| row[key][place].as_f64().unwrap();
    (row, move |key| end(key, 2) - end(key, 0))
}

#[test]
fn measured_levels_narrow_the_total_around_the_truth_unless_they_contradict_each_other() {
    let (folder, design) = made("levels", "");
    let truth = command(&["run", &design, "--json", "--out", "truth"])
        .current_dir(&folder)
        .env("NAILNOISE_CACHE", folder.join("cache"))
        .output()
        .unwrap();
    let truth = json(&truth);
    let number = |value: &Value| value.as_f64().unwrap();
    let own = number(&truth["total"]["lwa_db"]);
    let sensor = &truth["sensors"].as_array().unwrap()[0];
    let sound = format!(
        "sound = {{ condition = \"own\", quantity = \"level\", value = \"{own} dB\", error = \"0.7 dB\", shots = 5 }}\n"
    );
    let vibration = format!(
        "table = {{ condition = \"own\", quantity = \"rms_acceleration\", sensor = {}, value = \"{} g\", \
         error = \"5 %\", shots = 5 }}\n",
        sensor["name"],
        number(&sensor["rms_g"])
    );
    let made = |measured: &str, arguments: &[&str]| {
        fs::write(folder.join("shots.toml"), levels(measured)).unwrap();
        let arguments = [&["--draws", "64", "--levels", "64"], arguments].concat();
        let output = calibrate(&folder, &design, &arguments);
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let status = output.status.code().unwrap();
        assert!(matches!(status, 0 | 1 | 3), "{text}\n{}", messages(&output));
        (result(&folder), text, status)
    };

    let (narrow, text, _) = made(&format!("{sound}{vibration}"), &[]);
    let (row, width) = total(&narrow);
    assert!(width("now") < 0.6 * width("before"), "{text}");
    assert!(
        number(&row["now"][0]) < own && own < number(&row["now"][2]),
        "{own} {row}"
    );
    let work = &narrow["level_work"];
    let effective = number(&work["effective"]);
    assert!(effective > 4.0 && effective < number(&work["shots"]), "{work}");
    assert_eq!(
        narrow["converged"] == true,
        effective >= 32.0,
        "{work} {}",
        narrow["faults"]
    );
    assert!(
        text.contains(&format!("{effective:.0} effective shots of 64")),
        "{text}"
    );
    assert_eq!(measurement_outcomes(&narrow), [(true, "met"), (true, "met")], "{text}");

    let joint = fs::read(folder.join("out/calibration/calibrated.draws")).unwrap();
    let joint: Value = serde_json::from_slice(&joint).unwrap();
    let names = joint["names"].as_array().unwrap();
    let method = names.iter().position(|own| own == "method.workpiece").unwrap();
    let rows = joint["rows"].as_array().unwrap();
    assert!(rows.iter().all(|row| (0.0..1.0).contains(&number(&row[method]))) && rows.len() == 64);

    let (held_out, text, _) = made(&format!("{sound}{vibration}"), &["--hold-out", "sound"]);
    assert_eq!(
        measurement_outcomes(&held_out),
        [(false, "predicted"), (true, "met")],
        "{text}"
    );
    assert!(total(&held_out).1("now") > total(&narrow).1("now"), "{text}");

    // The loudest third octave of the same shot, which is only predicted.
    let loudest = truth["ranking"][0]["bands"].as_array().unwrap().iter();
    let loudest = loudest
        .filter(|own| !own["lwa_db"].is_null() && (63.0..=8000.0).contains(&number(&own["hz"])))
        .max_by(|a, b| number(&a["lwa_db"]).total_cmp(&number(&b["lwa_db"])))
        .unwrap();
    let source = truth["ranking"][0]["source"].as_str().unwrap();
    let band = format!(
        "band = {{ condition = \"own\", quantity = \"level\", source = \"{source}\", band = \"{} Hz\", \
         value = \"{} dB\", error = \"0.7 dB\", shots = 5 }}\n",
        loudest["hz"], loudest["lwa_db"]
    );
    let (predicted, text, _) = made(&format!("{sound}{vibration}{band}"), &["--hold-out", "band"]);
    let row = &predicted["measurements"][2];
    let ends = |key: &str| [0, 1].map(|end| number(&row[key][end]));
    let [before, now] = [ends("before"), ends("now")];
    let true_level = number(&loudest["lwa_db"]);
    assert!((now[0]..now[1]).contains(&true_level) && row["unit"] == "dB", "{text}");
    assert!(now[1] - now[0] < before[1] - before[0], "{text}");
    // A band has no more than the energy of its source.
    assert!(now[1] < number(&total(&predicted).0["now"][2]), "{text}");

    // Two levels of the same quantity that differ by 12 dB.
    let power = |name: &str, level: f64| {
        format!(
            "{name} = {{ condition = \"own\", quantity = \"level\", value = \"{level} dB\", error = \"0.5 dB\", \
             shots = 5 }}\n"
        )
    };
    let (contrary, text, status) = made(&[power("quiet", own - 6.0), power("loud", own + 6.0)].concat(), &[]);
    assert_eq!(status, 1, "{text}");
    let outcomes = measurement_outcomes(&contrary);
    assert!(
        outcomes.iter().all(|(counts, verdict)| !counts && *verdict != "met"),
        "{outcomes:?}"
    );
    // Nothing is sharpened through the conflict.
    let (row, _) = total(&contrary);
    assert_eq!(row["now"], row["before"], "{text}");
    assert!(text.contains("left out of all intervals"), "{text}");
}

/// Depths are read in mm or in, not in metres, and the file stays in SI units.
#[test]
fn readings_have_readable_units() {
    let (folder, design) = made("units", &measurements("-2 mm", "2 mm"));
    let text = |units: &str| {
        let output = calibrate(&folder, &design, &["--draws", "64", "--units", units]);
        String::from_utf8(output.stdout).unwrap()
    };
    let unit = |text: &str| -> Vec<String> {
        let line = text.lines().find(|line| line.trim().starts_with("high ")).unwrap();
        line.split_whitespace().map(str::to_owned).take(3).collect()
    };
    let (si, us) = (text("si"), text("us"));
    assert_eq!(unit(&si), ["high", "2", "mm"]);
    assert_eq!(unit(&us), ["high", "0.0787", "in"]);
    assert!(si.contains("head depth [mm]") && us.contains("head depth [in]"), "{us}");
    let reading = &result(&folder)["measurements"][1];
    assert_eq!(
        (reading["unit"].as_str(), reading["reading"][0].as_f64()),
        (Some("m"), Some(2e-3))
    );
}

/// Virtual tools are measured and calibrated; a check that was cut off goes on with its finished runs.
#[test]
fn a_check_places_the_truths_of_virtual_tools_and_goes_on_where_it_ended() {
    let (folder, design) = made("check", &measurements("-17 mm", "-1 mm"));
    let check = |runs: &str| calibrate(&folder, &design, &["--draws", "64", "--check", runs]);
    let output = check("2");
    let (text, said) = (String::from_utf8_lossy(&output.stdout).into_owned(), messages(&output));
    assert_eq!(output.status.code(), Some(0), "{text}\n{said}");
    assert!(
        said.contains("2 calibrations of 64 draws need about") && said.contains("million nailing cycles"),
        "{said}"
    );
    let out = folder.join("out/calibration");
    let read = || fs::read(out.join("check.json")).unwrap();
    let first = read();
    let result: Value = serde_json::from_slice(&first).unwrap();
    let number = |key: &str| result[key].as_u64().unwrap();
    assert_eq!(number("runs"), 2);
    assert_eq!(number("counted") + number("not_converged") + number("in_conflict"), 2);
    // Two runs are too few for a test.
    assert!(
        result["is_uniform"].is_null() && text.contains("too few for a test"),
        "{text}"
    );
    let rows = result["quantities"].as_array().unwrap();
    let kinds = |kind: &str| rows.iter().filter(|own| own["kind"] == kind).count();
    assert!(
        kinds("input") > 20 && kinds("reading") == 3 && kinds("figure") == 8,
        "{}",
        rows.len()
    );
    assert!(!out.join("calibration.json").exists());

    // One of the runs is lost, the other one is kept; both are those of before.
    let kept = out.join("check/run-0002.json");
    let written = || fs::metadata(&kept).unwrap().modified().unwrap();
    let before = written();
    fs::remove_file(out.join("check/run-0001.json")).unwrap();
    fs::remove_dir_all(folder.join("cache")).unwrap();
    assert_eq!(check("2").status.code(), Some(0));
    assert_eq!(read(), first);
    assert_eq!(written(), before);
    // The runs belong to these measurements.
    fs::write(folder.join("shots.toml"), measurements("-16 mm", "-1 mm")).unwrap();
    assert_eq!(check("1").status.code(), Some(0));
    assert!(read() != first);
}

/// A design for other boards draws the board from its own ranges, and the tool jointly.
#[test]
fn a_redrawn_board_keeps_the_ranges_of_the_design() {
    let (folder, design) = made("redrawn", &measurements("-25 mm", "1 mm"));
    let names = |arguments: &[&str]| {
        let output = calibrate(&folder, &design, &[&["--draws", "64"], arguments].concat());
        assert!(
            output.status.code().is_some_and(|code| code != 2),
            "{}",
            messages(&output)
        );
        let read = |name: &str| fs::read_to_string(folder.join("out/calibration").join(name)).unwrap();
        let joint: Value = serde_json::from_str(&read("calibrated.draws")).unwrap();
        let names = joint["names"].as_array().unwrap().iter();
        let names: Vec<String> = names.map(|name| name.as_str().unwrap().to_owned()).collect();
        assert!(
            joint["rows"]
                .as_array()
                .unwrap()
                .iter()
                .all(|row| row.as_array().unwrap().len() == names.len())
        );
        (names, read("calibrated.toml"))
    };
    let (all, _) = names(&[]);
    let (kept, design) = names(&["--redraw", "board"]);
    assert!(all.iter().any(|name| name == "wood.density"), "{all:?}");
    let board = |name: &String| name.starts_with("wood.") || name.starts_with("workpiece.");
    let left: Vec<&String> = kept.iter().filter(|name| board(name)).collect();
    assert!(
        left.iter().all(|name| name.ends_with("_scale")
            || name.ends_with("_term")
            || name.contains("unloading")
            || name.contains("friction_share")
            || name.contains("penetration_force")),
        "{left:?}"
    );
    assert_eq!(
        all.iter().filter(|name| !board(name)).count(),
        kept.iter().filter(|name| !board(name)).count()
    );
    assert!(
        !design.contains("wood.density") && !design.contains("workpiece."),
        "{design}"
    );
}
