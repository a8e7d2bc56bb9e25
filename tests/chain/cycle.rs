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

/// The names and the order of the columns are an interface. The switches of a design do not change them, and a later
/// version may append columns.
#[test]
fn columns_of_a_design_by_keys_keep_their_names_and_order() {
    let of = |quantities: &[&str], blocks: &[&str]| -> Vec<String> {
        let pairs = blocks
            .iter()
            .flat_map(|block| quantities.iter().map(move |own| format!("{block}_{own}")));
        pairs.collect()
    };
    let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    let volumes = ["above_piston", "below_piston", "return_volume", "above_valve", "supply"];
    let forces = "piston_gas valve_gas bumper stopper cap seat spring piston_friction valve_friction penetration nose \
                  guard support hand";
    let expected = [
        of(
            &["position", "velocity", "acceleration"],
            &["piston", "head_valve", "tool", "workpiece"],
        ),
        words("piston_travel valve_lift tip_depth nail_depth moving_mass"),
        of(&["pressure", "temperature", "mass"], &volumes),
        of(&["force"], &forces.split_whitespace().collect::<Vec<_>>()),
        words("exhaust_mass_flow exhaust_plenum_pressure exhaust_back_pressure exhaust_stagnation_temperature"),
        words("intake_mass_flow vent_mass_flow vent_pressure vent_temperature magazine_force thrust_force"),
        words("piston_speed head_valve_travel head_valve_speed"),
    ]
    .concat();
    for text in [
        "",
        "nail.magazine_friction = \"1 N\"\nexhaust.thrust_share = 0.5",
        "hand.mass = \"1.5 kg\"",
    ] {
        let record = nailnoise::chain::cycle(&small(text)).unwrap();
        let columns = columns(&record.record);
        let names: Vec<&str> = columns.iter().map(|column| column.name).collect();
        assert_eq!(names, expected, "{text}");
        assert!(
            columns
                .iter()
                .all(|column| !column.unit.is_empty() && column.values.len() == record.len())
        );
    }
}
