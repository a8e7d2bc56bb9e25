//! Designs of other tools, scaled from the N80CB: each drives, is marked and similar, and the documentation states
//! the rules.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use nailnoise::chain;
use nailnoise::design::{Provenance, Value};
use nailnoise::scaling::{BASE, RATED, Request, Rules, Scaled, scaled};
use nailnoise::{Design, Error};
use nailnoise_dynamics::Outcome;

fn of(class: &str) -> Request {
    Request {
        class: class.to_owned(),
        base: BASE,
        bore: None,
        stroke: None,
        mass: None,
        fastener: None,
    }
}

fn design(scaled: &Scaled) -> Design {
    Design::parse(&scaled.text, concat!(env!("CARGO_MANIFEST_DIR"), "/designs/own.toml")).unwrap()
}

#[test]
fn every_class_drives_its_fastener_within_the_rated_pressure_without_a_warning() {
    for class in Rules::load().unwrap().names() {
        let scaled = scaled(&of(class), "own.toml").unwrap();
        let (settled, design) = (&scaled.settled, design(&scaled));
        assert!(settled.shot.drives(), "{class}: {settled:?}");
        assert!((RATED[0]..=RATED[1]).contains(&settled.setting.pressure), "{class}");
        assert!(settled.shot.head_depth >= 0.0, "{class}: {settled:?}");
        assert!(design.warnings().is_empty(), "{class}: {:?}", design.warnings());
        // The file itself drives, not only the design of the trial.
        let outcome = chain::cycle(&design).unwrap().figures.outcome;
        assert_eq!(outcome, settled.shot.outcome, "{class}");
    }
}

#[test]
fn every_scaled_value_is_marked_and_lies_within_its_range() {
    for class in ["finish-nailer", "stapler"] {
        let scaled = scaled(&of(class), "own.toml").unwrap();
        let mut marked = 0;
        for entry in design(&scaled).entries() {
            let Value::Number(value) = entry.value else { continue };
            if let Some([low, high]) = entry.range {
                assert!(low <= value && value <= high, "{class}: {}", entry.key);
            }
            if entry.provenance == Provenance::Scaled && !entry.key.starts_with("sensors.") {
                assert!(
                    entry.range.is_some_and(|[low, high]| low < high),
                    "{class}: {}",
                    entry.key
                );
                marked += 1;
            }
        }
        assert!(marked > 50, "{class}: {marked} values are marked");
    }
}

/// With areas as bore^2 and volumes and masses as stroke bore^2 the shot is similar: speeds are those of the base,
/// and the energy is as the swept volume. Hose, friction and gravity are not similar.
#[test]
fn the_energy_of_a_stroke_is_as_the_swept_volume() {
    let energy = |bore: f64, stroke: f64| {
        let request = Request {
            bore: Some(bore),
            stroke: Some(stroke),
            fastener: Some("8d smooth".parse().unwrap()),
            mass: Some(4.29 * (bore / 60e-3).powi(2) * stroke / 121.25e-3),
            ..of("framing-nailer")
        };
        scaled(&request, "own.toml").unwrap().settled.tool_energy.unwrap() / (bore * bore * stroke)
    };
    let base = energy(60e-3, 121.25e-3);
    for (bore, stroke) in [(50e-3, 121.25e-3), (60e-3, 90e-3), (50e-3, 100e-3)] {
        let ratio = energy(bore, stroke) / base;
        assert!((ratio - 1.0).abs() < 0.1, "{bore} m, {stroke} m: {ratio}");
    }
}

#[test]
fn the_base_scaled_to_its_own_size_is_the_base() {
    let design = design(&scaled(&of("framing-nailer"), "own.toml").unwrap());
    let base = Design::shipped(BASE).unwrap();
    assert!((design.piston.mass - base.piston.mass).abs() < 1e-12);
    assert!((design.chambers.supply_volume - base.chambers.supply_volume).abs() < 1e-12);
    assert!((design.tool.mass / base.tool.mass - 1.0).abs() < 1e-3);
}

#[test]
fn a_tool_that_is_too_weak_is_told_as_such() {
    let request = Request {
        bore: Some(30e-3),
        fastener: Some("12d smooth".parse().unwrap()),
        stroke: Some(121.25e-3),
        ..of("framing-nailer")
    };
    let settled = scaled(&request, "own.toml").unwrap().settled;
    assert_eq!(settled.shot.outcome, Outcome::Underdriven);
    assert!(settled.shot.head_depth < -0.01 && settled.needed > settled.shot.energy_at_nail);
    assert_eq!(settled.setting.pressure, RATED[1], "told at the highest rated pressure");
}

#[test]
fn dimensions_that_do_not_go_together_are_refused_with_the_option_to_change() {
    let request = Request {
        stroke: Some(60e-3),
        fastener: Some("12d smooth".parse().unwrap()),
        ..of("framing-nailer")
    };
    let Err(Error::Scaling(error)) = scaled(&request, "own.toml") else {
        panic!("a nail longer than the stroke");
    };
    assert!(error.remedy().contains("--stroke"), "{error}");
}

/// The published energy of a roofing nailer, 410 in lbf at 100 psig (Builder, 2004), within the 25 % that the moving
/// mass and the areas of a scaled tool are uncertain by.
#[test]
fn a_roofing_nailer_has_the_energy_that_its_maker_states() {
    let scaled = scaled(&of("roofing-nailer"), "own.toml").unwrap();
    let (published, _) = scaled.published.clone().unwrap();
    assert!((published - 410.0 * 0.0254 * 4.448_222).abs() < 0.05);
    let energy = scaled.settled.tool_energy.unwrap();
    let ratio = energy / published;
    assert!((0.8..1.25).contains(&ratio), "{energy} J");
}

/// A tool on another support has the keys of the scaled tool and of the support, and drives its fastener.
#[test]
fn every_class_drives_its_fastener_on_the_supports_of_a_site() {
    for support in [
        "site/sawhorses.toml",
        "site/joists.toml",
        "site/studs.toml",
        "site/held-board.toml",
    ] {
        let on = Design::shipped(support).unwrap();
        for class in Rules::load().unwrap().names() {
            let request = Request {
                base: support,
                ..of(class)
            };
            let scaled = scaled(&request, "own.toml").unwrap();
            let design = Design::parse(&scaled.text, "own.toml").unwrap();
            assert!(scaled.settled.shot.drives(), "{class} on {support}");
            assert_eq!(design.support.kind, on.support.kind, "{class} on {support}");
            assert_eq!(
                design.workpiece.thickness, on.workpiece.thickness,
                "{class} on {support}"
            );
        }
    }
}

#[test]
fn every_key_of_a_rule_is_a_number_of_the_base_and_has_one_rule() {
    let rules = Rules::load().unwrap();
    let entries = Design::shipped(BASE).unwrap().entries();
    let mut seen = BTreeSet::new();
    for key in rules.rules.iter().flat_map(|rule| &rule.keys) {
        let entry = entries.iter().find(|entry| entry.key == *key);
        assert!(
            entry.is_some_and(|entry| matches!(entry.value, Value::Number(_))),
            "{key}"
        );
        assert!(seen.insert(key.clone()), "{key} has two rules");
    }
}

/// Classes and rules as the tables of the documentation.
fn tables(rules: &Rules) -> String {
    let mut text = "| class | drives | bore | stroke | mass | fastener | source of the defaults |\n".to_owned();
    text.push_str("|---|---|---|---|---|---|---|\n");
    for (name, own) in &rules.classes {
        let _ = writeln!(
            text,
            "| `{name}` | {} | {} | {} | {} | `{}` | {} |",
            own.what, own.bore, own.stroke, own.mass, own.nail, own.source
        );
    }
    text.push_str("\n| what | factor | keys |\n|---|---|---|\n");
    for rule in &rules.rules {
        let keys: Vec<String> = rule.keys.iter().map(|key| format!("`{key}`")).collect();
        let _ = writeln!(text, "| {} | `{}` | {} |", rule.what, rule.law(), keys.join(", "));
    }
    text
}

/// `NAILNOISE_UPDATE_DOCS=1` writes the tables.
#[test]
fn the_documentation_states_the_rules() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/own-tool.md");
    let page = std::fs::read_to_string(path).unwrap();
    let [start, end] = ["<!-- rules of scaling -->\n", "<!-- end of the rules -->"];
    let (head, rest) = page.split_once(start).unwrap();
    let (_, tail) = rest.split_once(end).unwrap();
    let expected = format!("{head}{start}{}{end}{tail}", tables(&Rules::load().unwrap()));
    if std::env::var_os("NAILNOISE_UPDATE_DOCS").is_some() {
        std::fs::write(path, &expected).unwrap();
    } else {
        assert_eq!(page, expected, "NAILNOISE_UPDATE_DOCS=1 writes the tables");
    }
}
