//! `nailnoise optimise`: designs as a user finds and runs them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::Duration;

use serde_json::Value;

use crate::common::{SMALL, command, folder, json, messages};

/// A small search over a count, a range and choices.
const SEARCH: [&str; 11] = [
    "--vary",
    "exhaust.holes=3,9,12",
    "--vary",
    "exhaust.hole_diameter=3mm..8mm",
    "--vary",
    "supply.pressure=80psig..110psig",
    "--subject-to",
    "outcome == drives",
    "--subject-to",
    "penetration >= 82 mm",
    "--json",
];

fn optimise(folder: &Path, cache: &str, more: &[&str]) -> Command {
    let mut command = command(&[&["optimise", SMALL], &SEARCH[..], more].concat());
    command.env("NAILNOISE_CACHE", folder.join(cache));
    command.arg("--out").arg(folder.join("found"));
    command
}

/// The candidates, without the parts that depend on the folder.
fn trials(output: &Output) -> Value {
    json(output)["trials"].clone()
}

/// A design that was found can be run as it was written, and has the level that was stated.
#[test]
fn the_best_design_runs_and_is_the_quietest_that_meets_the_constraint() {
    let folder = folder("optimise/best");
    let output = optimise(&folder, "cache", &["--trials", "12"]).output().unwrap();
    let found = json(&output);
    let all = found["trials"].as_array().unwrap();
    let best = &all[found["front"][0].as_u64().unwrap() as usize];
    for own in all.iter().filter(|own| own["feasible"] == true) {
        assert!(own["figures"]["penetration"].as_f64().unwrap() >= 0.082);
        assert!(own["total_db"].as_f64().unwrap() >= best["total_db"].as_f64().unwrap());
    }
    assert_eq!(all.iter().filter(|own| own["levels"].is_object()).count(), 12);
    let files = found["files"].as_array().unwrap();
    assert_eq!(files.len(), 1, "one objective has one best design");
    let file = PathBuf::from(files[0].as_str().unwrap());
    let text = fs::read_to_string(&file).unwrap();
    let holes = best["values"][0].as_str().unwrap();
    assert!(text.contains(&format!("exhaust.holes = {holes}\n")), "{text}");
    assert!(text.starts_with("base = \"../") && !text.contains("\"/"), "{text}");
    let run = command(&["run", file.to_str().unwrap(), "--json", "--out"])
        .arg(folder.join("run"))
        .env("NAILNOISE_CACHE", folder.join("cache"))
        .output();
    let level = json(&run.unwrap())["total"]["lwa_db"].as_f64().unwrap();
    assert!((level - best["total_db"].as_f64().unwrap()).abs() < 1e-9);
    let page = fs::read_to_string(folder.join("found/optimise.html")).unwrap();
    assert!(page.contains("the design itself") && !page.contains("http://"));
}

/// A killed search goes on where it was, and threads decide nothing.
#[test]
#[cfg(unix)]
fn a_killed_search_resumes_and_threads_change_nothing() {
    let folder = folder("optimise/resumed");
    let whole = optimise(&folder, "whole", &["--trials", "10", "--threads", "1"])
        .output()
        .unwrap();
    let mut killed = optimise(&folder, "killed", &["--trials", "10", "--quiet"])
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_secs(4));
    killed.kill().unwrap();
    killed.wait().unwrap();
    let resumed = optimise(&folder, "killed", &["--trials", "10", "--threads", "2"])
        .output()
        .unwrap();
    assert_eq!(trials(&whole), trials(&resumed));
    let other = optimise(&folder, "whole", &["--trials", "10", "--seed", "2"])
        .output()
        .unwrap();
    assert_ne!(trials(&whole), trials(&other));
}

#[test]
fn no_design_of_a_front_betters_another_and_each_has_a_file() {
    let folder = folder("optimise/front");
    let output = optimise(
        &folder,
        "cache",
        &["--trials", "14", "--pareto=-drive_energy", "--batch", "3"],
    )
    .output();
    let found = json(&output.unwrap());
    let of = |place: &Value| {
        let own = &found["trials"][place.as_u64().unwrap() as usize];
        [
            own["total_db"].as_f64().unwrap(),
            own["figures"]["drive_energy"].as_f64().unwrap(),
        ]
    };
    let front: Vec<[f64; 2]> = found["front"].as_array().unwrap().iter().map(of).collect();
    assert!(
        front.len() > 1
            && front
                .windows(2)
                .all(|two| two[0][0] < two[1][0] && two[0][1] < two[1][1]),
        "{front:?}"
    );
    let files = found["files"].as_array().unwrap();
    assert!(files.len() == front.len() && files.iter().all(|file| Path::new(file.as_str().unwrap()).exists()));
}

#[test]
fn a_search_that_cannot_be_says_why() {
    let folder = folder("optimise/refused");
    let ends = |arguments: &[&str], status: i32, told: &str| {
        let output = command(&[&["optimise", SMALL, "--trials", "2"], arguments].concat())
            .env("NAILNOISE_CACHE", folder.join("cache"))
            .arg("--out")
            .arg(folder.join("found"))
            .output()
            .unwrap();
        let text = format!("{}{}", String::from_utf8_lossy(&output.stdout), messages(&output));
        assert_eq!(output.status.code(), Some(status), "{arguments:?}: {text}");
        assert!(text.contains(told), "{arguments:?}: {text}");
    };
    let holes = "exhaust.holes=3..9";
    ends(&["--vary", "exhaust.hole=3..9"], 2, "exhaust.hole");
    ends(&["--vary", "exhaust.holes"], 2, "does not vary a key");
    ends(&["--vary", holes, "--vary", holes], 2, "twice");
    ends(&["--vary", holes, "--subject-to", "depth >= 3"], 2, "no figure `depth`");
    ends(&["--vary", holes, "--minimise", "noise"], 2, "no figure `noise`");
    ends(
        &["--vary", holes, "--subject-to", "penetration >= 3 m"],
        1,
        "loosen a constraint",
    );
}

/// A constraint on a figure does not lift the requirement that the shot drives; one on the outcome replaces it.
#[test]
fn a_shot_must_drive_unless_a_constraint_names_another_outcome() {
    let folder = folder("optimise/outcome");
    let outcomes = |constraint: &str| {
        let vary = "supply.pressure=40psig..110psig";
        let mut command = command(&["optimise", SMALL, "--vary", vary, "--trials", "4", "--json"]);
        command
            .args(["--subject-to", constraint])
            .arg("--out")
            .arg(folder.join("found"));
        let found = json(&command.env("NAILNOISE_CACHE", folder.join("cache")).output().unwrap());
        let feasible = found["trials"]
            .as_array()
            .unwrap()
            .iter()
            .filter(|own| own["feasible"] == true);
        let outcomes: Vec<String> = feasible
            .map(|own| own["outcome"].as_str().unwrap().to_owned())
            .collect();
        outcomes
    };
    let driven = outcomes("penetration >= 1 mm");
    assert!(
        !driven.is_empty() && driven.iter().all(|own| own == "drives"),
        "{driven:?}"
    );
    let short = outcomes("outcome == underdriven");
    assert!(
        !short.is_empty() && short.iter().all(|own| own == "underdriven"),
        "{short:?}"
    );
}
