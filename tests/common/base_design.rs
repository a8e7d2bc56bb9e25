//! Groups of the base design, read from its file, for the tests of crates that do not depend on design files.
#![allow(clippy::unwrap_used)] // a test may panic, in its helpers too

use std::path::Path;
use std::sync::LazyLock;

use nailnoise_quantities::{Found, Group, Kind, Value, quantity};

static DESIGN: LazyLock<toml::Table> = LazyLock::new(|| {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../designs/n80cb.toml");
    std::fs::read_to_string(path).unwrap().parse().unwrap()
});

/// The group `path` of `designs/n80cb.toml`: an 80 mm coil nailer drives a 12d nail into pine on a worktable.
pub(crate) fn group<G: Group>(path: &str) -> G {
    let mut found = Found::new();
    G::SPEC.each_key(path, &mut |key, spec| {
        found.insert(key.to_owned(), value(key, spec.kind));
    });
    G::build(path, &found).unwrap()
}

/// The number under this key.
pub(crate) fn number(key: &str, kind: Kind) -> f64 {
    match value(key, kind) {
        Value::Number(number) => number,
        other => panic!("{other:?}"),
    }
}

/// A value, with or without its range and provenance.
fn value(key: &str, kind: Kind) -> Value {
    let given = key.split('.').fold(None, |at: Option<&toml::Value>, name| match at {
        None => DESIGN.get(name),
        Some(table) => table.get(name),
    });
    let given = given.unwrap();
    let given = given.get("value").unwrap_or(given);
    match (kind, given) {
        (Kind::Quantity { dimension, gauge, .. }, toml::Value::String(text)) => {
            Value::Number(quantity(text, dimension, gauge).unwrap().absolute(101_325.0))
        }
        (Kind::Quantity { .. }, toml::Value::Integer(integer)) => Value::Number(*integer as f64),
        (Kind::Quantity { .. }, toml::Value::Float(float)) => Value::Number(*float),
        (Kind::Count(_), toml::Value::Integer(integer)) => Value::Count(u32::try_from(*integer).unwrap()),
        (Kind::Choice(words), toml::Value::String(word)) => {
            Value::Choice(words.iter().find(|own| **own == word.as_str()).unwrap())
        }
        other => panic!("{other:?}"),
    }
}
