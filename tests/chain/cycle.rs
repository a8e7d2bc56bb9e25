//! From the design file to the cycle: every key of the tool reaches the model.

use nailnoise::design::inputs::cycle::parameters;
use nailnoise::design::{Design, Value};

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
        let law = if entry.key == "wood.penetration_force" {
            "wood.penetration_law = \"constant\""
        } else {
            ""
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
