//! Assemblies at the edge of the grammar: without states, with faces that move together, with forces of faces in loads,
//! with ranges of numbers.

use std::collections::BTreeMap;
use std::path::Path;

use nailnoise_documents::Document;
use nailnoise_dynamics::network::{AssemblyError, AssemblyText, KeyValue, Numerics, Record, Resolved, simulate};

use crate::runs::HEAD;

fn resolved(blocks: &str) -> Result<Resolved, AssemblyError> {
    let document = Document::new(Path::new("own.toml"), &format!("{HEAD}{blocks}"));
    AssemblyText::open(&document)?.resolve(&BTreeMap::<String, KeyValue>::new())
}

fn run(blocks: &str) -> Record {
    let assembly = resolved(blocks).unwrap_or_else(|error| panic!("{error}")).assembly;
    let record = simulate(&assembly, &Numerics::default()).unwrap_or_else(|error| panic!("{error}"));
    assert!(record.is_certified(), "{:#?}", record.checks);
    record
}

/// A shuttle in a plenum that leaks; its two ends are in the same gas.
const SHUTTLE: &str = r#"volume.plenum = { dead = "5 cm3", pressure = "6 barg" }
passage.leak = { between = ["plenum", "atmosphere"], area = "1 mm2", silent = true }
body.shuttle.mass = "50 g"
face.top = { volume = "plenum", body = "shuttle", push = "down", area = "570 mm2" }
face.bottom = { volume = "plenum", body = "shuttle", push = "up", area = "570 mm2" }
contact.a = { on = "shuttle", stop = "above", stiffness = "1 kN/mm", damping_ratio = 0.2 }
contact.b = { on = "shuttle", stop = "below", at = "24 mm", stiffness = "1 kN/mm", damping_ratio = 0.2 }
force.push = { on = "shuttle", force = "20 N" }
"#;

#[test]
fn an_assembly_without_states_runs_to_its_end() {
    run("");
    run(
        "reservoir.hose = { pressure = \"6 barg\", temperature = \"20 degC\" }\n\
         passage.tip = { between = [\"hose\", \"atmosphere\"], area = \"3 mm2\" }\nopening.tip.passage = \"tip\"\n",
    );
}

/// Its ends sweep 13.7 cm3 each, more than the volume of 5 cm3, but their sum is zero.
#[test]
fn faces_of_one_body_sweep_a_volume_together() {
    run(SHUTTLE);
    let one = SHUTTLE.replace("face.top", "# face.top").replace(
        "body.shuttle.mass = \"50 g\"",
        "body.shuttle = { mass = \"50 g\", unbalanced = true }",
    );
    let error = resolved(&one).unwrap_err();
    assert!(error.to_string().contains("shrinks"), "{error}");
}

#[test]
fn the_force_of_a_face_is_a_term_of_the_loads() {
    let shaft = "body.shuttle = { mass = \"50 g\", parent = \"tool\" }\n\
                 body.tool = { mass = \"1 kg\", start = { rest_on = \"nose\" } }";
    let piston = SHUTTLE
        .replace(
            "face.bottom = { volume = \"plenum\"",
            "face.bottom = { volume = \"atmosphere\"",
        )
        .replace("body.shuttle.mass = \"50 g\"", shaft)
        .replace(
            "on = \"shuttle\", force = \"20 N\"",
            "on = \"tool\", force = \"2000 N\"",
        )
        .replace("dead = \"5 cm3\"", "dead = \"25 cm3\"");
    let nose = "on = \"tool\", stop = \"below\", stiffness = \"1 kN/mm\", damping_ratio = 0.2";
    let rest = "b.force + bottom.force - nose.force + push.force";
    let loads = |roof: &str| {
        format!("{piston}contact.nose = {{ {nose} }}\nload.tool = {{ roof = \"{roof}\", rest = \"{rest}\" }}\n")
    };
    let right = resolved(&loads("a.force - top.force")).err();
    assert!(right.is_none(), "{right:?}");
    let error = resolved(&loads("a.force - 2*top.force")).unwrap_err();
    assert!(error.to_string().contains("plenum.gauge"), "{error}");
}

#[test]
fn a_number_lies_within_its_range_and_the_range_within_the_domain() {
    let dead = |range: &str| {
        SHUTTLE.replace(
            "dead = \"5 cm3\"",
            &format!("dead = {{ value = \"5 cm3\", range = \"{range}\" }}"),
        )
    };
    assert!(resolved(&dead("4 .. 6 cm3")).is_ok());
    for range in ["6 .. 8 cm3", "-4 .. 6 cm3"] {
        let error = resolved(&dead(range)).unwrap_err();
        assert!(error.path == "cycle.volume.plenum.dead", "{error}");
    }
}

/// A contact with its bodies exchanged is the same stop. Without it, the volume above the shuttle would vanish.
#[test]
fn a_stop_may_be_given_by_either_of_its_bodies() {
    let tool = "body.tool = { mass = \"1 kg\", start = { travel = \"0 mm\" } }\n";
    let parent = SHUTTLE
        .replace(
            "body.shuttle.mass = \"50 g\"",
            "body.shuttle = { mass = \"50 g\", parent = \"tool\" }",
        )
        .replace(
            "face.bottom = { volume = \"plenum\"",
            "face.bottom = { volume = \"atmosphere\"",
        )
        .replace("dead = \"5 cm3\"", "dead = \"1 cm3\"")
        .replace("area = \"570 mm2\" }", "area = \"570 mm2\", zero = \"-3 mm\" }");
    let reversed = parent.replace(
        "contact.a = { on = \"shuttle\", stop = \"above\",",
        "contact.a = { on = \"tool\", against = \"shuttle\", stop = \"below\", at = \"2 mm\",",
    );
    let without = parent.replace("contact.a", "# contact.a");
    assert!(
        resolved(&format!("{tool}{reversed}")).is_ok(),
        "{:?}",
        resolved(&format!("{tool}{reversed}")).err()
    );
    let far = reversed.replace("at = \"2 mm\"", "at = \"9 mm\"");
    let error = resolved(&format!("{tool}{far}")).unwrap_err();
    assert!(
        error.to_string().contains("shrinks") && error.to_string().contains("-9.000 mm"),
        "{error}"
    );
    assert!(resolved(&format!("{tool}{without}")).is_ok());
}

#[test]
fn pressures_of_own_keys_and_names_may_be_relative_to_the_atmosphere() {
    let own = SHUTTLE.replace("pressure = \"6 barg\"", "pressure = \"=own.fill + rise\"");
    let text = format!(
        "{own}let.rise = \"1 barg\"\n[keys.own]\nfill = {{ domain = \"1 .. 10 bar\" }}\n[own]\nfill = \"5 barg\"\n"
    );
    let assembly = resolved(&text).unwrap_or_else(|error| panic!("{error}")).assembly;
    let ambient = assembly.reservoirs[0].pressure;
    assert!(
        (assembly.volumes[0].pressure - (6e5 + 2.0 * ambient)).abs() < 1e-6,
        "{}",
        assembly.volumes[0].pressure
    );
}

/// "pi" is a constant of formulas: an own value would have no effect.
#[test]
fn reserved_names_are_refused() {
    let error = resolved("let.pi = 3\n").unwrap_err();
    assert!(
        error.path == "cycle.let.pi" && error.help().contains("choose another name"),
        "{error}"
    );
}

fn refusal(blocks: &str) -> String {
    let error = resolved(blocks).err().unwrap_or_else(|| panic!("accepted: {blocks}"));
    format!("{error}; {}", error.help())
}

/// A vessel with a port, and a body between two stops.
const PORT: &str = r#"volume.vessel = { dead = "5 cm3", pressure = "6 barg" }
volume.second = { dead = "5 cm3", pressure = "1 barg" }
passage.inner = { between = ["vessel", "second"], area = "1 mm2" }
passage.port = { between = ["second", "atmosphere"], area = "1 mm2" }
opening.port.passage = "port"
"#;

#[test]
fn an_opening_leads_to_the_atmosphere_and_is_the_only_one_of_its_passage() {
    assert!(resolved(PORT).is_ok());
    for (from, to, part) in [
        (
            "passage = \"port\"",
            "passage = \"inner\"",
            "not a known passage to the atmosphere; there are: port",
        ),
        (
            "opening.port",
            "opening.again.passage = \"port\"\nopening.port",
            "the noise of \"port\", as the opening \"again\" does",
        ),
        (
            "\"atmosphere\"], area",
            "\"atmosphere\"], silent = true, area",
            "more than one of silent = true, an opening",
        ),
        (
            "passage = \"port\"",
            "passage = \"port\"\nopening.port.count = 2.5",
            "allowed is a whole number",
        ),
    ] {
        let message = refusal(&PORT.replace(from, to));
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn a_body_starts_outside_its_stops_and_rests_on_its_own() {
    let at = |start: &str| {
        SHUTTLE.replace(
            "body.shuttle.mass = \"50 g\"",
            &format!(
                "body.shuttle = {{ mass = \"50 g\", start = {start} }}\nbody.other.mass = \"50 g\"\n\
                      contact.c = {{ on = \"other\", stop = \"below\", stiffness = \"1 kN/mm\" }}"
            ),
        )
    };
    assert!(resolved(&at("{ travel = \"24.1 mm\" }")).is_ok());
    let message = refusal(&at("{ travel = \"60 mm\" }"));
    assert!(
        message.contains("starts 36.000 mm inside the stop \"b\", which stores 648 J"),
        "{message}"
    );
    let message = refusal(&at("{ rest_on = \"c\" }"));
    assert!(
        message.contains("not a known contact or spring of this body; did you mean \"a\"? there are: a, b"),
        "{message}"
    );
}

#[test]
fn a_pressure_of_the_atmosphere_and_of_a_formula_is_absolute() {
    let gauge = HEAD.replace("101.325 kPa", "0 barg");
    let document = Document::new(Path::new("own.toml"), &format!("{gauge}{PORT}"));
    let error = AssemblyText::open(&document)
        .and_then(|text| text.resolve(&BTreeMap::<String, KeyValue>::new()))
        .unwrap_err();
    assert!(
        error
            .to_string()
            .contains("gauge pressures are relative to this pressure"),
        "{error}"
    );
    let message = refusal(&PORT.replace("\"6 barg\"", "\"=1 bar + 6 barg\""));
    assert!(message.contains("`6 barg` is relative to the atmosphere"), "{message}");
}

#[test]
fn a_value_may_be_a_formula_without_a_range() {
    let own = |value: &str| {
        PORT.replace(
            "volume.vessel = { dead = \"5 cm3\"",
            &format!("let.box = \"5 cm3\"\nvolume.vessel = {{ dead = {value}"),
        )
    };
    let assembly = resolved(&own("{ value = \"=2*box\", provenance = \"estimated\" }"))
        .unwrap()
        .assembly;
    assert!((assembly.volumes[0].dead - 10e-6).abs() < 1e-18);
    let message = refusal(&own("{ value = \"=2*box\", range = \"5 .. 15 cm3\" }"));
    assert!(message.contains("more than one of a formula, range"), "{message}");
}
