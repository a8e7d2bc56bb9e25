//! `check DESIGN --drawing`: the file, the printed text, and the refusals.

use crate::common::{SMALL, command, folder, json};
use std::fs;
use std::process::Output;

fn nailnoise(arguments: &[&str]) -> Output {
    command(arguments).output().unwrap()
}

#[test]
fn a_drawing_is_written_whole_and_its_path_is_printed() {
    let file = folder("drawing").join("tool.svg");
    let path = file.to_str().unwrap();
    let output = nailnoise(&["check", SMALL, "--drawing", path, "--set", "piston.bore=58mm"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("written to") && text.contains("tool.svg"), "{text}");
    let svg = fs::read_to_string(&file).unwrap();
    assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
    assert!(
        svg.contains("<title>piston.bore = 58 mm."),
        "the key has no title with its value"
    );
    let result = json(&nailnoise(&["check", SMALL, "--drawing", path, "--json"]));
    assert_eq!(result["schema"], "nailnoise-drawing/1");
    assert_eq!(result["written"], path);
    let keys = result["keys"].as_array().unwrap();
    assert!(keys.iter().any(|key| key == "head_valve.intake_lap"), "{keys:?}");
}

#[test]
fn a_drawing_without_a_file_is_in_the_folder_of_the_design() {
    let place = folder("drawing-default");
    let output = command(&["check", &format!("{}/{SMALL}", crate::common::ROOT), "--drawing"])
        .current_dir(&place)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(place.join("out/small/drawing.svg").is_file());
}

#[test]
fn a_drawing_replaces_no_design_and_needs_one() {
    for (arguments, words) in [
        (&["check", SMALL, "--drawing", "other.toml"][..], ".svg"),
        (&["check", "--drawing", SMALL], ".svg"),
        (&["check", SMALL, "--body", "tool", "--drawing"], "--body"),
        (&["check", "housing.msh", "--drawing"], "not a design"),
    ] {
        let output = nailnoise(arguments);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(said.contains(words), "{arguments:?}: {said}");
    }
}
