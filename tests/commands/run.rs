//! The command as a user meets it: tables, JSON, files, exit status, errors.

use crate::common::{SMALL, folder, json, messages, nailnoise};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

use nailnoise::output::OUTPUTS;
use serde_json::Value;

/// A run of the small design: its folder, its result, and its messages.
struct Small {
    out: PathBuf,
    result: Value,
    messages: String,
}

static SMALL_RUN: LazyLock<Small> = LazyLock::new(|| {
    let out = folder("run");
    let output = nailnoise(&["run", SMALL, "--json", "--out", out.to_str().unwrap()]);
    Small {
        out,
        result: json(&output),
        messages: messages(&output),
    }
});

fn ranked_levels() -> Vec<f64> {
    let ranking = SMALL_RUN.result["ranking"].as_array().unwrap();
    ranking.iter().map(|s| s["lwa_db"].as_f64().unwrap()).collect()
}

#[test]
fn a_result_names_its_schema_and_its_design() {
    let result = &SMALL_RUN.result;
    assert_eq!(result["schema"], "nailnoise-run/1");
    assert_eq!(result["design"]["name"], "small");
    assert_eq!(result["design"]["digest"].as_str().unwrap().len(), 64);
}

#[test]
fn run_ranks_three_sources_by_their_level() {
    let ranking = SMALL_RUN.result["ranking"].as_array().unwrap();
    let mut names: Vec<&str> = ranking.iter().map(|s| s["source"].as_str().unwrap()).collect();
    let levels = ranked_levels();
    assert!(levels.windows(2).all(|pair| pair[0] >= pair[1]), "{levels:?}");
    names.sort_unstable();
    assert_eq!(names, ["body", "exhaust", "workpiece"]);
}

#[test]
fn the_total_is_the_sum_of_the_sources() {
    let energy: f64 = ranked_levels().iter().map(|level| 10f64.powf(level / 10.0)).sum();
    let total = SMALL_RUN.result["total"]["lwa_db"].as_f64().unwrap();
    assert!((10.0 * energy.log10() - total).abs() < 1e-9);
}

#[test]
fn a_run_passes_its_checks() {
    let checks = SMALL_RUN.result["checks"].as_array().unwrap();
    assert!(checks.iter().all(|check| check["ok"] == true), "{checks:#?}");
}

#[test]
fn every_sensor_has_an_rms_value_and_a_higher_peak() {
    let sensors = SMALL_RUN.result["sensors"].as_array().unwrap();
    let named: Vec<&str> = sensors.iter().map(|s| s["name"].as_str().unwrap()).collect();
    assert_eq!(named, ["block_top", "handle", "table_centre", "table_edge"]);
    for sensor in sensors {
        let (rms, peak) = (sensor["rms_g"].as_f64().unwrap(), sensor["peak_g"].as_f64().unwrap());
        assert!(0.0 < rms && rms < peak && peak.is_finite(), "{sensor}");
    }
}

#[test]
fn every_event_has_its_time() {
    let events = &SMALL_RUN.result["events"];
    assert!((0..=18).all(|k| events[format!("t{k}")].is_f64()));
}

#[test]
fn run_writes_every_file() {
    let out = &SMALL_RUN.out;
    for file in [
        "result.json",
        "ranking.csv",
        "levels.csv",
        "intervals.csv",
        "power.csv",
        "events.csv",
        "histories.csv",
        "openings.csv",
        "fields/workpiece.vtu",
        "fields/worktable.vtu",
        "modes.csv",
        "motion.csv",
        "sensors.csv",
        "sensors-spectrum.csv",
        "sensors.uff",
    ] {
        assert!(out.join(file).metadata().unwrap().len() > 100, "{file}");
    }
}

/// The wood takes the momentum of the driver, whether as waves or at once.
#[test]
fn the_forces_of_an_elastic_blow_have_the_impulse_of_the_rigid_one() {
    let out = folder("run-elastic");
    let blow = [
        "run",
        SMALL,
        "--set",
        "model.blow=elastic",
        "--out",
        out.to_str().unwrap(),
    ];
    let output = nailnoise(&blow);
    assert!(output.status.success(), "{}", messages(&output));
    assert!(!SMALL_RUN.out.join("blow.csv").exists());
    let text = std::fs::read_to_string(out.join("blow.csv")).unwrap();
    let mut lines = text.lines();
    assert_eq!(
        lines.next().unwrap(),
        "time [s],nail: force on the wood [N],nail: force on the wood (rigid) [N],nail: force of the driver [N]"
    );
    let rows: Vec<Vec<f64>> = lines
        .map(|line| line.split(',').map(|field| field.parse().unwrap()).collect())
        .collect();
    let impulse = |column: usize| {
        let pairs = rows.windows(2).map(|pair| (pair[1][0] - pair[0][0]) * pair[1][column]);
        pairs.sum::<f64>()
    };
    let [elastic, rigid, driver] = [1, 2, 3].map(impulse);
    assert!((elastic / rigid - 1.0).abs() < 0.03, "{elastic} N s, rigid {rigid} N s");
    // The mass of the nail takes little.
    assert!((driver / rigid - 1.0).abs() < 0.1, "{driver} N s, rigid {rigid} N s");
}

#[test]
fn the_acceleration_of_a_band_is_its_velocity_times_a_frequency_of_the_band() {
    let text = std::fs::read_to_string(SMALL_RUN.out.join("motion.csv")).unwrap();
    let mut bodies = Vec::new();
    for row in text.lines().skip(1) {
        let fields: Vec<&str> = row.split(',').collect();
        let number = |field: usize| fields[field].parse::<f64>().unwrap();
        let [hz, kinetic, velocity, acceleration] = [1, 2, 3, 4].map(number);
        if kinetic == 0.0 {
            // A band above the range of the analysis.
            assert_eq!((velocity, acceleration), (0.0, 0.0), "{row}");
            continue;
        }
        // Half a third octave to both sides, and the rounding of the table.
        let ratio = acceleration / (std::f64::consts::TAU * hz * velocity);
        assert!((0.88..1.13).contains(&ratio), "{row}");
        bodies.push(fields[0].to_owned());
    }
    bodies.dedup();
    assert_eq!(bodies, ["workpiece", "worktable"]);
}

#[test]
fn the_result_has_the_motion_of_its_table() {
    let text = std::fs::read_to_string(SMALL_RUN.out.join("motion.csv")).unwrap();
    let result: serde_json::Value =
        serde_json::from_slice(&std::fs::read(SMALL_RUN.out.join("result.json")).unwrap()).unwrap();
    let mut rows = text.lines().skip(1);
    for body in result["motion"].as_array().unwrap() {
        for band in body["bands"].as_array().unwrap() {
            let number = |key: &str| format!("{:.4e}", band[key].as_f64().unwrap());
            let expected = [
                body["body"].as_str().unwrap().to_owned(),
                format!("{:.0}", band["hz"].as_f64().unwrap()),
                number("kinetic_energy_j_s"),
                number("rms_velocity_m_s"),
                number("rms_acceleration_m_s2"),
            ];
            assert_eq!(rows.next().unwrap(), expected.join(","));
        }
    }
    assert_eq!(rows.next(), None);
}

/// One list names the outputs of a run: it has every file, and the documentation has every output.
#[test]
fn every_file_of_a_run_is_in_the_list_of_outputs() {
    let documentation = std::fs::read_to_string("docs/output.md").unwrap();
    let belongs = |file: &str| {
        let of = |name: &str| match name.split_once('*') {
            Some((before, behind)) => file.starts_with(before) && file.ends_with(behind),
            None => file == name,
        };
        OUTPUTS.iter().filter(|output| of(output.name)).count() == 1
    };
    let mut folders = vec![SMALL_RUN.out.clone()];
    let mut files = 0;
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let name = path.strip_prefix(&SMALL_RUN.out).unwrap();
            assert!(belongs(name.to_str().unwrap()), "{}", name.display());
            files += 1;
        }
    }
    assert!(files > 40, "{files}");
    for output in OUTPUTS {
        let (name, _) = output.name.split_once('*').unwrap_or((output.name, ""));
        assert!(documentation.contains(&format!("`{name}")), "{name}");
    }
}

/// Names of columns are an interface: neither the method nor the order of the levels changes them.
#[test]
fn headers_are_those_of_the_documentation() {
    let documentation = std::fs::read_to_string("docs/output.md").unwrap();
    for file in [
        "ranking",
        "levels",
        "intervals",
        "power",
        "events",
        "log",
        "modes",
        "microphones",
        "microphones-bands",
    ] {
        let text = std::fs::read_to_string(SMALL_RUN.out.join(format!("{file}.csv"))).unwrap();
        let header = text.lines().next().unwrap();
        assert!(documentation.contains(&format!("{header}\n")), "{file}.csv: {header}");
    }
}

/// The default output of a run is small, and all of it is there on request.
#[test]
fn films_and_whole_histories_are_written_where_they_are_asked_for() {
    let out = folder("exports");
    let run = |more: &[&str]| {
        let mut arguments = vec![
            "run",
            "tests/data/small.toml",
            "--out",
            out.to_str().unwrap(),
            "--quiet",
        ];
        arguments.extend(more);
        assert!(nailnoise(&arguments).status.success());
    };
    let rows = |file: &str| std::fs::read_to_string(out.join(file)).unwrap().lines().count() - 1;
    let films = [
        "fields/workpiece-shot.pvd",
        "fields/worktable-shot/000.vtu",
        "fields/worktable-bands.pvd",
        "fields/workpiece-film.pvd",
        "fields/workpiece-film.vtkhdf",
    ];
    run(&[]);
    assert!(films.iter().all(|film| !out.join(film).exists()));
    let few = ["histories.csv", "openings.csv", "sensors.csv"].map(rows);
    run(&["--histories", "--fields"]);
    assert!(films.iter().all(|film| out.join(film).exists()));
    for (few, all) in few
        .into_iter()
        .zip(["histories.csv", "openings.csv", "sensors.csv"].map(rows))
    {
        assert!(all > 2 * few, "{few} of {all}");
    }
    // The films of another shot do not stay with a new one.
    run(&["--set", "supply.pressure=756 kPa"]);
    assert!(films.iter().all(|film| !out.join(film).exists()));
}

/// The head of the report is of no concern to any result.
#[test]
fn the_head_of_the_report_changes_the_page_alone() {
    let out = folder("head");
    let output = nailnoise(&[
        "run",
        "tests/data/small.toml",
        "--json",
        "--set",
        "report.title=A <new> nailer",
        "--set",
        "report.client=Tools & Co",
        "--out",
        out.to_str().unwrap(),
    ]);
    let mut result = json(&output);
    let mut expected = SMALL_RUN.result.clone();
    (result["timing"], expected["timing"]) = (Value::Null, Value::Null);
    assert_eq!(result, expected);
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("<h1>A &lt;new&gt; nailer</h1>") && page.contains("for Tools &amp; Co"));
}

#[test]
fn the_written_result_equals_the_printed_one() {
    let stored = std::fs::read(SMALL_RUN.out.join("result.json")).unwrap();
    let stored: Value = serde_json::from_slice(&stored).unwrap();
    assert_eq!(stored, SMALL_RUN.result);
}

#[test]
fn progress_is_shown() {
    assert!(!SMALL_RUN.messages.is_empty());
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let run = |threads: &str| {
        let out = folder(&format!("threads-{threads}"));
        let mut result = json(&nailnoise(&[
            "run",
            "tests/data/small.toml",
            "--json",
            "--threads",
            threads,
            "--no-cache",
            "--out",
            out.to_str().unwrap(),
        ]));
        result["timing"] = Value::Null;
        result
    };
    assert_eq!(run("1"), run("2"));
}

/// The second run takes the modes from the first; nothing but the time it took may differ.
#[test]
fn results_do_not_depend_on_the_cache() {
    let cache = folder("own-cache");
    let run = |extra: &[&str]| {
        let out = folder("cached");
        let arguments = ["run", "tests/data/small.toml", "--json", "--out", out.to_str().unwrap()];
        let output = Command::new(env!("CARGO_BIN_EXE_nailnoise"))
            .args(arguments.iter().chain(extra))
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .env("NO_COLOR", "1")
            .env("NAILNOISE_CACHE", &cache)
            .output()
            .unwrap();
        let mut result = json(&output);
        result["timing"] = Value::Null;
        (result, String::from_utf8(output.stderr).unwrap())
    };
    let entries = || std::fs::read_dir(&cache).map_or(0, Iterator::count);
    let (anew, _) = run(&["--no-cache"]);
    assert_eq!(entries(), 0);
    assert_eq!(run(&[]).0, anew);
    assert_eq!(
        entries(),
        22,
        "requirements, order of elimination, modes, body and sensor modes of workpiece and worktable each; end, motion \
         in bands, two sources, radiation efficiencies, sensors, checks, pictures and fields of the bodies, checksums \
         of their files, files of the run"
    );
    assert_eq!(run(&[]).0, anew);
    for entry in std::fs::read_dir(&cache).unwrap() {
        let path = entry.unwrap().path();
        let mut bytes = std::fs::read(&path).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        std::fs::write(&path, bytes).unwrap();
    }
    let (repaired, notes) = run(&[]);
    assert_eq!(repaired, anew);
    assert_eq!(notes.matches("computed anew").count(), 22, "{notes}");
    assert_eq!(run(&[]).1.matches("computed anew").count(), 0);
}

#[test]
fn the_schema_describes_the_keys() {
    let schema = json(&nailnoise(&["schema"]));
    let mass = &schema["properties"]["piston"]["properties"]["mass"];
    assert!(mass["description"].as_str().unwrap().contains("kg"), "{mass}");
}

#[test]
fn completions_are_written_for_a_shell() {
    let bash = nailnoise(&["completions", "bash"]);
    assert!(String::from_utf8(bash.stdout).unwrap().contains("_nailnoise"));
}

#[test]
fn tables_are_printed_without_json() {
    let out = folder("table");
    let output = nailnoise(&["run", "tests/data/small.toml", "--out", out.to_str().unwrap()]);
    let text = String::from_utf8(output.stdout).unwrap();
    for word in [
        "workpiece",
        "exhaust",
        "body",
        "total",
        "rigid motion only",
        "ERP",
        "checks ok",
    ] {
        assert!(text.contains(word), "{word} is missing in\n{text}");
    }
}

#[test]
fn a_muffler_lowers_the_exhaust_slows_the_blow_down_and_is_drawn() {
    let folder = folder("muffler");
    std::fs::create_dir_all(&folder).unwrap();
    let run = |name: &str, keys: &str| {
        let design = folder.join(format!("{name}.toml"));
        let base = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/small.toml");
        let text = format!(
            "base = \"{}\"\nanalysis.exhaust_max_frequency = \"6.5 kHz\"\n{keys}",
            base.display()
        );
        std::fs::write(&design, text).unwrap();
        let out = folder.join(name);
        let arguments = [
            design.to_str().unwrap(),
            "--json",
            "--figures",
            "--out",
            out.to_str().unwrap(),
        ];
        let result = json(&nailnoise(&[&["run"], &arguments[..]].concat()));
        for figure in ["bands", "exhaust", "intervals", "power"] {
            let svg = std::fs::read_to_string(out.join(format!("figures/{figure}.svg"))).unwrap();
            assert!(svg.starts_with("<svg") && !svg.contains("NaN"), "{figure}");
        }
        let sources = result["ranking"].as_array().unwrap();
        let exhaust = sources
            .iter()
            .find(|source| source["source"] == "exhaust")
            .unwrap()
            .clone();
        let event = |name: &str| result["events"][name].as_f64().unwrap();
        (exhaust, event("t17") - event("t13"))
    };
    let (open, quick) = run("open", "");
    let (chamber, slow) = run("chamber", "exhaust.muffler.kind = \"chamber\"\n");
    // Nothing lost but by back pressure, then 20 dB more.
    let measured = "exhaust.muffler.kind = \"insertion_loss\"\nexhaust.muffler.octaves.1000 = 20\n";
    let (loss, _) = run("loss", measured);
    assert!(slow > 1.05 * quick, "blow-down of {quick} s free and {slow} s muffled");
    let part = |source: &Value, name: &str| {
        let parts = source["components"].as_array().unwrap();
        parts.iter().find(|part| part["name"] == name).cloned()
    };
    let level = |value: &Value| value["lwa_db"].as_f64().unwrap();
    assert!(level(&part(&chamber, "mixing").unwrap()) < level(&part(&open, "mixing").unwrap()) - 10.0);
    assert!(part(&chamber, "muffler outlet").is_some() && part(&open, "muffler outlet").is_none());
    let band = |source: &Value, hz: f64| {
        let mixing = part(source, "mixing").unwrap();
        let bands = mixing["bands"].as_array().unwrap();
        level(bands.iter().find(|band| band["hz"].as_f64() == Some(hz)).unwrap())
    };
    let drop = |hz: f64| band(&open, hz) - band(&loss, hz);
    assert!(
        (drop(1000.0) - drop(400.0) - 20.0).abs() < 1.0,
        "{} {}",
        drop(1000.0),
        drop(400.0)
    );
}

#[test]
fn cycle_prints_outcome_events_and_work() {
    let out = folder("cycle");
    let result = json(&nailnoise(&[
        "cycle",
        "tests/data/small.toml",
        "--json",
        "--out",
        out.to_str().unwrap(),
    ]));
    assert_eq!(result["outcome"], "drives");
    assert!(result["work"]["steps"].as_u64().unwrap() > 100);
    assert!(result["summary"]["exhaust_mass"].as_f64().unwrap() > 1e-3);
    let header = std::fs::read_to_string(out.join("histories.csv")).unwrap();
    assert!(header.starts_with("time [s],piston_position [m],"));
}

#[test]
fn modes_of_both_bodies_are_counted() {
    for (body, rigid) in [("workpiece", 6), ("worktable", 0)] {
        let out = folder(&format!("modes-{body}"));
        let result = json(&nailnoise(&[
            "modes",
            "tests/data/small.toml",
            "--body",
            body,
            "--json",
            "--out",
            out.to_str().unwrap(),
        ]));
        let modes = result["modes"].as_array().unwrap();
        assert_eq!(result["sturm"]["count"].as_u64().unwrap() as usize, modes.len());
        assert_eq!(modes.iter().filter(|mode| mode["rigid"] == true).count(), rigid);
        assert!(out.join("modes").join(body).join("modes.pvd").exists());
    }
}

#[test]
fn wrong_input_ends_with_status_2_and_a_remedy() {
    for (name, arguments, words) in [
        (
            "missing file",
            vec!["run", "designs/none.toml"],
            vec!["designs/none.toml"],
        ),
        ("no design", vec!["run"], vec!["<DESIGN>"]),
        (
            "no such body",
            vec!["modes", "designs/n80cb-sandbox.toml", "--body", "worktable"],
            vec!["sandbox", "--body workpiece"],
        ),
    ] {
        let output = nailnoise(&arguments);
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{name}: {text}");
        assert!(words.iter().all(|word| text.contains(word)), "{name}: {text}");
        assert!(
            text.lines().count() < 25 && !text.contains("panicked"),
            "{name}: {text}"
        );
    }
}

#[test]
fn every_bad_design_ends_with_status_2_on_one_screen() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/bad");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        let output = nailnoise(&["cycle", path.to_str().unwrap()]);
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{}: {text}", path.display());
        assert!(
            text.contains("help:") && text.lines().count() <= 24,
            "{}: {text}",
            path.display()
        );
        assert!(output.stdout.is_empty());
        count += 1;
    }
    assert!(count >= 20);
}

#[test]
fn a_sensor_off_its_body_is_refused_with_its_place() {
    let folder = folder("sensor");
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("off.toml");
    let base = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/small.toml");
    std::fs::write(&file, format!("base = {base:?}\nsensors.block_top.x = \"250 mm\"\n")).unwrap();
    let output = nailnoise(&["run", file.to_str().unwrap(), "--out", folder.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
    let text = String::from_utf8_lossy(&output.stderr)
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ");
    for part in ["`block_top`", "46.8 mm outside the workpiece", "off.toml:2:", "origin"] {
        assert!(text.contains(part), "no {part} in: {text}");
    }
}
