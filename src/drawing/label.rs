//! Texts for the keys of a drawing: value in a common unit, symbol, provenance.

use std::collections::BTreeMap;

use nailnoise_quantities::Group as _;

use super::standing::Standing;
use crate::design::{Design, Entry, Value, Values};
use crate::wording::rounded;

/// A key as a drawing shows it.
#[derive(Debug, Clone, PartialEq)]
pub struct Label {
    /// Full name.
    pub key: String,
    /// Symbol; may be empty.
    pub symbol: &'static str,
    /// Value with its unit.
    pub value: String,
    /// Its reliability.
    pub standing: Standing,
    /// Whether the value comes from a base of the design instead of the design itself.
    pub inherited: bool,
    /// Meaning, value, range and source in one text, for a tooltip.
    pub title: String,
}

/// The labels of all keys of a design by their full names.
pub(super) fn labels(design: &Design) -> BTreeMap<String, Label> {
    let entries = design.entries();
    let own = design.path().to_string_lossy();
    let is_own = |entry: &Entry| entry.file == own || entry.file == "command line" || entry.file.is_empty();
    let based = entries.iter().any(|entry| !is_own(entry));
    let mut descriptions = BTreeMap::new();
    Values::SPEC.each_key("", &mut |key, spec| {
        descriptions.insert(key.to_owned(), spec.description());
    });
    let label = |entry: Entry| {
        let (value, standing) = (text(&entry.value, &entry.unit), Standing::of(&entry));
        let range = entry.range.map_or_else(String::new, |ends| {
            let [low, high] = ends.map(|end| text(&Value::Number(end), &entry.unit));
            format!("; range {low} to {high}")
        });
        let source = if entry.source.is_empty() {
            entry.provenance.as_str().to_owned()
        } else {
            format!("{}: {}", entry.provenance.as_str(), entry.source)
        };
        let description = descriptions.get(&entry.key).cloned().unwrap_or_default();
        let title = format!(
            "{} = {value}. {description} {source}{range} ({}, line {})",
            entry.key, entry.file, entry.line
        );
        // A title is plain text: it has no form for code.
        let title = title.replace('`', "");
        let inherited = based && !is_own(&entry);
        let label = Label {
            key: entry.key.clone(),
            symbol: entry.symbol,
            value,
            standing,
            inherited,
            title,
        };
        (entry.key, label)
    };
    entries.into_iter().map(label).collect()
}

/// A value in a common unit.
pub(super) fn text(value: &Value, unit: &str) -> String {
    let (number, factor, unit) = match value {
        Value::Number(number) => match unit {
            "m" => (*number, 1e3, "mm"),
            "m2" => (*number, 1e6, "mm\u{b2}"),
            "m3" => (*number, 1e6, "cm\u{b3}"),
            "kg" => (*number, 1e3, "g"),
            "Pa" => (*number, 1e-3, "kPa"),
            "rad" => (number.to_degrees(), 1.0, "\u{b0}"),
            other => (*number, 1.0, other),
        },
        Value::Count(count) => return count.to_string(),
        Value::Switch(on) => return on.to_string(),
        Value::Choice(word) => return (*word).to_owned(),
        Value::File(path) => return path.clone(),
        Value::Name(name) => return name.0.clone(),
    };
    let space = if unit == "\u{b0}" { "" } else { " " };
    let number = rounded(number * factor, 5, 1e6).replace('-', "\u{2212}");
    format!("{number}{space}{unit}").trim_end().to_owned()
}
