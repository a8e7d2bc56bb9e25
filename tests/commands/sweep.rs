//! `nailnoise sweep`: levels over a grid, as a user computes them.

use std::fs;

use crate::common::{SMALL, command, folder, json, messages, over};
use crate::study::ANY;

/// The change from one point of a sweep to another is that of a comparison over the same draws.
#[test]
fn a_sweep_over_draws_is_a_comparison_over_draws() {
    let folder = folder("sweep/draws");
    let [first, second] =
        [5, 4].map(|holes| over(&folder, &holes.to_string(), &format!("exhaust.holes = {holes}\n{ANY}")));
    let run = |arguments: &[&str]| {
        let own = ["--draws", "2", "--json", "--out", "out"];
        let output = command(&[arguments, &own].concat())
            .current_dir(&folder)
            .env("NAILNOISE_CACHE", folder.join("cache"))
            .output();
        json(&output.unwrap())
    };
    let swept = run(&["sweep", &first, "--vary", "exhaust.holes=5,4"]);
    let compared = run(&["compare", &first, &second]);
    assert_eq!(swept["points"][1]["drawn"], compared["paired"][0]["changes"]);
}

/// The later values would replace the earlier ones in every point, under two columns of one name.
#[test]
fn a_key_that_is_varied_twice_is_refused() {
    let out = folder("sweep/twice");
    for other in ["exhaust.holes=4,6", " exhaust.holes =3,5", "exhaust.holes=3..5:3"] {
        let grid = [
            "--vary",
            "exhaust.holes=3,5",
            "--vary",
            "ambient.temperature=0 degC,20 degC",
            "--vary",
            other,
        ];
        let arguments = [&["sweep", SMALL, "--out", out.to_str().unwrap()], &grid[..]].concat();
        let output = command(&arguments).output().unwrap();
        let told = messages(&output);
        assert_eq!(output.status.code(), Some(2), "{told}");
        assert!(told.contains("`exhaust.holes` twice"), "{told}");
    }
    assert_eq!(fs::read_dir(out).unwrap().count(), 0);
}

/// The films of a point are those of a run with its values.
#[test]
fn fields_of_a_point_are_those_of_its_run() {
    let folder = folder("sweep/fields");
    let run = |arguments: &[&str]| {
        let output = command(arguments)
            .current_dir(&folder)
            .env("NAILNOISE_CACHE", folder.join("cache"))
            .output();
        json(&output.unwrap())
    };
    let design = over(&folder, "design", "");
    let grid = ["--vary", "ambient.temperature=0 degC,20 degC"];
    let swept = run(&[&["sweep", &design, "--fields", "--json", "--out", "out"], &grid[..]].concat());
    run(&[
        "run",
        &design,
        "--set",
        "ambient.temperature=0 degC",
        "--fields",
        "--json",
        "--out",
        "alone",
    ]);
    let name = swept["points"][0]["folder"].as_str().unwrap();
    assert_eq!(name, "ambient.temperature=0degC");
    let mut compared = 0;
    for entry in fs::read_dir(folder.join("alone/fields")).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            let of_point = folder
                .join("out/sweep")
                .join(name)
                .join("fields")
                .join(path.file_name().unwrap());
            assert!(
                fs::read(&path).unwrap() == fs::read(&of_point).unwrap(),
                "{}",
                of_point.display()
            );
            compared += 1;
        }
    }
    assert!(compared > 4, "{compared} files");
    let table = fs::read_to_string(folder.join("out/sweep/sweep.csv")).unwrap();
    assert!(
        table
            .lines()
            .all(|line| line.contains(",folder,") || line.contains("ambient.temperature="))
    );
}
