//! The part of a finished result that a comparison needs, from a run or from its `result.json`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::consistency;
use crate::comparison::ComparisonError;
use crate::error::Error;
use crate::result::{DesignId, Performance, RankedSource, RunStudy, SCHEMA, StudySummary, Total};
use crate::stages::cycle::EventWords;
use crate::stages::headline::Headline;

/// A finished result.
#[derive(Debug, Clone, Deserialize)]
pub struct Finished {
    schema: String,
    pub(super) design: DesignId,
    pub(super) inputs: Vec<Input>,
    /// Fields of its assembly that are not inputs; empty without an assembly, or in a result of an earlier version.
    #[serde(default)]
    pub(super) assembly: BTreeMap<String, String>,
    pub(super) ranking: Vec<RankedSource>,
    pub(super) total: Total,
    pub(super) outcome: String,
    #[serde(default)]
    headline: Option<Headline>,
    #[serde(default)]
    pub(super) performance: Option<Performance>,
    #[serde(default)]
    study: Option<RunStudy>,
    pub(super) events: BTreeMap<String, Option<f64>>,
    #[serde(default)]
    pub(super) event_words: EventWords,
    pub(super) cycle: serde_json::Map<String, serde_json::Value>,
}

/// A value of the design.
#[derive(Debug, Clone, Deserialize)]
pub struct Input {
    /// Full name of the key.
    pub key: String,
    /// Its value, quantities in SI units.
    pub value: serde_json::Value,
    /// Unit of the value; empty if it has none.
    pub unit: String,
}

impl Finished {
    /// Whether `path` refers to a finished result instead of a design: a `.json` file, or a folder with a
    /// `result.json`.
    pub fn is_at(path: &Path) -> Option<PathBuf> {
        if path.is_dir() {
            Some(path.join("result.json"))
        } else if path.extension().is_some_and(|extension| extension == "json") {
            Some(path.to_owned())
        } else {
            None
        }
    }

    /// Reads a `result.json` and checks that its numbers are consistent.
    ///
    /// # Errors
    /// [`Error::Unreadable`], [`ComparisonError::NotAResult`] or [`ComparisonError::Inconsistent`].
    pub fn read(path: &Path) -> Result<Self, Error> {
        let text = std::fs::read_to_string(path).map_err(|source| Error::Unreadable {
            path: path.to_owned(),
            source,
        })?;
        let result = Self::parse(path, &text)?;
        let value = serde_json::from_str(&text).map_err(Error::Json)?;
        let consistent = consistency::numbers(&value).and_then(|()| consistency::sums(&result.ranking, &result.total));
        consistent.map_err(|fault| ComparisonError::Inconsistent {
            path: path.to_owned(),
            at: fault.at,
            found: fault.found,
            expected: fault.expected,
        })?;
        Ok(result)
    }

    /// Parses the contents of a `result.json`; `path` is used in errors.
    ///
    /// # Errors
    /// [`ComparisonError::NotAResult`].
    pub fn parse(path: &Path, text: &str) -> Result<Self, Error> {
        let wrong = |reason: String| {
            ComparisonError::NotAResult {
                path: path.to_owned(),
                reason,
            }
            .into()
        };
        let value: serde_json::Value = serde_json::from_str(text).map_err(|error| wrong(error.to_string()))?;
        match value["schema"].as_str() {
            Some(SCHEMA) => {}
            Some(other) => {
                return Err(wrong(format!(
                    "its schema is \"{other}\", this version reads \"{SCHEMA}\""
                )));
            }
            None => return Err(wrong("it has no schema".to_owned())),
        }
        let text = &mut serde_json::Deserializer::from_str(text);
        serde_path_to_error::deserialize(text).map_err(|error| wrong(format!("`{}`: {}", error.path(), error.inner())))
    }

    /// Name of the design.
    pub fn name(&self) -> &str {
        &self.design.name
    }

    /// Renames the design, if two designs of a comparison have the same name.
    pub fn rename(&mut self, name: String) {
        self.design.name = name;
    }

    /// The headline of its shot; none if the nail is driven and the exhaust opens.
    pub(super) fn headline(&self) -> Option<Headline> {
        let figure = |name: &str| self.cycle.get(name).and_then(serde_json::Value::as_f64);
        let exhaust_opens = self.events.get("t13").is_some_and(Option::is_some);
        let bare = || Headline::of_finished(&self.outcome, figure("head_depth"), exhaust_opens);
        self.headline.clone().or_else(bare)
    }

    /// The study that applies to its design; none if it states none.
    pub(super) fn study(&self) -> Option<StudySummary> {
        self.study.as_ref().and_then(RunStudy::known).cloned()
    }

    /// Version of its layout.
    pub fn schema(&self) -> &str {
        &self.schema
    }
}

/// All names that occur in the results, in order of first appearance.
pub(super) fn in_order(results: &[Finished], names: impl Fn(&Finished) -> Vec<String>) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for name in results.iter().flat_map(names) {
        if !all.contains(&name) {
            all.push(name);
        }
    }
    all
}
