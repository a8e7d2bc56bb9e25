//! Parameters of the base design, read from its file.
#![allow(clippy::unwrap_used)] // a test may panic, in its helpers too

use std::path::Path;

use nailnoise_dynamics::{Parameters, Support, SupportDamping};
use nailnoise_quantities::dimension::{NUMBER, STIFFNESS};
use nailnoise_quantities::{Found, Group, Kind, Value, nonnegative, positive, quantity};

/// The cycle's parameters of `designs/n80cb.toml`: an 80 mm coil nailer drives a 12d nail into pine on a worktable.
pub(crate) fn n80cb() -> Parameters {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../designs/n80cb.toml");
    let design: toml::Table = std::fs::read_to_string(path).unwrap().parse().unwrap();
    let table = &design["support"]["worktable"];
    let number = |key: &str, kind| match value(&table[key], kind) {
        Value::Number(number) => number,
        other => panic!("{other:?}"),
    };
    Parameters {
        supply: group(&design, "supply"),
        piston: group(&design, "piston"),
        head_valve: group(&design, "head_valve"),
        chambers: group(&design, "chambers"),
        exhaust: group(&design, "exhaust"),
        muffler_area: None,
        trigger: group(&design, "trigger"),
        nail: group(&design, "nail"),
        wood: group(&design, "wood"),
        penetration_table: None,
        workpiece: group(&design, "workpiece"),
        contacts: group(&design, "contacts"),
        tool: group(&design, "tool"),
        hand: group(&design, "hand"),
        support: Support {
            stiffness: number("stiffness", positive(STIFFNESS)),
            damping: SupportDamping::Ratio(number("damping_ratio", nonnegative(NUMBER))),
        },
        ambient: group(&design, "ambient"),
        model: group(&design, "model"),
    }
}

/// The group `path` of a design without a base.
fn group<G: Group>(design: &toml::Table, path: &str) -> G {
    let mut found = Found::new();
    G::SPEC.each_key(path, &mut |key, spec| {
        let given = key.split('.').fold(None, |at: Option<&toml::Value>, name| match at {
            None => design.get(name),
            Some(table) => table.get(name),
        });
        found.insert(key.to_owned(), value(given.unwrap(), spec.kind));
    });
    G::build(path, &found).unwrap()
}

/// A value alone, or beside its range and provenance.
fn value(given: &toml::Value, kind: Kind) -> Value {
    let given = given.get("value").unwrap_or(given);
    match (kind, given) {
        (Kind::Quantity { dimension, gauge, .. }, toml::Value::String(text)) => {
            Value::Number(quantity(text, dimension, gauge).unwrap().absolute(101_325.0))
        }
        (Kind::Quantity { .. }, toml::Value::Integer(integer)) => Value::Number(*integer as f64),
        (Kind::Quantity { .. }, toml::Value::Float(float)) => Value::Number(*float),
        (Kind::Count, toml::Value::Integer(integer)) => Value::Count(u32::try_from(*integer).unwrap()),
        (Kind::Choice(words), toml::Value::String(word)) => {
            Value::Choice(words.iter().find(|own| **own == word.as_str()).unwrap())
        }
        other => panic!("{other:?}"),
    }
}
