//! Lines of a design file in TOML: keys with values, units and ranges.

use crate::design::{Entry, Name, Value};

/// The line of a key with a normal distribution. The ends of its range are two standard deviations from the middle.
pub(super) fn normal_distribution(
    entry: &Entry,
    value: &Value,
    [low, high]: [f64; 2],
    provenance: &toml::Value,
) -> String {
    let unit = unit_suffix(&entry.unit);
    format!(
        "{} = {{ value = {}, range = \"{low:?} .. {high:?}{unit}\", distribution = \"normal\", \
         provenance = {provenance} }}",
        entry.key,
        toml_value(value, &entry.unit)
    )
}

/// Suffix of a number: a space and its unit, or nothing if it is dimensionless.
pub(super) fn unit_suffix(unit: &str) -> String {
    if unit.is_empty() {
        String::new()
    } else {
        format!(" {unit}")
    }
}

/// Formats a value as TOML, with its unit.
pub(super) fn toml_value(value: &Value, unit: &str) -> String {
    match value {
        Value::Count(count) => count.to_string(),
        Value::Number(number) if unit.is_empty() => format!("{number:?}"),
        Value::Number(number) => format!("\"{number:?} {unit}\""),
        Value::Switch(on) => on.to_string(),
        Value::Choice(word) => format!("\"{word}\""),
        Value::File(text) | Value::Name(Name(text)) => toml::Value::String(text.clone()).to_string(),
    }
}
