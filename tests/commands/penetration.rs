//! `nailnoise penetration`: published check values, validity, files.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

fn prf(name: &str, arguments: &[&str]) -> (Output, PathBuf) {
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("prf").join(name);
    let _ = std::fs::remove_dir_all(&out);
    let output = Command::new(env!("CARGO_BIN_EXE_nailnoise"))
        .args(["prf", "law"])
        .args(arguments)
        .args(["--out", out.to_str().unwrap()])
        .env("NO_COLOR", "1")
        .env("NAILNOISE_CACHE", concat!(env!("CARGO_TARGET_TMPDIR"), "/modes"))
        .output()
        .unwrap();
    (output, out)
}

fn text(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// Force at x = 0.1, 0.5, 1.0 \[N\] and work over the full length \[J\], as published to the last digit.
const CHECKS: [(&str, &str, &str, [&str; 4]); 11] = [
    (
        "smooth",
        "poplar plywood",
        "6d",
        ["344.78", "685.23", "1193.13", "34.548"],
    ),
    (
        "smooth",
        "poplar plywood",
        "12d",
        ["688.78", "1291.97", "2172.20", "105.564"],
    ),
    (
        "smooth",
        "Douglas-fir plywood",
        "8d",
        ["556.32", "1074.90", "1840.32", "67.650"],
    ),
    (
        "annular",
        "poplar plywood",
        "4d",
        ["286.92", "581.66", "811.13", "21.415"],
    ),
    (
        "annular",
        "poplar plywood",
        "10d",
        ["618.25", "1226.18", "1696.36", "90.263"],
    ),
    (
        "helical",
        "poplar plywood",
        "10d",
        ["605.47", "1493.31", "1908.26", "101.966"],
    ),
    (
        "general",
        "poplar plywood",
        "10d",
        ["582.24", "1238.97", "1785.66", "89.410"],
    ),
    (
        "reduced5",
        "poplar plywood",
        "8d",
        ["397.75", "988.15", "1341.26", "61.012"],
    ),
    ("solid_wood", "pine", "12d", ["559.31", "1240.62", "1802.41", "96.145"]),
    (
        "solid_wood",
        "Douglas-fir",
        "12d",
        ["869.07", "1897.03", "2740.63", "147.049"],
    ),
    // Names need neither case nor hyphens.
    ("Solid-Wood", "PINE", "12D", ["559.31", "1240.62", "1802.41", "96.145"]),
];

#[test]
fn published_forces_and_work_are_printed_to_their_digits() {
    for (index, (law, wood, nail, expected)) in CHECKS.into_iter().enumerate() {
        let (output, _) = prf(
            &format!("check{index}"),
            &["--law", law, "--wood", wood, "--nail", nail],
        );
        let text = text(&output);
        let cell = |first: &str, column: usize| {
            let line = text.lines().find(|line| line.split_whitespace().next() == Some(first));
            line.and_then(|line| line.split_whitespace().nth(column))
                .unwrap_or_default()
                .to_owned()
        };
        let law = law.to_lowercase().replace('-', "_");
        let found = [cell("0.1", 1), cell("0.5", 1), cell("1.0", 1), cell(&law, 3)];
        assert_eq!(found, expected, "{law}, {wood}, {nail}\n{text}");
    }
}

#[test]
fn laws_stand_side_by_side_with_their_fit_and_files() {
    let arguments = [
        "--law",
        "smooth,annular,helical",
        "--wood",
        "poplar plywood",
        "--nail",
        "12d",
        "--json",
    ];
    let (output, out) = prf("compare", &arguments);
    let result: Value = serde_json::from_str(&text(&output)).unwrap();
    let curves = result["curves"].as_array().unwrap();
    let labels: Vec<&str> = curves.iter().map(|curve| curve["label"].as_str().unwrap()).collect();
    assert_eq!(labels, ["smooth", "annular", "helical"]);
    let fits: Vec<f64> = curves
        .iter()
        .map(|curve| curve["fit"]["r_squared"].as_f64().unwrap())
        .collect();
    assert_eq!(fits, [0.9488, 0.9074, 0.9410]);
    assert_eq!(curves[2]["diameter"], 3.556e-3, "a helical shank has its own diameter");
    for curve in curves {
        let rows = curve["rows"].as_array().unwrap();
        let works: Vec<f64> = rows.iter().map(|row| row["work"].as_f64().unwrap()).collect();
        assert!(works.windows(2).all(|pair| pair[0] < pair[1]));
        assert!((works[9] - curve["work"].as_f64().unwrap()).abs() < 1e-9);
    }
    let svg = std::fs::read_to_string(out.join("penetration.svg")).unwrap();
    assert!(
        [
            "smooth",
            "annular",
            "helical",
            "12d, poplar plywood",
            "Depth of the nail"
        ]
        .iter()
        .all(|w| svg.contains(w))
    );
    let csv = std::fs::read_to_string(out.join("penetration.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + 3 * 201);
    assert!(csv.contains("smooth,poplar plywood,12d,0.0082550,688.78"), "{csv}");
}

#[test]
fn chosen_depths_and_speeds_are_used() {
    let arguments = [
        "--law",
        "smooth",
        "--wood",
        "pine",
        "--nail",
        "6d",
        "--speed",
        "20 mm/min",
        "--depth",
    ];
    let evaluate = |depths: &str| -> Value {
        let mut arguments = arguments.to_vec();
        arguments.extend([depths, "--json"]);
        serde_json::from_str(&text(&prf("depth", &arguments).0)).unwrap()
    };
    let slow = evaluate("10 mm,0.0508");
    assert!((slow["speed"].as_f64().unwrap() - 20e-3 / 60.0).abs() < 1e-15);
    let rows = slow["curves"][0]["rows"].as_array().unwrap();
    assert_eq!([&rows[0]["depth"], &rows[1]["depth"]], [0.01, 0.0508]);
    // C8 is positive for a smooth shank: the slower, the weaker.
    let fast: Value = serde_json::from_str(&text(
        &prf("fast", &["--law", "smooth", "--wood", "pine", "--nail", "6d", "--json"]).0,
    ))
    .unwrap();
    assert!(rows[1]["force"].as_f64().unwrap() < fast["curves"][0]["rows"][9]["force"].as_f64().unwrap());
    assert!(slow["notes"][0].as_str().unwrap().contains("fitted to plywood"));
}

#[test]
fn own_laws_stand_beside_published_ones() {
    let table = Path::new(env!("CARGO_TARGET_TMPDIR")).join("measured.csv");
    // A straight line from 200 N to 1700 N, and a point more than a nail of 6d needs.
    std::fs::write(&table, "depth_m,force_n\n0,200\n0.025,950\n0.05,1700\n0.06,1700\n").unwrap();
    let table = table.to_str().unwrap();
    let arguments = ["--law", "smooth", "--wood", "pine", "--nail", "6d"];
    let own = ["--constant", "1.2 kN", "--table", table, "--depth", "10 mm,20 mm"];
    let (output, out) = prf("own", &[&arguments[..], &own[..], &["--json"]].concat());
    let result: Value = serde_json::from_str(&text(&output)).unwrap();
    let curves = result["curves"].as_array().unwrap();
    let labels: Vec<&str> = curves.iter().map(|curve| curve["label"].as_str().unwrap()).collect();
    assert_eq!(labels, ["smooth", "constant 1200 N", "measured.csv"]);
    let row = |curve: usize, row: usize, name: &str| curves[curve]["rows"][row][name].as_f64().unwrap();
    assert!((row(1, 0, "force") - 1200.0).abs() < 1e-9 && (row(1, 1, "work") - 24.0).abs() < 1e-6);
    assert!((row(2, 0, "force") - 500.0).abs() < 1e-9 && (row(2, 0, "work") - 3.5).abs() < 1e-6);
    assert_eq!([&curves[1]["wood"], &curves[2]["fit"]], [&Value::Null; 2]);
    let svg = std::fs::read_to_string(out.join("penetration.svg")).unwrap();
    assert!(labels.iter().all(|label| svg.contains(label)));
    let csv = std::fs::read_to_string(out.join("penetration.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + 3 * 201);
    assert!(csv.lines().all(|line| line.split(',').count() == 8), "{csv}");
    // Alone they need no wood, and have no speed and no fit.
    let text = text(&prf("alone", &["--nail", "6d", "--constant", "900 N", "--table", table]).0);
    assert!(
        text.contains("900.00") && !text.contains("mm/min") && !text.contains("SEE and MAE"),
        "{text}"
    );
}

/// A table shorter than a nail of 6d.
fn short() -> &'static str {
    file("short.csv", "0,100\n0.03,400\n")
}

fn unsorted() -> &'static str {
    file("unsorted.csv", "0,100\n0.06,400\n0.05,300\n")
}

fn file(name: &str, text: &str) -> &'static str {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned().leak()
}

#[test]
fn unpublished_or_invalid_values_are_refused_by_name() {
    let base = |law: &'static str, nail: &'static str| vec!["--law", law, "--wood", "pine", "--nail", nail];
    let with = |mut arguments: Vec<&'static str>, more: [&'static str; 2]| {
        arguments.extend(more);
        arguments
    };
    for (arguments, words) in [
        (
            base("smoth", "6d"),
            vec!["no law \"smoth\"", "is it \"smooth\"?", "solid_wood"],
        ),
        (base("smooth", "7d"), vec!["no nail \"7d\"", "16d"]),
        (
            vec!["--law", "smooth", "--wood", "oak", "--nail", "6d"],
            vec!["no wood \"oak\"", "Douglas-fir plywood"],
        ),
        (
            base("helical", "6d"),
            vec!["helical", "6d was not tested", "8d, 10d, 12d, 16d"],
        ),
        (
            with(base("smooth", "6d"), ["--speed", "25 m/s"]),
            vec!["penetration speed 25 m/s", "20 to 500 mm/min"],
        ),
        (
            with(base("smooth", "6d"), ["--depth", "60 mm"]),
            vec!["depth 0.06 m", "length 0.0508 m"],
        ),
        (
            with(base("smooth", "6d"), ["--speed", "3 Pa"]),
            vec!["a pressure", "a velocity"],
        ),
        (vec!["--law", "smooth"], vec!["--wood", "--nail"]),
        (vec!["--nail", "6d"], vec!["--law"]),
        (vec!["--nail", "6d", "--constant=-1 N"], vec!["-1 N", "0 or more"]),
        (
            vec!["--nail", "6d", "--table", "none.csv"],
            vec!["cannot read none.csv"],
        ),
        (
            vec!["--nail", "6d", "--table", short()],
            vec!["beyond the range", "0.0508 m", "0 to 0.03 m"],
        ),
        (
            vec!["--nail", "6d", "--table", unsorted()],
            vec!["no penetration law", "sort the points by depth"],
        ),
    ] {
        let (output, out) = prf("refused", &arguments);
        let error = String::from_utf8(output.stderr).unwrap();
        // The printer may break a line anywhere between words.
        let error = error
            .split_whitespace()
            .filter(|word| *word != "|")
            .collect::<Vec<_>>()
            .join(" ");
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(words.iter().all(|word| error.contains(word)), "{arguments:?}: {error}");
        assert!(!out.exists(), "{arguments:?} leaves files");
    }
}

#[test]
fn the_list_holds_every_law_wood_and_nail() {
    let (output, out) = prf("list", &["--list"]);
    let text = text(&output);
    for word in [
        "smooth",
        "reduced6",
        "solid_wood",
        "Canadian softwood plywood",
        "371.77",
        "3d",
        "16d",
        "88.900",
        "0.01408",
    ] {
        assert!(text.contains(word), "{word}\n{text}");
    }
    assert!(!out.exists());
    let json: Value = serde_json::from_str(&self::text(&prf("list", &["--list", "--json"]).0)).unwrap();
    assert_eq!(
        ["laws", "woods", "nails"].map(|list| json[list].as_array().unwrap().len()),
        [11, 6, 7]
    );
}
