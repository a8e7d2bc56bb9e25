//! The complete reaction of the air in the full chain.

use std::sync::LazyLock;

use crate::common::run as of;
use crate::tool::{bar, bar_mesh, put};
use nailnoise::Design;
use nailnoise::design::BodyModel;
use nailnoise::result::{FluidLoadingChange, RankedSource};
use nailnoise::run::Run;

/// Coarse block and table by boundary elements with a bar as tool, and other keys.
fn design(text: &str) -> Design {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/over.toml");
    let text = format!("base = \"small-bem.toml\"\nacoustics.body_method = \"bem\"\n{text}\n");
    let mut design = Design::parse(&text, beside).unwrap();
    let tool = bar(1.0);
    design.body = tool.body.clone();
    design.body.model = BodyModel::Elastic;
    design.analysis.body_max_frequency = tool.analysis.body_max_frequency;
    design.sensors.remove("handle"); // the bar has none
    put(&mut design, &bar_mesh(), "loaded-bar.msh");
    design
}

const FULL: &str = "acoustics.fluid_loading = \"full\"";
const BONDED: &str = "support.contact.bonded = true";

static LINEAR: LazyLock<Run> = LazyLock::new(|| of(&design(&format!("{FULL}\n{BONDED}"))));
static OPENING: LazyLock<Run> = LazyLock::new(|| of(&design(FULL)));

fn source<'a>(run: &'a Run, name: &str) -> &'a RankedSource {
    run.result.ranking.iter().find(|source| source.source == name).unwrap()
}

fn change<'a>(run: &'a Run, name: &str) -> &'a FluidLoadingChange {
    run.result
        .fluid_loading_changes
        .iter()
        .find(|change| change.source == name)
        .unwrap()
}

#[test]
fn every_check_of_linear_motion_in_air_is_met_its_energy_balance_among_them() {
    let failed: Vec<_> = LINEAR.result.checks.iter().filter(|check| !check.ok).collect();
    assert!(failed.is_empty(), "{failed:#?}");
    for name in ["response", "tool"] {
        let balance = format!("{name}: energy beyond the frozen impedance, balance over time");
        assert!(
            LINEAR.result.checks.iter().any(|check| check.name == balance),
            "{balance}"
        );
    }
}

#[test]
fn the_bonded_motion_that_a_contact_which_opens_is_compared_with_has_its_checks() {
    let checks = OPENING.result.checks.iter();
    let own: Vec<_> = checks
        .filter(|check| check.name.starts_with("bonded for comparison: "))
        .collect();
    assert!(
        own.iter().any(|check| check.name.ends_with("balance over time")),
        "{own:?}"
    );
    assert!(own.iter().all(|check| check.ok), "{own:?}");
}

#[test]
fn on_a_bonded_contact_the_complete_impedance_acts_on_every_source() {
    for name in ["workpiece", "body"] {
        let change = change(&LINEAR, name);
        assert!(change.complete_acts);
        let level = source(&LINEAR, name).lwa_db.unwrap();
        assert!(
            (change.complete_lwa_db.unwrap() - level).abs() < 0.01,
            "{name}: {change:?}, {level}"
        );
        let db = change.change_db().unwrap();
        assert!(db != 0.0 && db.abs() < 0.2, "{name}: {db}");
    }
}

#[test]
fn a_contact_that_opens_keeps_the_frozen_impedance_and_states_the_change_with_a_bonded_one() {
    let (opening, linear) = (change(&OPENING, "workpiece"), change(&LINEAR, "workpiece"));
    assert!(!opening.complete_acts && change(&OPENING, "body").complete_acts);
    assert_eq!(opening.frozen_lwa_db, linear.frozen_lwa_db);
    assert_eq!(opening.complete_lwa_db, linear.complete_lwa_db);
    let response = "response: energy beyond the frozen impedance, balance over time";
    assert!(OPENING.result.checks.iter().all(|check| check.name != response));
    let stated =
        |note: &String| note.contains("change by the complete impedance") && note.contains("with every contact bonded");
    assert!(
        OPENING.result.method_notes.iter().any(stated),
        "{:#?}",
        OPENING.result.method_notes
    );
}

#[test]
fn radiation_as_damping_alone_has_nothing_to_complete() {
    let run = of(&design(BONDED));
    assert!(run.result.fluid_loading_changes.is_empty());
    assert!(
        run.result
            .checks
            .iter()
            .all(|check| !check.name.contains("frozen impedance"))
    );
}
