//! Records of the surfaces of a body from a file: written by `check`, compared by `check` and by `run`.

use crate::common::{SMALL, folder, json, messages, nailnoise, over};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use nailnoise_meshes::msh::{self, Format};
use nailnoise_meshes::{Block, Mesh, block};

/// Length of the block of the small design \[m\].
const LENGTH: f64 = 0.4064;

/// A mesh of the small design's block with named faces; its end towards +x determines the length \[m\].
fn block_of(length: f64, divisions: [usize; 3]) -> Mesh {
    let spec = Block {
        size: [length, 0.1524, 0.09525],
        divisions,
        origin: [-0.5 * LENGTH, -0.0762, 0.0],
    };
    block(&spec).unwrap()
}

/// A design whose workpiece is a mesh from a file beside it.
struct Own {
    folder: PathBuf,
    design: String,
}

impl Own {
    fn new(name: &str) -> Self {
        let folder = folder(&format!("surface-records-{name}"));
        let design = over(
            &folder,
            "own",
            "workpiece.mesh = \"block.msh\"\nworkpiece.mesh_unit = \"1 m\"",
        );
        let own = Self { folder, design };
        own.put(&block_of(LENGTH, [4, 2, 2]));
        own
    }

    /// Replaces the file of the mesh.
    fn put(&self, mesh: &Mesh) {
        let bytes = msh::to_bytes(mesh, Format::Binary41, "of a test");
        fs::write(self.folder.join("block.msh"), bytes).unwrap();
    }

    fn check(&self, options: &[&str]) -> Output {
        nailnoise(&[&["check", &self.design, "--body", "workpiece"], options].concat())
    }

    /// Records the surfaces and returns the text of the file.
    fn record(&self) -> String {
        let file = self.folder.join("surfaces.toml");
        let output = self.check(&["--record-surfaces", file.to_str().unwrap()]);
        assert!(output.status.success(), "{}", said(&output));
        fs::read_to_string(file).unwrap()
    }

    /// Adds text at the end of the design.
    fn append(&self, text: &str) {
        let design = fs::read_to_string(&self.design).unwrap();
        fs::write(&self.design, format!("{design}\n{text}")).unwrap();
    }
}

/// Both streams on one line.
fn said(output: &Output) -> String {
    let text = format!("{}{}", String::from_utf8_lossy(&output.stdout), messages(output));
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The only fault that `check` finds.
#[track_caller]
fn fault(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(2), "{}", said(output));
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let faults = result["faults"].as_array().unwrap();
    assert_eq!(faults.len(), 1, "{faults:#?}");
    faults[0].as_str().unwrap().to_owned()
}

#[test]
fn a_record_states_every_surface_that_a_run_can_use() {
    let text = Own::new("text").record();
    let top = "[recorded_surfaces.workpiece_top]\nbody = \"workpiece\"\nsurface = \"top\"\narea = \"619.35 cm2\"\n\
               x = \"0 mm\"\ny = \"0 mm\"\nz = \"95.25 mm\"\nnormal_x = 0\nnormal_y = 0\nnormal_z = 1\n";
    assert!(text.contains(top), "{text}");
    for name in ["bottom", "x_min", "x_max", "y_min", "y_max"] {
        assert!(
            text.contains(&format!("[recorded_surfaces.workpiece_{name}]\n")),
            "{text}"
        );
    }
}

#[test]
fn a_file_agrees_with_its_record_also_if_it_is_meshed_more_finely() {
    let own = Own::new("same");
    own.append(&own.record());
    for divisions in [[4, 2, 2], [9, 3, 5]] {
        own.put(&block_of(LENGTH, divisions));
        let result = json(&own.check(&["--json"]));
        assert_eq!(result["faults"], serde_json::json!([]), "{result:#}");
    }
}

#[test]
fn a_surface_that_has_moved_by_3_mm_is_refused_by_check_with_place_and_numbers() {
    let own = Own::new("moved");
    own.append(&own.record());
    own.put(&block_of(LENGTH + 0.003, [4, 2, 2]));
    let fault = fault(&own.check(&["--json"]));
    let text = fs::read_to_string(&own.design).unwrap();
    let record = text.find("[recorded_surfaces.workpiece_x_max]").unwrap();
    let line = text[..record].lines().count() + 1;
    for words in [
        "own.toml:",
        "`recorded_surfaces.workpiece_x_max`",
        "the surface `x_max` in the mesh of the workpiece",
        "centre (203.2, 0, 47.6",
        "mm recorded, (206.2, 0, 47.6",
        "mm found (3 mm apart, 2.41 mm allowed)",
        "[surfaces.NAME]",
        "check DESIGN --body workpiece --record-surfaces FILE",
    ] {
        assert!(fault.contains(words), "{words}: {fault}");
    }
    let place = fault.split(' ').next().unwrap().trim_end_matches(':');
    let found: usize = place.split(':').find_map(|part| part.parse().ok()).unwrap();
    assert!(
        (line..line + 10).contains(&found),
        "{fault}: the table begins in line {line}"
    );
}

#[test]
fn a_surface_that_has_moved_ends_a_run_before_any_modes() {
    let own = Own::new("run");
    own.append(&own.record());
    own.put(&block_of(LENGTH + 0.003, [4, 2, 2]));
    let out = own.folder.join("out");
    let output = nailnoise(&["run", &own.design, "--out", out.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    let said = said(&output);
    assert!(
        said.contains("recorded_surfaces.workpiece_x_max") && said.contains("own.toml"),
        "{said}"
    );
    assert!(
        !out.join("result.json").exists() && !said.contains("vibration modes of a body"),
        "{said}"
    );
}

#[test]
fn a_surface_that_looks_the_other_way_is_refused() {
    let own = Own::new("normal");
    let text = own.record();
    own.append(&text.replace("normal_z = 1", "normal_z = -1"));
    let fault = fault(&own.check(&["--json"]));
    let words = "workpiece_top` does not agree with the surface `top` in the mesh of the workpiece: mean normal (0, 0, \
                 -1) recorded, (0, 0, 1) found (2 apart, 0.1 allowed)";
    assert!(fault.contains(words), "{fault}");
}

#[test]
fn a_surface_of_another_area_is_refused() {
    let own = Own::new("area");
    own.append(&own.record().replace("area = \"619.35 cm2\"", "area = \"570 cm2\""));
    let output = own.check(&[]);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    let words = "area 570 cm2 recorded, 619.35 cm2 found (8.7 % apart, 5 % allowed)";
    assert!(said(&output).contains(words), "{}", said(&output));
}

#[test]
fn a_recorded_surface_that_is_missing_is_refused_with_those_that_exist() {
    let own = Own::new("missing");
    own.append(&own.record());
    let mut mesh = block_of(LENGTH, [4, 2, 2]);
    mesh.groups.retain(|group| group.name != "x_min");
    own.put(&mesh);
    let fault = fault(&own.check(&["--json"]));
    let words = "workpiece_x_min` records the surface `x_min`, which the mesh of the workpiece does not have; it has: ";
    assert!(fault.contains(words) && fault.contains("x_max"), "{fault}");
}

#[test]
fn a_record_of_a_surface_that_the_body_cannot_have_is_refused_as_the_design_is_read() {
    let own = Own::new("other");
    own.append(&own.record().replace("surface = \"top\"", "surface = \"seat\""));
    let output = own.check(&[]);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(
        said(&output).contains("names the surface `seat`, which the workpiece does not have"),
        "{}",
        said(&output)
    );
}

#[test]
fn a_record_of_a_built_in_body_is_a_warning() {
    let own = Own::new("idle");
    own.append(&own.record());
    let result = json(&own.check(&["--set", "workpiece.mesh=\"\"", "--json"]));
    let warnings = result["warnings"].as_array().unwrap();
    assert!(
        warnings
            .iter()
            .any(|words| words.as_str().unwrap().contains("without effect")
                && words.as_str().unwrap().contains("workpiece_top")),
        "{result:#}"
    );
}

#[test]
fn surfaces_are_recorded_for_a_body_of_a_design_from_a_file_and_replace_no_file() {
    let own = Own::new("refused");
    own.record();
    let file = own.folder.join("surfaces.toml");
    let (file, fresh) = (file.to_str().unwrap(), own.folder.join("fresh.toml"));
    let (new, mesh) = (fresh.to_str().unwrap(), own.folder.join("block.msh"));
    for (arguments, words) in [
        (
            &["check", &own.design, "--body", "workpiece", "--record-surfaces", file][..],
            "is there already",
        ),
        (
            &["check", SMALL, "--body", "workpiece", "--record-surfaces", new],
            "`workpiece.mesh`",
        ),
        (&["check", SMALL, "--record-surfaces", new], "--body"),
        (
            &[
                "check",
                mesh.to_str().unwrap(),
                "--body",
                "workpiece",
                "--record-surfaces",
                new,
            ],
            "is not a design",
        ),
    ] {
        let output = nailnoise(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", said(&output));
        assert!(said(&output).contains(words), "{arguments:?}: {}", said(&output));
    }
    assert!(!Path::new(new).exists());
}

#[test]
fn a_surface_that_a_radius_cuts_may_differ_by_whole_elements() {
    let own = Own::new("radius");
    let place = "[surfaces.end]\nbody = \"workpiece\"\nsurface = \"x_max\"\nx = \"203.2 mm\"\ny = \"0 mm\"\n\
                 z = \"48 mm\"\nradius = \"50 mm\"\nalong_x = 1\nalong_y = 0\nalong_z = 0\n";
    own.append(place);
    own.put(&block_of(LENGTH, [4, 8, 8]));
    own.append(&own.record());
    own.put(&block_of(LENGTH, [4, 12, 10]));
    let result = json(&own.check(&["--json"]));
    let area = |result: &serde_json::Value| {
        let groups = result["groups"].as_array().unwrap();
        let own = groups.iter().find(|group| group["name"] == "x_max").unwrap();
        own["area"].as_f64().unwrap()
    };
    let finer = area(&result);
    own.put(&block_of(LENGTH, [4, 8, 8]));
    let coarse = area(&json(&own.check(&["--json"])));
    assert!(
        (finer / coarse - 1.0).abs() > 0.05,
        "{finer} m2 and {coarse} m2 need no larger tolerance"
    );
}
