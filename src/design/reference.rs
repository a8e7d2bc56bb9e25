//! The reference of all keys, made from the same declarations that read them.

use std::fmt::Write as _;

use nailnoise_quantities::{Group, GroupSpec, Kind, MEMBER, dotted};

use super::derived::DERIVED;
use super::facts::{KeyFacts, facts};
use super::groups::Values;

/// All groups and keys of the design file as Markdown: key, permitted values, symbol, description.
pub fn reference() -> String {
    let mut text = String::from(INTRODUCTION);
    for (name, group) in Values::SPEC.groups {
        section(&mut text, name, group);
    }
    for (name, member) in Values::SPEC.lists {
        section(&mut text, &dotted(name, MEMBER), member);
    }
    text.push_str(DERIVED_INTRODUCTION);
    for derived in DERIVED {
        let unit = derived.dimension.unit();
        let primaries: Vec<_> = derived.primaries.iter().map(|key| format!("`{key}`")).collect();
        let (key, symbol, description) = (derived.key, derived.symbol, derived.description);
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "| `{key}` | {unit} | {symbol} | {description} | {} |",
            primaries.join(", ")
        );
    }
    text
}

fn section(text: &mut String, path: &str, group: &GroupSpec) {
    let _ = writeln!(text, "\n## `[{path}]`\n\n{}\n", filled(&group.description()));
    if group.keys().next().is_some() {
        text.push_str("| key | holds | symbol | description |\n|---|---|---|---|\n");
    }
    for key in group.keys() {
        let _ = writeln!(
            text,
            "| `{}` | {} | {} | {} |",
            key.name,
            holds(key.kind, &dotted(path, key.name)),
            key.symbol,
            key.description()
        );
    }
    for (name, inner) in group.groups {
        section(text, &dotted(path, name), inner);
    }
    for (name, member) in group.lists {
        section(text, &dotted(&dotted(path, name), MEMBER), member);
    }
}

/// Wraps a paragraph to lines of at most 120 columns.
fn filled(paragraph: &str) -> String {
    let mut lines = vec![String::new()];
    for word in paragraph.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.is_empty() => line.push_str(word),
            Some(line) if line.chars().count() + 1 + word.chars().count() <= 120 => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines.join("\n")
}

fn holds(kind: Kind, key: &str) -> String {
    // A plausible range is more informative than the domain of the program.
    if let Some(plausible) = facts(key).and_then(KeyFacts::plausible_in_words) {
        return match kind {
            Kind::Count(_) => format!("whole number, plausible {plausible}"),
            Kind::Quantity { dimension, .. } if dimension.unit().is_empty() => format!("number, plausible {plausible}"),
            _ => format!("plausible {plausible}"),
        };
    }
    match kind {
        Kind::Quantity { dimension, .. } if dimension.unit().is_empty() => format!("number {}", kind.allowed()),
        Kind::Quantity { .. } => kind.allowed(),
        Kind::Count(_) => format!("whole number {}", kind.allowed()),
        Kind::Switch => "`true` or `false`".to_owned(),
        Kind::File => "name of a file, or `\"\"`".to_owned(),
        Kind::Name => "a name".to_owned(),
        Kind::Choice(words) => words
            .iter()
            .map(|word| format!("`\"{word}\"`"))
            .collect::<Vec<_>>()
            .join(", "),
    }
}

const INTRODUCTION: &str = include_str!("reference.md");

const DERIVED_INTRODUCTION: &str = "
## Derived quantities

These are computed and never given twice; `exhaust.area` may be given with `follows`. A file that gives one which
differs by more than 0.1 % from the computed value is refused, with both numbers and the primary quantities to change.
One that agrees is accepted with a warning that it has no effect.

| quantity | unit | symbol | description | computed from |
|---|---|---|---|---|
";
