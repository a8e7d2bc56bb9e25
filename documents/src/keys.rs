//! The keys of a table of a document, with their places.

use std::borrow::Cow;
use std::ops::Range;

use nailnoise_quantities::{Dimension, measure};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::document::Document;
use super::nearest::nearest;
use super::place::Place;
use super::value::found;

/// A value with its span.
pub type Value<'i> = Spanned<DeValue<'i>>;

/// A key that is invalid, missing or unknown.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{}, line {}: `{key}` {problem}", at.file(), at.line())]
pub struct KeyError {
    /// Its full name.
    pub key: String,
    /// Description of the problem.
    pub problem: String,
    /// The remedy.
    pub help: String,
    /// Location: the value, or the table that does not contain the key.
    pub at: Box<Place>,
}

/// A table of a document: its name, its keys and its place.
pub struct Keys<'t, 'i> {
    document: &'t Document,
    /// Kind of document in one word, for messages: for example, a manifest.
    noun: &'static str,
    name: String,
    keys: &'t DeTable<'i>,
    span: Range<usize>,
}

impl<'t, 'i> Keys<'t, 'i> {
    /// The root table of a document. `noun` names the kind of document in messages.
    pub fn of_document(document: &'t Document, keys: &'t DeTable<'i>, noun: &'static str) -> Self {
        Self {
            document,
            noun,
            name: String::new(),
            keys,
            span: 0..0,
        }
    }

    /// The full name of the table; empty for the root table.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The keys with their spans.
    pub fn keys(&self) -> &'t DeTable<'i> {
        self.keys
    }

    /// The span of the table.
    pub fn span(&self) -> Range<usize> {
        self.span.clone()
    }

    /// The full name of a key; the name of the table itself if `key` is empty.
    pub fn full(&self, key: &str) -> String {
        match (self.name.as_str(), key) {
            ("", name) | (name, "") => name.to_owned(),
            (table, key) => format!("{table}.{key}"),
        }
    }

    /// Creates an error at a place.
    pub fn wrong(&self, key: &str, span: Range<usize>, problem: String, help: String) -> KeyError {
        KeyError {
            key: self.full(key),
            problem,
            help,
            at: self.document.place(span),
        }
    }

    /// Creates an error for a key, located at its value or else at the table.
    pub fn error(&self, key: &str, problem: impl Into<String>, help: impl Into<String>) -> KeyError {
        let span = self.keys.get(key).map_or_else(|| self.span.clone(), Spanned::span);
        self.wrong(key, span, problem.into(), help.into())
    }

    /// Rejects any key that is not in `known`.
    ///
    /// # Errors
    /// [`KeyError`] for the first unknown key.
    pub fn only(&self, known: &[&str]) -> Result<(), KeyError> {
        let unknown = self.keys.keys().find(|key| !known.contains(&key.get_ref().as_ref()));
        unknown.map_or(Ok(()), |key| Err(self.unknown(key, known)))
    }

    fn unknown(&self, key: &Spanned<Cow<'_, str>>, known: &[&str]) -> KeyError {
        let name = key.get_ref().as_ref();
        let near = nearest(known.iter().copied(), name);
        let near = near.map_or_else(String::new, |near| format!("is it `{near}`? "));
        let help = format!("{near}the keys are {}", known.join(", "));
        self.wrong(name, key.span(), format!("is no key of a {}", self.noun), help)
    }

    /// The value of a key.
    pub fn get(&self, key: &str) -> Option<&'t Value<'i>> {
        self.keys.get(key)
    }

    /// The value of a required key. `example` shows the key in the remedy.
    ///
    /// # Errors
    /// [`KeyError`] if the key is missing.
    pub fn required(&self, key: &str, example: &str) -> Result<&'t Value<'i>, KeyError> {
        self.get(key)
            .ok_or_else(|| self.error(key, "is missing", format!("add it, as {key} = {example}")))
    }

    /// A nonempty string. `example` shows the value in the remedy.
    ///
    /// # Errors
    /// [`KeyError`] if the value is not a nonempty string.
    pub fn text(&self, key: &str, example: &str) -> Result<Option<&'t str>, KeyError> {
        let Some(value) = self.get(key) else { return Ok(None) };
        let text = value.get_ref().as_str().filter(|text| !text.trim().is_empty());
        text.map(Some).ok_or_else(|| {
            let problem = format!("is {}, it must be a text", found(value.get_ref()));
            self.error(key, problem, format!("give it as {key} = {example}"))
        })
    }

    /// A table within this one. `example` shows it in the remedy.
    ///
    /// # Errors
    /// [`KeyError`] if the value is not a table.
    pub fn table(&self, key: &str, example: &str) -> Result<Option<Self>, KeyError> {
        let Some(value) = self.get(key) else { return Ok(None) };
        let keys = value.get_ref().as_table().ok_or_else(|| {
            let problem = format!("is {}, it must be a group of keys", found(value.get_ref()));
            self.error(key, problem, format!("give it as {example}"))
        })?;
        Ok(Some(Self {
            document: self.document,
            noun: self.noun,
            name: self.full(key),
            keys,
            span: value.span(),
        }))
    }

    /// A whole number from 1 to `most`.
    ///
    /// # Errors
    /// [`KeyError`] if the value is anything else.
    pub fn count(&self, key: &str, most: usize) -> Result<Option<usize>, KeyError> {
        let Some(value) = self.get(key) else { return Ok(None) };
        let count = match value.get_ref() {
            DeValue::Integer(integer) => usize::from_str_radix(integer.as_str(), integer.radix()).ok(),
            _ => None,
        };
        count
            .filter(|count| (1..=most).contains(count))
            .map(Some)
            .ok_or_else(|| {
                let problem = format!("is {}, it must be a whole number", found(value.get_ref()));
                self.error(key, problem, format!("give a whole number from 1 to {most}"))
            })
    }

    /// A quantity within limits; both in SI units.
    ///
    /// # Errors
    /// [`KeyError`] if the value has the wrong type or unit, or lies outside the limits.
    pub fn quantity(&self, key: &str, dimension: Dimension, limits: [f64; 2]) -> Result<Option<f64>, KeyError> {
        let Some(value) = self.get(key) else { return Ok(None) };
        let read = self.number(key, value, |text| measure(text, dimension))?;
        self.within(key, read, limits, &dimension.unit()).map(Some)
    }

    /// Checks that the value of a key lies within limits given in the same unit.
    ///
    /// # Errors
    /// [`KeyError`] if it does not.
    pub fn within(&self, key: &str, value: f64, [low, high]: [f64; 2], unit: &str) -> Result<f64, KeyError> {
        if (low..=high).contains(&value) {
            return Ok(value);
        }
        let unit = if unit.is_empty() {
            String::new()
        } else {
            format!(" {unit}")
        };
        let problem = format!("is {value}{unit}, outside {low} to {high}{unit}");
        Err(self.error(
            key,
            problem,
            "correct the value, or its unit; a number alone is in SI units",
        ))
    }

    /// A number in SI units, or a string that `read` converts.
    ///
    /// # Errors
    /// [`KeyError`] if the value has the wrong type or is not finite, or if `read` rejects it.
    pub fn number(
        &self,
        key: &str,
        value: &Value<'_>,
        read: impl Fn(&str) -> Result<f64, String>,
    ) -> Result<f64, KeyError> {
        let refuse = |problem: String| {
            let help = "give a number in SI units, or a text with a unit".to_owned();
            self.wrong(key, value.span(), problem, help)
        };
        let number = match value.get_ref() {
            DeValue::String(text) => read(text).map_err(|problem| refuse(format!("is \"{text}\": {problem}")))?,
            DeValue::Float(float) => float.as_str().parse().unwrap_or(f64::NAN),
            DeValue::Integer(integer) => {
                i64::from_str_radix(integer.as_str(), integer.radix()).map_or(f64::NAN, |integer| integer as f64)
            }
            other => return Err(refuse(format!("is {}, it must be a number", found(other)))),
        };
        if number.is_finite() {
            Ok(number)
        } else {
            Err(refuse(format!("is {}, which is not finite", found(value.get_ref()))))
        }
    }

    /// Three lengths \[m\].
    ///
    /// # Errors
    /// [`KeyError`] if the value is not a list of three lengths.
    pub fn point(&self, key: &str, value: &Value<'_>) -> Result<[f64; 3], KeyError> {
        let list = value.get_ref().as_array().map_or(&[][..], |array| array);
        let [x, y, z] = list else {
            let problem = format!("is {}, it must be three lengths", found(value.get_ref()));
            let help = format!("give x, y and z in m, as {key} = [1, 0, 0.969]");
            return Err(self.wrong(key, value.span(), problem, help));
        };
        let length = |value| {
            self.number(key, value, |text| {
                measure(text, nailnoise_quantities::dimension::LENGTH)
            })
        };
        Ok([length(x)?, length(y)?, length(z)?])
    }
}
