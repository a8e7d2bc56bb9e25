//! From the design file to the cycle: every key of the tool reaches the model.

use nailnoise::design::inputs::cycle::parameters;
use nailnoise::design::{Design, Value};
use nailnoise::output::columns;

use crate::common::small;

/// Groups whose numbers are the cycle's.
const GROUPS: &[&str] = &[
    "supply",
    "piston",
    "head_valve",
    "chambers",
    "exhaust",
    "trigger",
    "nail",
    "wood",
    "workpiece",
    "contacts",
    "tool",
    "hand",
    "ambient",
    "model",
];

/// Keys of these groups that belong to the structures and to the sound.
const STRUCTURES: &[&str] = &[
    "exhaust.pitch",
    "exhaust.plenum.",
    // A fitting filters sound and leaves the cycle unchanged; a muffler acts if present.
    "exhaust.fitting.",
    "exhaust.muffler.",
    "workpiece.board.",
    "workpiece.mesh_unit",
    "nail.offset_along",
    "nail.offset_across",
    "wood.loss_factor",
    "wood.elastic.",
];

#[test]
fn every_number_of_the_tool_reaches_the_model() {
    let load = |text: &str| {
        Design::parse(&format!("base = \"n80cb.toml\"\n{text}\n"), "designs/over.toml")
            .unwrap_or_else(|error| panic!("{text}: {error}"))
    };
    let base = load("");
    let reference = parameters(&base).expect("the base design has parameters");
    let mut tried = 0;
    for entry in base.entries() {
        let group = entry.key.split('.').next().unwrap_or("");
        let structural = STRUCTURES.iter().any(|own| entry.key.starts_with(own));
        let Value::Number(value) = entry.value else { continue };
        // A law's own force acts with that law.
        let law = match entry.key.as_str() {
            "wood.penetration_force" => "wood.penetration_law = \"constant\"",
            "wood.crushing_rate" | "wood.friction_at_rest" | "wood.friction_sliding" | "wood.friction_speed" => {
                "wood.rate = \"speed\""
            }
            "wood.head_yield_scale" => "wood.head_law = \"yields\"",
            "wood.ring_width" => "wood.ring_amplitude = 0.2",
            "wood.shear_speed" | "piston.rod_length" | "piston.rod_modulus" => "model.blow = \"elastic\"",
            _ => "",
        };
        if structural || !(GROUPS.contains(&group) || entry.key == "support.worktable.stiffness") {
            continue;
        }
        // Downwards, since lift and preload use up the range of the spring's law.
        let changed = if value == 0.0 { 1e-4 } else { value * (1.0 - 1e-4) };
        let design = load(&format!("{law}\n{} = {changed:e}", entry.key));
        let found = parameters(&design).expect("a changed design has parameters");
        let reference = if law.is_empty() {
            reference.clone()
        } else {
            parameters(&load(law)).expect("a law")
        };
        assert_ne!(found, reference, "{} has no effect", entry.key);
        tried += 1;
    }
    assert!(tried > 80, "{tried} keys tried");
}

/// Every list of numbers in the record has its column, each of them once and with a unit.
#[test]
fn every_history_of_the_record_is_a_column() {
    let record = nailnoise::chain::cycle(&small("")).unwrap();
    let mut histories = Vec::new();
    let mut open = vec![serde_json::to_value(&record).unwrap()];
    while let Some(value) = open.pop() {
        match value {
            serde_json::Value::Array(own) if own.len() == record.len() && own[0].is_number() => {
                histories.push(own.iter().map(|value| value.as_f64().unwrap()).collect::<Vec<_>>());
            }
            serde_json::Value::Array(own) => open.extend(own),
            serde_json::Value::Object(own) => open.extend(own.into_iter().map(|(_, value)| value)),
            _ => {}
        }
    }
    let columns = columns(&record);
    assert_eq!(columns.len(), histories.len());
    assert!(
        histories
            .iter()
            .all(|own| columns.iter().any(|column| column.values == own))
    );
    let names: std::collections::BTreeSet<&str> = columns.iter().map(|column| column.name.as_str()).collect();
    assert_eq!(names.len(), columns.len());
    assert!(columns.iter().all(|column| !column.unit.is_empty()));
    for name in ["magazine_force", "thrust_force", "piston_velocity"] {
        assert!(names.contains(name), "{name}");
    }
}
