//! Keys of a manifest with their places.

use std::borrow::Cow;
use std::ops::Range;

use nailnoise_quantities::{Dimension, measure};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::design::{File, found, nearest_word};
use crate::measurement::error::MeasurementError;

/// A value with its place.
pub(super) type Value<'i> = Spanned<DeValue<'i>>;

/// A table of the manifest: its name, its keys and its place.
pub(super) struct Table<'t, 'i> {
    pub(super) file: &'t File,
    pub(super) name: String,
    pub(super) keys: &'t DeTable<'i>,
    pub(super) span: Range<usize>,
}

impl<'t, 'i> Table<'t, 'i> {
    /// The full name of a key; that of the table itself for none.
    pub(super) fn full(&self, key: &str) -> String {
        match (self.name.as_str(), key) {
            ("", name) | (name, "") => name.to_owned(),
            (table, key) => format!("{table}.{key}"),
        }
    }

    /// An error at a place.
    pub(super) fn wrong(&self, key: &str, span: Range<usize>, problem: String, help: String) -> MeasurementError {
        MeasurementError::Manifest {
            key: self.full(key),
            problem,
            help,
            at: self.file.place(span),
        }
    }

    /// An error of a key: at its value, or at the table that lacks it.
    pub(super) fn error(&self, key: &str, problem: impl Into<String>, help: impl Into<String>) -> MeasurementError {
        let span = self.keys.get(key).map_or_else(|| self.span.clone(), Spanned::span);
        self.wrong(key, span, problem.into(), help.into())
    }

    /// Refuses keys that are none of these.
    pub(super) fn only(&self, known: &[&str]) -> Result<(), MeasurementError> {
        let unknown = self.keys.keys().find(|key| !known.contains(&key.get_ref().as_ref()));
        unknown.map_or(Ok(()), |key| Err(self.unknown(key, known)))
    }

    fn unknown(&self, key: &Spanned<Cow<'_, str>>, known: &[&str]) -> MeasurementError {
        let name = key.get_ref().as_ref();
        let near = nearest_word(known.iter().copied(), name);
        let near = near.map_or_else(String::new, |near| format!("is it `{near}`? "));
        let help = format!("{near}the keys are {}", known.join(", "));
        self.wrong(name, key.span(), "is no key of a manifest".to_owned(), help)
    }

    pub(super) fn get(&self, key: &str) -> Option<&'t Value<'i>> {
        self.keys.get(key)
    }

    /// The value of a key that must be there.
    pub(super) fn required(&self, key: &str, example: &str) -> Result<&'t Value<'i>, MeasurementError> {
        self.get(key)
            .ok_or_else(|| self.error(key, "is missing", format!("add it, as {key} = {example}")))
    }

    pub(super) fn text(&self, key: &str, example: &str) -> Result<Option<&'t str>, MeasurementError> {
        let Some(value) = self.get(key) else { return Ok(None) };
        let text = value.get_ref().as_str().filter(|text| !text.trim().is_empty());
        text.map(Some).ok_or_else(|| {
            let problem = format!("is {}, it must be a text", found(value.get_ref()));
            self.error(key, problem, format!("give it as {key} = {example}"))
        })
    }

    pub(super) fn table(&self, key: &str, example: &str) -> Result<Option<Table<'t, 'i>>, MeasurementError> {
        let Some(value) = self.get(key) else { return Ok(None) };
        let keys = value.get_ref().as_table().ok_or_else(|| {
            let problem = format!("is {}, it must be a group of keys", found(value.get_ref()));
            self.error(key, problem, format!("give it as {example}"))
        })?;
        Ok(Some(Table {
            file: self.file,
            name: self.full(key),
            keys,
            span: value.span(),
        }))
    }

    /// A whole number within limits.
    pub(super) fn count(&self, key: &str, most: usize) -> Result<Option<usize>, MeasurementError> {
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

    /// A quantity in SI units within limits.
    pub(super) fn quantity(
        &self,
        key: &str,
        dimension: Dimension,
        limits: [f64; 2],
    ) -> Result<Option<f64>, MeasurementError> {
        let Some(value) = self.get(key) else { return Ok(None) };
        let read = self.number(key, value, |text| measure(text, dimension))?;
        self.within(key, read, limits, &dimension.unit()).map(Some)
    }

    pub(super) fn within(
        &self,
        key: &str,
        value: f64,
        [low, high]: [f64; 2],
        unit: &str,
    ) -> Result<f64, MeasurementError> {
        if (low..=high).contains(&value) {
            return Ok(value);
        }
        let problem = format!("is {value} {unit}, outside {low} to {high} {unit}");
        Err(self.error(
            key,
            problem,
            "correct the value, or its unit; a number alone is in SI units",
        ))
    }

    /// A number in SI units, or a text that `read` understands.
    pub(super) fn number(
        &self,
        key: &str,
        value: &Value<'_>,
        read: impl Fn(&str) -> Result<f64, String>,
    ) -> Result<f64, MeasurementError> {
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
    pub(super) fn point(&self, key: &str, value: &Value<'_>) -> Result<[f64; 3], MeasurementError> {
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
