//! `MACHINE.toml`: a test machine by the declared keys of its groups, together with a fitted law.

use std::path::{Path, PathBuf};

use nailnoise_dynamics::machine::Machine;
use nailnoise_penetration::fit::FittedLaw;
use nailnoise_quantities::{Found, Group, KeySpec, Kind, Value, quantity};

use super::{PenetrationError, fitted, read_text, unreadable};

/// The key of a fitted law's file.
const FIT: &str = "penetration_fit";

/// A machine, and the fitted law of its wood.
///
/// # Errors
/// [`PenetrationError::Data`] with file, line and key.
pub fn machine(path: &Path) -> Result<(Machine, Option<FittedLaw>), PenetrationError> {
    let text = read_text(path).map_err(|cause| unreadable(path, &cause, "name a TOML file of a test machine"))?;
    let file = File { path, text: &text };
    let table: toml::Table = text.parse().map_err(|error: toml::de::Error| {
        let line = error
            .span()
            .map_or(1, |span| 1 + text[..span.start.min(text.len())].matches('\n').count());
        file.at(
            line,
            error.message().to_owned(),
            "write TOML: [group], then key = value",
        )
    })?;
    let mut keys: Vec<(String, &'static KeySpec)> = Vec::new();
    Machine::SPEC.each_key("", &mut |key, spec| keys.push((key.to_owned(), spec)));
    let mut fit = None;
    for (group, values) in &table {
        if group == FIT {
            let name = values
                .as_str()
                .ok_or_else(|| file.error(FIT, "it is not text".to_owned(), "name a file in quotes"))?;
            fit = Some(fitted(
                &path.parent().unwrap_or_else(|| Path::new("")).join(PathBuf::from(name)),
            )?);
            continue;
        }
        let Some(values) = values.as_table() else {
            return Err(file.unknown(group, &keys));
        };
        if let Some(key) = values
            .keys()
            .map(|key| format!("{group}.{key}"))
            .find(|key| !keys.iter().any(|k| k.0 == *key))
        {
            return Err(file.unknown(&key, &keys));
        }
    }
    let mut found = Found::new();
    for (key, spec) in &keys {
        let given = key
            .split_once('.')
            .and_then(|(group, name)| table.get(group)?.get(name));
        let Some(given) = given else {
            return Err(file.at(
                1,
                format!("the key {key} is missing"),
                &format!("add it: {}", spec.description()),
            ));
        };
        found.insert(key.clone(), file.value(key, spec.kind, given)?);
    }
    let machine = Machine::build("", &found).map_err(|key| file.error(&key, "it has no value".to_owned(), "add it"))?;
    Ok((machine, fit))
}

/// A file, for error messages.
struct File<'a> {
    path: &'a Path,
    text: &'a str,
}

impl File<'_> {
    fn at(&self, line: usize, problem: String, help: &str) -> PenetrationError {
        PenetrationError::Data {
            path: self.path.to_owned(),
            line,
            problem,
            help: help.to_owned(),
        }
    }

    /// An error at the line that begins with the key, in its group.
    fn error(&self, key: &str, problem: String, help: &str) -> PenetrationError {
        let (group, name) = key.split_once('.').unwrap_or(("", key));
        let header = format!("[{group}]");
        let mut inside = group.is_empty();
        let mut line = 1;
        for (index, text) in self.text.lines().enumerate() {
            let text = text.trim();
            if text.starts_with('[') {
                inside = text.starts_with(&header);
            }
            let named = |name: &str| {
                text.strip_prefix(name)
                    .is_some_and(|rest| rest.trim_start().starts_with(['=', '.']))
            };
            if (inside && named(name)) || named(key) {
                line = index + 1;
                break;
            }
        }
        self.at(line, format!("{key}: {problem}"), help)
    }

    fn unknown(&self, key: &str, keys: &[(String, &'static KeySpec)]) -> PenetrationError {
        let near = keys
            .iter()
            .min_by_key(|known| strsim::damerau_levenshtein(&known.0, key));
        let help = near.map_or_else(String::new, |near| format!("the key most like it is {}", near.0));
        self.error(key, "there is no such key".to_owned(), &help)
    }

    fn value(&self, key: &str, kind: Kind, given: &toml::Value) -> Result<Value, PenetrationError> {
        let refuse = |problem: String, help: String| Err(self.error(key, problem, &help));
        let allowed = |value: f64| {
            if kind.allows(value) {
                Ok(Value::Number(value))
            } else {
                refuse(
                    format!("{value} is outside its domain"),
                    format!("give {}", kind.allowed()),
                )
            }
        };
        match (kind, given) {
            (Kind::Quantity { dimension, gauge, .. }, toml::Value::String(text)) => {
                match quantity(text, dimension, gauge) {
                    Ok(measured) => allowed(measured.absolute(STANDARD_PRESSURE)),
                    Err(error) => refuse(
                        error.to_string(),
                        "give a number with a unit, as \"0.131 kg\"".to_owned(),
                    ),
                }
            }
            (Kind::Quantity { .. }, toml::Value::Integer(integer)) => allowed(*integer as f64),
            (Kind::Quantity { .. }, toml::Value::Float(float)) => allowed(*float),
            (Kind::Count(most), toml::Value::Integer(integer)) => {
                match u32::try_from(*integer).ok().filter(|count| (1..=most).contains(count)) {
                    Some(count) => Ok(Value::Count(count)),
                    None => refuse(
                        format!("{integer} is not a count"),
                        format!("give a whole number from 1 to {most}"),
                    ),
                }
            }
            (Kind::Choice(words), toml::Value::String(word)) => match words.iter().find(|own| **own == word.as_str()) {
                Some(word) => Ok(Value::Choice(word)),
                None => refuse(
                    format!("there is no \"{word}\""),
                    format!("choose from: {}", words.join(", ")),
                ),
            },
            _ => refuse(
                "it is of another kind".to_owned(),
                "give a number, or a text with a unit".to_owned(),
            ),
        }
    }
}

/// Standard atmospheric pressure, to which gauge pressures are added \[Pa\].
const STANDARD_PRESSURE: f64 = 101_325.0;
