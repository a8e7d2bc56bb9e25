//! A key of a design file with a value and a normal distribution.

use crate::design::{Entry, Name, Value};

/// The line of a key. The ends of its range are two standard deviations from the middle.
pub(super) fn normal_key(entry: &Entry, value: &Value, [low, high]: [f64; 2], provenance: &toml::Value) -> String {
    let unit = with_space(&entry.unit);
    format!(
        "{} = {{ value = {}, range = \"{low:?} .. {high:?}{unit}\", distribution = \"normal\", \
         provenance = {provenance} }}",
        entry.key,
        shown(value, &unit)
    )
}

/// A unit after a space; nothing for plain numbers.
pub(super) fn with_space(unit: &str) -> String {
    if unit.is_empty() {
        String::new()
    } else {
        format!(" {unit}")
    }
}

/// Formats a value as TOML, with its unit.
pub(super) fn shown(value: &Value, unit: &str) -> String {
    match value {
        Value::Count(count) => count.to_string(),
        Value::Number(number) if unit.is_empty() => format!("{number:?}"),
        Value::Number(number) => format!("\"{number:?}{unit}\""),
        Value::Switch(on) => on.to_string(),
        Value::Choice(word) => format!("\"{word}\""),
        Value::File(text) | Value::Name(Name(text)) => toml::Value::String(text.clone()).to_string(),
    }
}
