//! An error found while an assembly runs names file, line and path of its block, and what a nearer file changes.

use std::collections::BTreeMap;
use std::path::Path;

use nailnoise_documents::Document;
use nailnoise_dynamics::network::{AssemblyText, KeyValue, Numerics, PlacedError, RunError, simulate};

pub(crate) const HEAD: &str = r#"[cycle]
assembly = { name = "own", schema = 1 }
gas = { constant = "287.05 J/(kg K)", ratio = 1.4 }
end = "100 ms"
reservoir.atmosphere = { pressure = "101.325 kPa", temperature = "20 degC" }
"#;

/// The error of a run of an own assembly, of which a second file may change values.
fn failure(blocks: &str, changes: Option<&str>) -> PlacedError {
    let mut files = vec![Document::new(Path::new("own.toml"), &format!("{HEAD}{blocks}"))];
    files.extend(changes.map(|changes| Document::new(Path::new("changes.toml"), changes)));
    let text = AssemblyText::open_files(&files).unwrap_or_else(|error| panic!("{error}"));
    let resolved = text.resolve(&BTreeMap::<String, KeyValue>::new());
    let assembly = resolved
        .unwrap_or_else(|error| panic!("{error}; {}", error.help()))
        .assembly;
    let error = simulate(&assembly, &Numerics::default()).err();
    text.placed(&assembly, error.unwrap_or_else(|| panic!("it runs: {blocks}")))
}

#[track_caller]
fn assert_place(error: &PlacedError, line: usize, path: &str) {
    let block = error.block.as_ref().unwrap_or_else(|| panic!("no place: {error}"));
    let found = (block.at.file(), block.at.line(), block.path.as_str());
    assert_eq!(found, ("own.toml", line, path), "{error}");
    let head = format!("own.toml, line {line}: `{path}`: ");
    assert!(error.to_string().starts_with(&head), "{error}");
}

/// A piston without a stop that moves into a closed volume.
const CUSHION: &str = r#"body.piston.mass = "2 kg"
body.piston.start = { travel = "0 mm", speed = "-20 m/s" }
body.piston.unbalanced = true
volume.cushion = { dead = "1 cm3", pressure = "101.325 kPa" }
face.top = { volume = "cushion", body = "piston", push = "down", area = "1000 mm2" }
"#;

#[test]
fn a_volume_that_vanishes_has_a_place() {
    let error = failure(CUSHION, None);
    assert!(matches!(error.error, RunError::Collapse { .. }), "{error}");
    assert_place(&error, 9, "cycle.volume.cushion");
    assert!(!error.to_string().contains("changed at"), "{error}");
}

#[test]
fn what_a_nearer_file_changes_of_a_volume_is_named() {
    let changes = "[cycle.face.top]\n\narea = \"2000 mm2\"\n[cycle.body.piston]\nmass = \"3 kg\"\n";
    let error = failure(CUSHION, Some(changes));
    assert_place(&error, 9, "cycle.volume.cushion");
    let text = error.to_string();
    assert!(
        text.ends_with("; changed at changes.toml, line 3, by `cycle.face.top.area`"),
        "{text}"
    );
}

#[test]
fn a_spring_beyond_its_law_has_a_place() {
    let spring = r#"body.piston = { mass = "100 g", start = { travel = "0 mm", speed = "5 m/s" } }
[cycle.spring]

back = { on = "piston", against = "ground", push = "up", stiffness = "1 N/mm", limit = "5 mm" }
"#;
    let error = failure(spring, None);
    assert!(matches!(error.error, RunError::SpringLimit { .. }), "{error}");
    assert_place(&error, 9, "cycle.spring.back");
    let error = failure(spring, Some("[cycle.spring.back]\nlimit = \"4 mm\"\n"));
    let text = error.to_string();
    assert!(
        text.ends_with("; changed at changes.toml, line 2, by `cycle.spring.back.limit`"),
        "{text}"
    );
}

#[test]
fn a_passage_that_a_trigger_follows_endlessly_has_a_place() {
    let error = failure(
        r#"volume.vessel = { dead = "1 l", pressure = "800 kPa" }
trigger.released.starts = true
trigger.released.set = "vent gate shuts"
trigger.released.clear = "vent gate opens"
trigger.released.schedule = [["12.3 ms", false]]
[cycle.passage.vent]
between = ["vessel", "atmosphere"]
area = "1 mm2"
silent = true
open = { when = "released" }
"#,
        None,
    );
    assert!(matches!(error.error, RunError::Switching { .. }), "{error}");
    assert_place(&error, 11, "cycle.passage.vent");
    assert!(error.to_string().contains("give open.delay"), "{error}");
}

/// A passage that only follows the trigger is not part of the loop, and a latch has no delay.
#[test]
fn a_latch_that_switches_its_own_trigger_has_the_place_and_a_remedy() {
    let error = failure(
        r#"volume.vessel = { dead = "1 l", pressure = "800 kPa" }
trigger.held = { starts = true, schedule = [["5 ms", false]], set = "latch releases", clear = "latch catches" }
body.ball = { mass = "5 g", start = { travel = "0 mm" } }
[cycle.passage.vent]
between = ["vessel", "atmosphere"]
area = "1 mm2"
silent = true
open = { when = "held" }
[cycle.hold]
latch = { on = "ball", stiffness = "1 N/mm", while = "held" }
"#,
        None,
    );
    assert!(matches!(error.error, RunError::Switching { .. }), "{error}");
    assert_place(&error, 15, "cycle.hold.latch");
    assert!(error.to_string().contains("a motor or latch has no delay"), "{error}");
}

#[test]
fn a_body_that_is_not_seated_has_the_place_of_its_contact() {
    let error = failure(
        r#"gravity = "9.81 m/s2"
body.tool = { mass = "1 kg", start = { rest_on = "nose" } }
force.pull = { on = "tool", force = "-50 N" }

contact.nose = { on = "tool", against = "ground", stop = "below", stiffness = "1000 N/mm", damping_ratio = 0.1 }
"#,
        None,
    );
    assert!(matches!(error.error, RunError::NotSeated { .. }), "{error}");
    assert_place(&error, 10, "cycle.contact.nose");
    assert!(error.to_string().contains("at rest (-40.2 N)"), "{error}");
}

#[test]
fn a_contact_that_chatters_has_a_place() {
    let error = failure(
        r#"[cycle.body.ball]
mass = "5 g"
start = { travel = "-1e-7 m" }
weighted = { position = "1e-6 m", velocity = "1 m/s" }
[cycle.contact.stop]
on = "ball"
against = "ground"
stop = "below"
stiffness = "1e14 N/m"
damping = "0 N s/m"
[cycle.force.push]
on = "ball"
force = "1e5 N"
"#,
        None,
    );
    assert!(matches!(error.error, RunError::Chatter { .. }), "{error}");
    assert_place(&error, 10, "cycle.contact.stop");
}

#[test]
fn an_error_of_no_single_block_has_no_place() {
    let error = PlacedError::from(RunError::Integration {
        time: 0.01,
        cause: "step size".to_owned(),
    });
    assert!(error.block.is_none() && error.to_string().starts_with("the integration stopped"));
}
