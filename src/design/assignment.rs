//! Values given on the command line, which override those of the design file.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use toml::de::{DeTable, DeValue};

use super::derived::Solution;
use super::source::{COMMAND_LINE, File};

/// A value for a key, such as `supply.pressure=80psig`.
///
/// The value is written as in a design file; a text needs no quotes: `exhaust.holes=3`, `piston.mass=120 g`,
/// `support.worktable.preset=B`. An inline table also gives range and provenance.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Assignment {
    /// A line of a design file.
    line: String,
}

/// Why a text is not an [`Assignment`].
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AssignmentError {
    /// The equals sign is missing, or one of its sides is empty.
    #[error("\"{0}\" is not KEY=VALUE, as supply.pressure=80psig")]
    Incomplete(String),
    /// The left-hand side is not a valid key name.
    #[error("\"{0}\" cannot be a key; keys are written as supply.pressure")]
    BadKey(String),
    /// `base` can only be given in a design file.
    #[error("`base` can be given in a design file only")]
    Base,
}

impl fmt::Display for Assignment {
    /// In a form that can be parsed again.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.line)
    }
}

impl FromStr for Assignment {
    type Err = AssignmentError;

    fn from_str(text: &str) -> Result<Self, AssignmentError> {
        let (key, value) = text
            .split_once('=')
            .map(|(key, value)| (key.trim(), value.trim()))
            .filter(|(key, value)| !key.is_empty() && !value.is_empty())
            .ok_or_else(|| AssignmentError::Incomplete(text.to_owned()))?;
        let quoted = toml::Value::String(value.to_owned()).to_string();
        // A line break would start another key.
        if key.contains(['\n', '\r']) || DeTable::parse(&format!("{key} = 0")).is_err() {
            return Err(AssignmentError::BadKey(key.to_owned()));
        }
        if key == "base" {
            return Err(AssignmentError::Base);
        }
        let value = if is_value(value) { value } else { &quoted };
        Ok(Self {
            line: format!("{key} = {value}"),
        })
    }
}

impl Assignment {
    /// The key, as it was given.
    pub(crate) fn key(&self) -> &str {
        self.line.split_once(" = ").map_or(&self.line, |(key, _)| key)
    }

    /// The assignment as a line of a design file. There, a derived quantity names the quantity that follows from it.
    pub(crate) fn file_line(&self) -> String {
        match self.line.split_once(" = ") {
            Some((key, value)) if !value.starts_with('{') => match Solution::default_for(key) {
                Some(solution) => format!("{key} = {{ value = {value}, follows = \"{}\" }}", solution.follower),
                None => self.line.clone(),
            },
            _ => self.line.clone(),
        }
    }

    /// The assignment as a one-line design file; file names in its value are relative to the working directory.
    pub(crate) fn file(&self) -> File {
        File::new(Path::new(COMMAND_LINE), &self.line)
    }
}

/// Whether a text is a single TOML value other than a date, which no key has.
fn is_value(text: &str) -> bool {
    let line = format!("value = {text}");
    DeTable::parse(&line).is_ok_and(|table| {
        table.get_ref().len() == 1
            && table
                .get_ref()
                .values()
                .all(|value| !matches!(value.get_ref(), DeValue::Datetime(_)))
    })
}
