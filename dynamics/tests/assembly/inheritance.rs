//! Assemblies that change others, their own keys, and literals as keys.

use std::collections::BTreeMap;
use std::path::Path;

use nailnoise_documents::Document;
use nailnoise_dynamics::network::assembly::{Assembly, Coefficient, Opens};
use nailnoise_dynamics::network::{AssemblyText, KeyValue, Resolved};
use nailnoise_quantities::dimension::VOLUME;

use crate::common;
use crate::keys::keys;

fn read(documents: &[&str], more: &[(&str, KeyValue)]) -> Resolved {
    let documents: Vec<Document> = documents
        .iter()
        .map(|text| Document::new(Path::new("own.toml"), text))
        .collect();
    let mut keys = keys(&common::n80cb());
    keys.extend(more.iter().map(|(path, value)| ((*path).to_owned(), value.clone())));
    let text = AssemblyText::open_design(&documents).unwrap_or_else(|error| panic!("{error}; {}", error.help()));
    text.resolve(&keys)
        .unwrap_or_else(|error| panic!("{error}; {}", error.help()))
}

fn passages(assembly: &Assembly) -> Vec<&str> {
    assembly.passages.iter().map(|passage| passage.name.as_str()).collect()
}

const CHAMBER: &str = "[cycle]\nassembly = \"n80cb_chamber\"\n";

#[test]
fn a_design_without_a_cycle_has_the_built_in_assembly() {
    let plain = read(&["[tool]\nmass = \"3 kg\"\n"], &[]);
    assert_eq!(
        (plain.assembly.name.as_str(), plain.assembly.volumes.len()),
        ("n80cb", 5)
    );
    assert_eq!(plain.assembly, read(&[], &[]).assembly);
}

#[test]
fn blocks_merge_field_by_field_and_new_ones_are_appended() {
    let base = read(&[], &[]).assembly;
    let changed = read(&["[cycle.passage.leak]\ncoefficient = 0.5\n"], &[]).assembly;
    let leak = |assembly: &Assembly| assembly.passages[4].clone();
    assert_eq!(leak(&changed).restrictions[0].coefficient, Coefficient::Constant(0.5));
    assert_eq!(leak(&changed).restrictions[0].opens, leak(&base).restrictions[0].opens);
    let chamber = read(&[CHAMBER], &[]).assembly;
    assert_eq!(passages(&chamber)[..8], passages(&base)[..]);
    assert_eq!(
        (passages(&chamber)[8], chamber.volumes[5].name.as_str()),
        ("holes", "silencer")
    );
}

/// A literal of the passage then changes both.
#[test]
fn an_opening_without_an_area_has_the_constant_area_of_its_passage() {
    let own = "[cycle]\nassembly = \"n80cb\"\n[cycle.passage.vent]\narea = \"7 mm2\"\n\
               [cycle.opening.vent]\nreplace = true\npassage = \"vent\"\n";
    let vent = read(&[own], &[]).assembly.openings[1].clone();
    assert_eq!((vent.name.as_str(), vent.area, vent.count), ("vent", 7e-6, 1.0));
}

#[test]
fn replace_drops_the_fields_of_the_base() {
    let chamber = read(&[CHAMBER], &[]).assembly;
    let exhaust = &chamber.passages[1];
    assert_eq!(exhaust.restrictions.len(), 1, "the series of the base is gone");
    assert!(matches!(exhaust.restrictions[0].opens, Opens::Seat { .. }));
}

#[test]
fn false_removes_a_block() {
    let without = read(&["[cycle.passage]\nleak = false\n"], &[]).assembly;
    assert!(!passages(&without).contains(&"leak"));
}

#[test]
fn a_later_file_changes_an_earlier_one_and_keeps_the_range_of_a_literal() {
    let resolved = read(&[CHAMBER, "[cycle.volume]\nsilencer.dead = \"150 cm3\"\n"], &[]);
    let dead = resolved
        .literals
        .iter()
        .find(|literal| literal.path == "cycle.volume.silencer.dead");
    let dead = dead.unwrap_or_else(|| panic!("{:?}", resolved.literals));
    assert!((dead.si - 150e-6).abs() < 1e-18 && (resolved.assembly.volumes[5].dead - dead.si).abs() < 1e-18);
    let [low, high] = dead.range.unwrap_or([f64::NAN; 2]);
    assert!((low - 20e-6).abs() < 1e-18 && (high - 300e-6).abs() < 1e-18);
    assert_eq!(dead.provenance, "decided: fits behind the cap");
}

#[test]
fn a_literal_is_a_key_that_can_be_set_and_used_in_formulas() {
    let value = KeyValue::Quantity {
        si: 80e-6,
        dimension: VOLUME,
    };
    let set = [("cycle.volume.silencer.dead", value)];
    let text = format!(
        "{CHAMBER}[cycle.volume.foot_volume]\ndead = \"=2*cycle.volume.silencer.dead\"\npressure = \"1 \
         bar\"\n[cycle.passage.extra]\nbetween = [\"foot_volume\", \"return_volume\"]\narea = \"1 mm2\"\n"
    );
    let assembly = read(&[&text], &set).assembly;
    assert_eq!((assembly.volumes[5].dead, assembly.volumes[6].dead), (80e-6, 160e-6));
}

#[test]
fn an_own_assembly_declares_its_keys_with_values_that_a_design_may_replace() {
    let own = "[cycle]\nassembly = \"blow_gun\"\n[nozzle]\ndiameter = \"3 mm\"\n";
    let document = Document::new(Path::new("own.toml"), own);
    let text = AssemblyText::open(&document).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(text.declared()["nozzle.diameter"].text, "bore of the nozzle");
    let none: BTreeMap<String, KeyValue> = BTreeMap::new();
    let resolved = text
        .resolve(&none)
        .unwrap_or_else(|error| panic!("{error}; {}", error.help()));
    let diameter = resolved
        .literals
        .iter()
        .find(|literal| literal.path == "nozzle.diameter");
    let diameter = diameter.unwrap_or_else(|| panic!("{:?}", resolved.literals));
    assert_eq!((diameter.si, diameter.range), (3e-3, Some([1e-3, 5e-3])));
    assert!(resolved.keys.contains("gun.volume") && resolved.keys.contains("ambient.pressure"));
}

#[test]
fn gauge_pressures_count_from_the_atmosphere() {
    let none: BTreeMap<String, KeyValue> = BTreeMap::new();
    let text = AssemblyText::built_in("blow_gun").unwrap_or_else(|| panic!("no blow gun"));
    let text = text.unwrap_or_else(|error| panic!("{error}"));
    let resolved = text
        .resolve(&none)
        .unwrap_or_else(|error| panic!("{error}; {}", error.help()));
    let hose = resolved.assembly.reservoirs[1].pressure;
    assert!((hose - 701_325.0).abs() < 1e-6, "{hose}");
}
