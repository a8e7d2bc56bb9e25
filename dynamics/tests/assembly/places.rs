//! An error has the place of the block at fault and names the changes that the user's file makes to it.

use std::path::Path;

use nailnoise_documents::Document;
use nailnoise_dynamics::network::{AssemblyText, Numerics, simulate};

use crate::common;
use crate::errors::refusal;
use crate::keys::keys;

#[test]
fn a_circle_is_placed_in_the_file_that_closes_it() {
    for (changes, path) in [
        ("[cycle.body.tool]\nparent = \"piston\"", "cycle.body.tool.parent"),
        ("[cycle.event.t6]\nafter = \"t9\"", "cycle.event.t6.after"),
    ] {
        let (message, error) = refusal(changes);
        assert_eq!((error.at.file(), error.at.line()), ("own.toml", 4), "{message}");
        assert_eq!(error.path, path);
    }
}

/// The place of a fault between blocks of the assembly is the block there, and the message names the user's field.
#[test]
fn a_fault_that_an_override_causes_names_the_override() {
    for (changes, place, change) in [
        (
            "[cycle.contact.bumper]\nat = \"130 mm\"",
            "`cycle.volume.below_piston` shrinks",
            "; changed at own.toml, line 4, by `cycle.contact.bumper.at`",
        ),
        (
            "[cycle.volume.below_piston]\n\ndead = \"1 mm3\"\n[cycle.contact.bumper]\nstiffness = \"900 N/mm\"\nat = \
             \"=piston.stroke + 1 mm\"",
            "`cycle.volume.below_piston` shrinks",
            "; changed at own.toml, line 5, by `cycle.volume.below_piston.dead` and at own.toml, line 8, by \
             `cycle.contact.bumper.at`",
        ),
        (
            "[cycle.spring.spring]\npreload = \"0.5 mm\"",
            "`cycle.spring.spring` is compressed",
            "; changed at own.toml, line 4, by `cycle.spring.spring.preload`",
        ),
        (
            "[cycle.passage.intake.seat]\nat = \"=head_valve.lift - 1 mm\"",
            "`cycle.passage.intake` and \"exhaust\" are open together",
            "; changed at own.toml, line 4, by `cycle.passage.intake.seat.at`",
        ),
        (
            "[cycle.face.valve_outer]\narea = \"100 mm2\"",
            "the faces of body \"head_valve\" do not balance",
            "; changed at own.toml, line 4, by `cycle.face.valve_outer.area`",
        ),
        (
            "[cycle.face]\nvalve_outer = false\n[cycle.load.tool]\nrim = \"seat.force\"",
            "the faces of body \"head_valve\" do not balance",
            "; changed at own.toml, line 4, by `cycle.face.valve_outer`",
        ),
        (
            "[cycle.opening]\nexhaust = false\n[cycle.pressure.tool]\nplenum = false",
            "`cycle.passage.exhaust` blows into the atmosphere without an opening",
            "; changed at own.toml, line 4, by `cycle.opening.exhaust`",
        ),
        (
            "[cycle.face]\nextra = { volume = \"below_piston\", body = \"piston\", push = \"up\", area = \"5 cm2\" }\n\
             back = { volume = \"atmosphere\", body = \"piston\", push = \"down\", area = \"5 cm2\" }",
            "`cycle.volume.below_piston` shrinks",
            "; changed at own.toml, line 4, by `cycle.face.extra`",
        ),
    ] {
        let (message, error) = refusal(changes);
        assert_eq!(error.at.file(), "assemblies/n80cb.toml", "{message}");
        assert!(error.at.line() > 1, "{message}");
        assert!(message.contains(place) && message.contains(change), "{message}");
    }
}

/// A key that the closest file gives, and which a formula of the assembly reads, is named like a field.
#[test]
fn a_fault_that_a_key_causes_names_the_key() {
    let text = "[head_valve]\nspring_preload = \"4 mm\"\n[cycle]\nassembly = \"n80cb\"\n";
    let document = Document::new(Path::new("own.toml"), text);
    let mut values = keys(&common::n80cb());
    values.remove("head_valve.spring_preload");
    let error = AssemblyText::open(&document)
        .and_then(|text| text.resolve(&values))
        .expect_err("accepted");
    let expected = "; changed at own.toml, line 2, by `head_valve.spring_preload`";
    assert!(error.to_string().contains(expected), "{error}");
}

/// The error of a tool that a force lifts names the changes to the forces on its body.
#[test]
fn the_error_of_an_unseated_tool_names_the_changed_force() {
    for (changes, change) in [
        ("[cycle.force.hand]\nforce = \"-500 N\"", "cycle.force.hand.force"),
        (
            "[cycle.force]\nhand = false\nup = { on = \"tool\", force = \"-500 N\" }\n[cycle.load.tool]\n\
             handle = \"up.force\"",
            "cycle.force.hand",
        ),
    ] {
        let file = format!("[cycle]\nassembly = \"n80cb\"\n{changes}\n");
        let text = AssemblyText::open(&Document::new(Path::new("own.toml"), &file)).unwrap();
        let resolved = text.resolve(&keys(&common::n80cb()));
        let assembly = resolved.unwrap_or_else(|error| panic!("{error}")).assembly;
        let error = simulate(&assembly, &Numerics::default()).expect_err("the tool is lifted");
        let message = text.placed(&assembly, error).to_string();
        let expected = format!("own.toml, line 4, by `{change}`");
        assert!(
            message.contains("not seated") && message.contains("changed at") && message.contains(&expected),
            "{message}"
        );
    }
}

/// A name that a file removes is no spelling mistake.
#[test]
fn a_reference_to_what_a_file_removes_names_the_removal() {
    for (changes, line) in [
        (
            "[cycle.contact]\nbumper = false",
            "own.toml, line 4, removes `cycle.contact.bumper`",
        ),
        ("[cycle.let]\nCd = false", "own.toml, line 4, removes `cycle.let.Cd`"),
        (
            "[cycle.trigger]\nreleased = false",
            "changed at own.toml, line 4, by `cycle.trigger.released`",
        ),
    ] {
        let (message, _) = refusal(changes);
        assert!(message.contains(line), "{message}");
    }
}

#[test]
fn a_removal_of_what_does_not_exist_is_refused() {
    let (message, error) = refusal("[cycle.contact]\nbumpr = false");
    assert!(
        message.contains("not a known contact that `false` could remove; did you mean \"bumper\"?"),
        "{message}"
    );
    assert_eq!((error.at.file(), error.at.line()), ("own.toml", 4));
}
