//! Quantities in the units of a workshop in the United States: terminal, pages, charts; files for machines in SI.

use std::fs;

use crate::common::{SMALL, command, folder, json, messages, nailnoise};

/// Standard output of a command.
fn printed(arguments: &[&str]) -> String {
    let output = nailnoise(arguments);
    assert!(output.status.success(), "{}", messages(&output));
    String::from_utf8(output.stdout).unwrap()
}

/// The line of a text that begins with these words.
fn line<'t>(text: &'t str, begin: &str) -> &'t str {
    let found = text.lines().map(str::trim).find(|line| line.starts_with(begin));
    found.unwrap_or_else(|| panic!("no line \"{begin}\" in\n{text}"))
}

/// The numbers of a text.
fn numbers(text: &str) -> Vec<f64> {
    let words = text.split(|letter: char| !(letter.is_ascii_digit() || letter == '.'));
    words
        .filter_map(|word| word.trim_end_matches('.').parse().ok())
        .collect()
}

#[test]
fn a_run_has_the_units_that_are_asked_for_and_the_same_result() {
    let out = folder("units-run");
    let of = |units: &str| {
        let folder = out.join(units);
        let text = printed(&[
            "run",
            SMALL,
            "--units",
            units,
            "--figures",
            "--out",
            folder.to_str().unwrap(),
        ]);
        let read = |file: &str| fs::read_to_string(folder.join(file)).unwrap();
        let mut result: serde_json::Value = serde_json::from_str(&read("result.json")).unwrap();
        result["timing"] = serde_json::Value::Null;
        (text, result, read("histories.csv"), read("report.html"))
    };
    let ((si, result, histories, _), (us, same, of_us, page)) = (of("si"), of("us"));
    assert_eq!(result, same);
    assert_eq!(histories, of_us);
    // 96 psig and 763 kPa are the same pressure; 4.448 N are 1 lbf, 28.32 L are 1 ft3.
    assert_eq!(line(&si, "the supply:"), "the supply: 763 kPa absolute, 662 kPa gauge");
    assert_eq!(
        line(&us, "the supply:"),
        "the supply: 110.7 psi absolute, 96.0 psi gauge"
    );
    let (si_shot, us_shot) = (line(&si, "the shot:"), line(&us, "the shot:"));
    for unit in [" mm ", " J ", " L "] {
        assert!(si_shot.contains(unit) && !us_shot.contains(unit), "{us_shot}");
    }
    for unit in [" in ", " ft-lbf ", " ft3 "] {
        assert!(us_shot.contains(unit), "{us_shot}");
    }
    for (at, factor) in [25.4, 1.355_818, 28.316_85].into_iter().enumerate() {
        let (own, other) = (numbers(si_shot)[at], numbers(us_shot)[at]);
        assert!((factor * other / own - 1.0).abs() < 0.01, "{own} and {other}");
    }
    // Levels are the same.
    assert_eq!(line(&si, "total"), line(&us, "total"));
    assert_eq!(line(&si, "declared:"), line(&us, "declared:"));
    for part in [
        "data-unit=\"psi\"",
        "data-unit=\"in\"",
        "data-unit=\"lbf\"",
        "data-unit=\"scfm\"",
        " psi absolute",
    ] {
        assert!(page.contains(part), "{part}");
    }
    for part in [
        "data-unit=\"kPa\"",
        "data-unit=\"mm\"",
        "data-unit=\"kN\"",
        " kPa<",
        " kPa ",
    ] {
        assert!(!page.contains(part), "{part}");
    }
}

#[test]
fn check_states_the_values_of_the_design_in_the_units() {
    let (si, us) = (printed(&["check", SMALL]), printed(&["check", SMALL, "--units", "us"]));
    assert!(line(&si, "mean drive speed").contains(" m/s, ") && si.contains("kPa absolute"));
    let own = line(&us, "mean drive speed");
    assert!(
        own.contains(" ft/s, ") && own.contains(" oz of air") && own.contains("110.7 psi absolute"),
        "{own}"
    );
    assert!(us.contains("effect in") && si.contains("effect mm"), "{us}");
    assert!(!us.contains(" kPa") && !us.contains(" kg"), "{us}");
}

#[test]
fn the_environment_sets_the_units_and_an_option_overrides_it() {
    let run = |arguments: &[&str]| {
        let output = command(arguments).env("NAILNOISE_UNITS", "us").output().unwrap();
        assert!(output.status.success(), "{}", messages(&output));
        String::from_utf8(output.stdout).unwrap()
    };
    let out = folder("units-cycle");
    let out = out.to_str().unwrap();
    assert!(line(&run(&["cycle", SMALL, "--out", out]), "head depth").ends_with(" in"));
    assert!(line(&run(&["cycle", SMALL, "--units", "si", "--out", out]), "head depth").ends_with(" mm"));
    let wrong = command(&["cycle", SMALL])
        .env("NAILNOISE_UNITS", "imperial")
        .output()
        .unwrap();
    assert_eq!(wrong.status.code(), Some(2));
    assert!(messages(&wrong).contains("si, us"), "{}", messages(&wrong));
}

#[test]
fn a_comparison_and_a_sweep_have_the_units_in_headings_and_rows() {
    let out = folder("units-others");
    let out = out.to_str().unwrap();
    let vary = "supply.pressure=90psig,100psig";
    let swept = printed(&["sweep", SMALL, "--vary", vary, "--units", "us", "--out", out]);
    let heading = line(&swept, "supply.pressure");
    assert!(
        heading.contains("head in") && heading.contains("left ft-lbf") && heading.contains("air ft3"),
        "{heading}"
    );
    let page = fs::read_to_string(format!("{out}/sweep/sweep.html")).unwrap();
    assert!(page.contains("head in") && page.contains("air ft\u{b3}"));
    let csv = fs::read_to_string(format!("{out}/sweep/sweep.csv")).unwrap();
    assert!(csv.lines().next().unwrap().contains("head below the surface [m]"));
    let swept = json(&nailnoise(&[
        "sweep", SMALL, "--vary", vary, "--units", "us", "--out", out, "--json",
    ]));
    assert!(swept["points"][0]["performance"]["air_m3"].as_f64().unwrap() < 0.01);
}
