//! Every error of an assembly names its file, line and path, what is expected, and the remedy.

use std::path::Path;

use nailnoise_documents::Document;
use nailnoise_dynamics::network::{AssemblyError, AssemblyText, KeyValue, Resolved};

use crate::common;
use crate::keys::keys;

/// Reads the N80CB with changes.
pub(crate) fn changed(changes: &str) -> Result<Resolved, AssemblyError> {
    let text = format!("[cycle]\nassembly = \"n80cb\"\n{changes}\n");
    let document = Document::new(Path::new("own.toml"), &text);
    AssemblyText::open(&document)?.resolve(&keys(&common::n80cb()))
}

/// The error of a change, with its place and remedy in one text.
pub(crate) fn refusal(changes: &str) -> (String, AssemblyError) {
    let error = changed(changes).err().unwrap_or_else(|| panic!("accepted: {changes}"));
    (format!("{error}; {}", error.help()), error)
}

pub(crate) fn refused(cases: &[(&str, &[&str])]) {
    for (changes, expected) in cases {
        let (message, _) = refusal(changes);
        for part in *expected {
            assert!(message.contains(part), "{changes}\n  {message}\n  lacks: {part}");
        }
    }
}

#[test]
fn a_change_without_an_error_is_accepted() {
    assert!(changed("[cycle.passage.leak]\ncoefficient = 0.7").is_ok());
}

#[test]
fn an_error_names_file_line_path_and_the_nearest_name() {
    let (message, error) = refusal("\n\n[cycle.passage.leak]\nbetween = [\"below_pistn\", \"atmosphere\"]");
    assert_eq!((error.at.file(), error.at.line()), ("own.toml", 6));
    assert_eq!(error.path, "cycle.passage.leak.between");
    assert!(
        message.contains("not a known volume or reservoir") && message.contains("did you mean \"below_piston\"?"),
        "{message}"
    );
}

#[test]
fn names_must_exist_and_be_unique() {
    refused(&[
        (
            "[cycle.body.piston]\nparent = \"tol\"",
            &["not a known body", "did you mean \"tool\"?", "ground"],
        ),
        (
            "[cycle.trigger.released]\nset = \"gaurd opens\"",
            &["waits for", "did you mean \"guard opens\"?"],
        ),
        (
            "[cycle.passage.fill.open]\nwhen = \"pressed\"",
            &["not a known trigger", "released"],
        ),
        (
            "[cycle.opening.vent]\npassage = \"went\"",
            &["not a known passage", "did you mean \"vent\"?"],
        ),
        (
            "[cycle.opening.exhaust]\nrestriction = \"hole\"",
            &["none of seat, holes", "did you mean \"holes\"?"],
        ),
        (
            "[cycle.opening.exhaust]\npassage = \"leak\"",
            &["\"leak\" has a single restriction", "restriction = false"],
        ),
        ("[cycle.event.t5]\nafter = \"t99\"", &["not a known event"]),
        (
            "[cycle.spring.seat]\non = \"piston\"\npush = \"up\"\nstiffness = \"1 N/mm\"",
            &["has the name of a contact"],
        ),
        (
            "[cycle.volume.Silencer]\ndead = \"1 l\"",
            &["not a name of a block", "lower-case"],
        ),
        (
            "[cycle.event.t4]\nbecomes = \"arm.travel > 1 mm\"",
            &["\"arm\", which its `if` switches off"],
        ),
        (
            "[cycle.force.push]\nif = true",
            &["\"arm\", which its `if` switches off", "the same `if`"],
        ),
        ("[cycle.load.nose]\ntip = \"nose.force\"", &["not a known body"]),
        (
            "[cycle.event.t4]\nbecomes = \"nail hits\"",
            &[
                "waits for \"nail hits\", which no block logs",
                "there are: nail struck, nail left, nail enters, nail seats, nail unloads, nail reloads",
            ],
        ),
        (
            "[cycle.event.t4]\nbecomes = \"exhaust.seat opns\"",
            &["did you mean \"exhaust.seat opens\"?"],
        ),
        (
            "[cycle.event.t4]\nbecomes = \"exhaust.holes choked\"",
            &["which no block logs", "there are: exhaust opens", "exhaust choked"],
        ),
        (
            "[cycle.event.t4]\nbecomes = \"exhast choked\"",
            &[
                "not a known block with the word \"choked\"",
                "did you mean \"exhaust\"?",
            ],
        ),
        (
            "[cycle.event.t0]\nat = \"exhaust choked\"",
            &["which is not a time", "replace it by becomes = \"exhaust choked\""],
        ),
        (
            "[cycle.contact.bumper]\nat = \"piston.stroke - 5 mm\"",
            &["begins with \"=\", as \"=piston.stroke - 5 mm\""],
        ),
        (
            "[cycle.passage.leak]\narea = \"=disk(2 mm)\"",
            &["did you mean `disc`?"],
        ),
        ("[cycle.volume.supply]\npressure = \"7 bar(g)\"", &["psi, barg, psig"]),
        (
            "[cycle.event.t4]\nbecomes = \"leak.mass_flow > 0.01\"",
            &["a mass flow (or damping coefficient) and a plain number"],
        ),
        (
            "[cycle.event.t4]\nbecomes = \"above_piston hits\"",
            &["which no block logs", "logs no words", "give a condition"],
        ),
        (
            "[cycle.event.t5]\nafter = \"nail struk\"",
            &[
                "names \"nail struk\", which is not an event",
                "add one to [cycle.event], as hit = { becomes = \"nail struck\" }",
            ],
        ),
        (
            "[cycle.event.t17]\nis = \"nail hits\"",
            &[
                "is \"nail hits\", which is not a condition",
                "becomes = \"nail struck\" instead",
                "the words of the block are nail struck, nail left, nail enters, nail seats",
            ],
        ),
        (
            "[cycle.event.t13]\nwhere = \"exhaust.seat opens\"",
            &["which is not a condition", "becomes = \"exhaust.seat opens\" instead"],
        ),
        (
            "[cycle.event.t13]\nwhere = \"above_piston empties\"",
            &["which is not a condition", "logs no words; give a condition"],
        ),
        (
            "[cycle.trigger.released]\nset = \"nail hits\"",
            &[
                "waits for \"nail hits\"",
                "there are: nail struck, nail left, nail enters",
            ],
        ),
        (
            "[cycle.outcome]\nhit = \"no nail struck\"",
            &[
                "names \"nail struck\", which is not an event",
                "add one to [cycle.event]",
            ],
        ),
        (
            "[cycle.sensor.valve_lift]\nis = \"nail hits\"",
            &[
                "is \"nail hits\", which is not an expression",
                "the channels of the block are nail.depth, nail.tip",
            ],
        ),
    ]);
}

#[test]
fn fields_are_known_complete_and_of_their_kind() {
    refused(&[
        (
            "[cycle.passage.leak]\ncoeficient = 1",
            &["is not a field of a passage", "did you mean \"coefficient\"?"],
        ),
        (
            "[cycle.volume.extra]\npressure = \"1 bar\"",
            &["has no field `dead`", "dead = \"100 cm3\""],
        ),
        ("[cycle.contact.cap]\nstop = \"left\"", &["none of below, above"]),
        (
            "[cycle.passage.leak]\nseat = { body = \"piston\" }",
            &["more than one of area, seat", "replace = true"],
        ),
        (
            "[cycle.passage.leak]\none_way = 1",
            &["is the number 1, expected true, false or a condition"],
        ),
        ("[cycle.passage.leak]\narea = \"=leak\"", &["`leak` is no key"]),
        ("end = [1]", &["expected a time"]),
        (
            "volumes = {}",
            &["is not a field of a cycle", "did you mean \"volume\"?"],
        ),
    ]);
}

#[test]
fn dimensions_and_domains_are_checked() {
    refused(&[
        (
            "[cycle.passage.leak]\narea = \"3 mm\"",
            &["is a length, expected an area", "mm2"],
        ),
        ("[cycle.passage.leak]\narea = 3", &["the unit is missing", "mm2"]),
        ("[cycle.passage.leak]\narea = \"3 furlong\"", &["furlong"]),
        ("[cycle.passage.leak]\narea = \"-3 mm2\"", &["allowed is from 0"]),
        (
            "[cycle.passage.leak]\narea = \"=disc(tool.mass)\"",
            &["is a quantity in kg2, expected an area"],
        ),
        (
            "[cycle.passage.leak]\narea = \"=piston.bore + tool.mass\"",
            &["it adds a length and a mass"],
        ),
        (
            "[cycle.passage.leak]\narea = \"=piston.boer^2\"",
            &["did you mean `piston.bore`?"],
        ),
        ("[cycle.passage.leak]\narea = \"=piston.bore^2/0\"", &["not finite"]),
        (
            "[cycle.passage.leak]\narea = \"=(piston.bore\"",
            &["ends where ) is expected"],
        ),
        (
            "[cycle.passage.leak]\narea = \"=sqrt(piston.bore)\"",
            &["a length has no square root"],
        ),
        (
            "[cycle.passage.leak]\narea = \"=disk(piston.bore)\"",
            &["`disk` is not a function", "disc"],
        ),
        (
            "[cycle.event.t4]\nbecomes = \"piston.travel > 0.1 s\"",
            &["it compares a length and a time"],
        ),
        (
            "[cycle.event.t4]\nbecomes = \"piston.travel\"",
            &["is a number, expected a condition"],
        ),
        (
            "[cycle.event.t4]\nbecomes = \"piston.travle > 1 mm\"",
            &["did you mean `piston.travel`?"],
        ),
        (
            "[cycle.sensor.valve_lift]\nunit = \"Pa\"",
            &["is a length, expected a pressure"],
        ),
        (
            "[cycle.load.tool]\nroof = \"above_piston.gauge\"",
            &["is a pressure, expected a force"],
        ),
    ]);
}

#[test]
fn circles_are_found() {
    refused(&[
        (
            "[cycle.body.tool]\nparent = \"piston\"",
            &["refers to itself", "piston -> tool -> piston"],
        ),
        (
            "[cycle.let]\nx = \"=2*y\"\ny = \"=x\"\n[cycle.passage.leak]\narea = \"=x\"",
            &["cycle.let.x -> cycle.let.y"],
        ),
        ("[cycle.event.t6]\nafter = \"t9\"", &["refers to itself"]),
        (
            "[cycle.sensor]\na = { is = \"2*b\", unit = \"m\" }\nb = { is = \"a\", unit = \"m\" }",
            &["refers to itself", "a -> b -> a"],
        ),
        (
            "[cycle.passage.foot]\nbetween = [\"below_piston\", \"below_piston\"]",
            &["back to itself"],
        ),
    ]);
}

#[test]
fn laws_of_the_network_are_checked() {
    refused(&[
        (
            "[cycle.face]\npiston_rod = false",
            &[
                "faces of body \"piston\" do not balance: 2827.4 mm2 push down, 2794.3 mm2 up; 33.2 mm2",
                "unbalanced = true",
            ],
        ),
        (
            "[cycle.contact.bumper]\nat = \"130 mm\"",
            &["below_piston", "shrinks to", "\"piston\" at 130.000 mm", "increase"],
        ),
        (
            "[cycle.volume.extra]\ndead = \"1 l\"\npressure = \"1 bar\"",
            &["no passage and no face"],
        ),
        (
            "[cycle.opening.exhaust]\nreplace = true\npassage = \"exhaust\"\nrestriction = \"seat\"",
            &["has no field `area`", "area = \"20 mm2\""],
        ),
        (
            "[cycle.opening.vent]\narea = \"=2*trigger.vent_area\"",
            &[
                "`cycle.opening.vent.area` gives ",
                "but the restriction has",
                "leave out `area` and `diameter`",
            ],
        ),
        (
            "[cycle.opening]\nvent = false",
            &["cycle.passage.vent", "without an opening", "silent = true"],
        ),
        (
            "[cycle.spring.spring]\npreload = \"0.5 mm\"",
            &["by 5.200 mm at the stop \"cap\"", "valid to 5.000 mm"],
        ),
        (
            "[cycle.passage.intake.seat]\nat = \"=head_valve.lift - 1 mm\"",
            &["\"exhaust\" are open together from 3.500 to 3.700 mm of \"head_valve\": hose blows into atmosphere"],
        ),
        (
            "[cycle.fastener.nail]\nhead_at = \"-2 mm\"",
            &[
                "`cycle.fastener.nail` has its head 2.000 mm above the start of \"piston\"",
                "changed at own.toml, line 4, by `cycle.fastener.nail.head_at`",
                "increase `head_at`",
            ],
        ),
        (
            "[cycle.fastener.second]\ndriver = \"piston\"\ninto = \"workpiece\"\nhead_at = \"50 mm\"\n\
             tip_at = \"2 mm\"\nlength = \"50 mm\"\nmass = \"1 g\"\nlaw = { kind = \"constant\", force = \"600 N\" }\n\
             head_stiffness = \"1 kN/mm\"\nunloading = \"5 kN/mm\"",
            &[
                "`cycle.fastener.second.driver` names \"piston\", which drives \"nail\" already",
                "describe both as one fastener",
            ],
        ),
        (
            "[cycle.force.extra]\non = \"tool\"\njet = \"intake\"\nshare = 1",
            &[
                "names \"intake\", which is not a known passage to the atmosphere",
                "exhaust, leak, vent",
            ],
        ),
        (
            "[keys.piston]\nbore = { domain = \"1 .. 2 mm\" }",
            &[
                "`keys.piston.bore` declares a key that every assembly has, from 1e-6 to 100 m",
                "remove the declaration",
            ],
        ),
        ("gas = false", &["has no field `gas`"]),
        (
            "[cycle.load.tool]\nbore = false",
            &[
                "loads on \"tool\" do not add up",
                "1 N of `piston_friction.force` adds 0 N to the loads, but 1 N to the force on the body",
                "add `+ piston_friction.force` to a surface of [cycle.load.tool]",
            ],
        ),
        (
            "[cycle.load.tool]\nrim = \"seat.force + (Ai + Ah3 - A1)*above_piston.gauge\"",
            &[
                "100 kPa of `supply.gauge` adds 0 N to the loads, but 23.5376 N to the force on the body",
                "add `+ A*supply.gauge` with A = 235",
                " mm2 to a surface of [cycle.load.tool]",
            ],
        ),
        (
            "[cycle.load.tool]\nhandle = \"2*hand.force\"",
            &[
                "1 N of `hand.force` adds 2 N to the loads, but 1 N to the force on the body",
                "add `- hand.force`",
            ],
        ),
        (
            "[cycle.load.workpiece]\nextra = \"tool.mass*tool.acceleration\"",
            &["exert no force"],
        ),
    ]);
}

/// A block that an own file adds to the N80CB, or a field, is the place of the error, not the assembly that it changes.
#[test]
fn an_error_of_a_change_is_in_the_file_that_makes_it() {
    let bumper = "[cycle.contact.bumper2]\nacts = { on = \"piston\", against = \"tool\", stop = \"below\", \
                  at = \"60 mm\" }\nstiffness = \"200 N/mm\"";
    let (message, error) = refusal(bumper);
    assert_eq!((error.at.file(), error.at.line()), ("own.toml", 3), "{message}");
    assert!(
        message.contains("1 N of `bumper2.force` adds 0 N to the loads, but 1 N to the force on the body")
            && message.contains("add `+ bumper2.force` to a surface of [cycle.load.tool]"),
        "{message}"
    );
    let (message, error) = refusal("[cycle.passage.leak]\n\nramp = { area = \"3 mm2\", time = \"1 ms\" }");
    assert_eq!((error.at.file(), error.at.line()), ("own.toml", 5), "{message}");
    assert!(message.contains("more than one of area, ramp"), "{message}");
}

/// The jet of the N80CB names the passage `exhaust`, which the change connects to another volume.
#[test]
fn an_error_of_a_base_names_the_change_that_causes_it() {
    let (message, error) = refusal(
        "[cycle.passage.exhaust]\nbetween = [\"above_piston\", \"return_volume\"]\n\
         [cycle.passage.holes]\nbetween = [\"return_volume\", \"atmosphere\"]\narea = \"9 mm2\"\n\
         [cycle.opening.exhaust]\nreplace = true\npassage = \"holes\"\n\
         [cycle.force.thrust]\nif = true\n",
    );
    assert!(error.path.ends_with("thrust.jet"), "{message}");
    assert!(
        message.contains("changed at own.toml, line 4, by `cycle.passage.exhaust.between`"),
        "{message}"
    );
}

#[test]
fn what_is_no_file_or_no_toml_is_refused() {
    let open = |text: &str| AssemblyText::open(&Document::new(Path::new("own.toml"), text));
    for (text, part) in [
        ("[cycle]\nassembly = \"nowhere.toml\"", "cannot be read"),
        ("[cycle]\nassembly = 3", "expected the name of an assembly"),
        ("[cycle]\nassembly = { name = \"x\", schema = 9 }", "expected 1"),
        ("[cycle\n", "not TOML"),
        ("cycle = 3", "expected a table"),
        ("[own]\nx = \"1 mm\"", "is not a key of the assembly"),
        ("[keys.own]\nx = { domain = \"1 .. 2 furlong\" }", "not a domain"),
        (
            "[keys.own]\nx = { domain = \"1 .. 2 m\", txet = \"\" }",
            "is not a field of a declaration",
        ),
    ] {
        let error = open(text).err().unwrap_or_else(|| panic!("accepted: {text}"));
        assert!(error.to_string().contains(part), "{text}: {error}");
    }
}

/// A ball on a spring has no gas, and needs none.
#[test]
fn an_assembly_without_volumes_and_passages_needs_no_gas() {
    let text = r#"
[cycle]
assembly = { name = "ball", schema = 1 }
end = "10 ms"
[cycle.reservoir.atmosphere]
pressure = "101.325 kPa"
temperature = "20 degC"
[cycle.body.ball]
mass = "100 g"
start = { travel = "0 mm" }
[cycle.spring.wire]
on = "ball"
push = "down"
stiffness = "1 N/mm"
preload = "5 mm"
"#;
    let none = std::collections::BTreeMap::<String, KeyValue>::new();
    let resolve = |text: &str| AssemblyText::open(&Document::new(Path::new("ball.toml"), text))?.resolve(&none);
    assert_eq!(resolve(text).map(|own| own.assembly.bodies.len()), Ok(1));
    let volume = "[cycle.volume.air]\ndead = \"1 l\"\npressure = \"=1 bar\"\n";
    let error = resolve(&format!("{text}{volume}")).expect_err("accepted");
    assert!(error.to_string().contains("has no field `gas`"), "{error}");
}

/// The N80CB without the values of its design.
#[test]
fn the_remedy_for_a_key_without_a_value_is_a_base_design() {
    let document = Document::new(Path::new("own.toml"), "[cycle]\nassembly = \"n80cb\"\n");
    let values = std::collections::BTreeMap::<String, KeyValue>::new();
    let error = AssemblyText::open(&document)
        .and_then(|text| text.resolve(&values))
        .expect_err("accepted");
    let message = format!("{error}; {}", error.help());
    assert!(
        message.contains("has no value; give it, or the design that has it, as base ="),
        "{message}"
    );
}
