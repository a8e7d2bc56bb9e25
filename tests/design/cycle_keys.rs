//! The text of the N80CB and the keys of a design, which Rust declares, do not drift apart.

use std::collections::{BTreeMap, BTreeSet};

use nailnoise::design::Design;
use nailnoise::design::inputs::cycle::parameters;
use nailnoise_dynamics::network::{AssemblyText, KeyValue};
use nailnoise_quantities::Group as _;
use nailnoise_quantities::dimension::{DAMPING, STIFFNESS};

/// Values that together switch every block of the text on and off, and take every branch of its formulas.
const CASES: &[&str] = &[
    "",
    "model.gas = \"published\"\nmodel.valve_underside = \"published\"\nmodel.nail = \"published\"\n\
     model.impact = \"published\"\nmodel.contacts = \"published\"\nmodel.intake = \"published\"\n\
     model.delay = \"published\"\nmodel.channel = \"published\"\nmodel.refill = \"published\"",
    "model.blow = \"elastic\"",
    "hand.mass = \"8 kg\"",
    "trigger.release_after = \"60 ms\"",
    "exhaust.thrust_share = 0.5",
    "exhaust.muffler.kind = \"insertion_loss\"",
    "wood.penetration_law = \"constant\"",
    "wood.rate = \"speed\"",
    "wood.head_law = \"yields\"",
    "wood.ring_amplitude = 0.2",
];

/// Keys of the cycle that no formula reads, and who reads them instead.
const ELSEWHERE: &[(&str, &str)] = &[];

fn design(case: &str) -> Design {
    let text = format!("base = \"n80cb.toml\"\n{case}\n");
    Design::parse(&text, "designs/over.toml").unwrap_or_else(|error| panic!("{case}: {error}"))
}

/// Values of the declared keys of a design, and of what it derives for its assembly.
fn declared(design: &Design) -> BTreeMap<String, KeyValue> {
    let mut keys = BTreeMap::new();
    design.visit("", &mut |path, spec, value| {
        keys.insert(path.to_owned(), KeyValue::of(spec, &value));
    });
    for (path, si, dimension) in [("support.stiffness", 1e8, STIFFNESS), ("support.damping", 1e3, DAMPING)] {
        keys.insert(path.to_owned(), KeyValue::Quantity { si, dimension });
    }
    keys
}

/// The keys that the text reads in all cases. Every one must be declared, in the dimension of its field.
fn read_by_text() -> BTreeSet<String> {
    let text = AssemblyText::built_in("n80cb").unwrap().unwrap();
    let mut read = BTreeSet::new();
    for case in CASES {
        let resolved = text.resolve(&declared(&design(case)));
        let resolved = resolved.unwrap_or_else(|error| panic!("{case}: {error}; {}", error.help()));
        read.extend(resolved.keys);
    }
    read
}

#[test]
fn every_key_that_the_text_reads_is_declared_in_the_dimension_of_its_field() {
    let keys = declared(&design(""));
    for key in read_by_text() {
        assert!(keys.contains_key(&key), "{key}");
    }
}

#[test]
fn every_key_of_the_cycle_is_read_by_the_text_or_elsewhere() {
    let (base, mut of_cycle) = (declared(&design("")), parameters(&design("")).unwrap().keys());
    of_cycle.retain(|key, _| base.contains_key(key));
    let read = read_by_text();
    let unread: Vec<&str> = of_cycle
        .keys()
        .filter(|key| !read.contains(*key))
        .map(String::as_str)
        .collect();
    let elsewhere: Vec<&str> = ELSEWHERE.iter().map(|(key, _)| *key).collect();
    assert_eq!(unread, elsewhere, "a key without an effect, or a reason without a key");
}

/// The names of a text are read from its characters, so that a branch which no case takes is found too.
#[test]
fn the_cases_take_every_branch_of_the_text() {
    let text = AssemblyText::built_in("n80cb").unwrap().unwrap();
    let keys = declared(&design(""));
    let read = read_by_text();
    for field in text.fields() {
        let names = field
            .text
            .split(|c: char| !(c.is_ascii_alphanumeric() || c == '_' || c == '.'));
        let names = names.map(|name| name.strip_prefix("key.").unwrap_or(name));
        for name in names.filter(|name| keys.contains_key(*name)) {
            // `supply.pressure` is also a channel of the volume of this name, and `piston.friction` a group.
            assert!(read.contains(name), "{}: {name} is in no case", field.path);
        }
    }
}
