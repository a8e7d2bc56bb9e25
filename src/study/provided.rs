//! Studies of shipped designs that come with the program, so that `nailnoise run` states intervals without a wait: the result and
//! the levels of each draw, in one compact file of the folder `designs/studies`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::{Number, Value};

use super::draws::Draws;
use super::kept::{code, population};
use super::level_table::{LevelTable, TOTAL};
use super::result::StudyResult;
use crate::design::Design;
use crate::error::Error;
use crate::shipped;

/// Version of the layout.
const SCHEMA: &str = "nailnoise-provided-study/1";

/// Significant digits of the figures, and decimals of the levels of draws \[dB\].
const DIGITS: i32 = 6;
const DECIMALS: f64 = 100.0;

/// A study with what it was made of.
#[derive(Debug, Serialize, Deserialize)]
pub struct ProvidedStudy {
    schema: String,
    /// The shipped design.
    pub design: String,
    /// The command that made it.
    pub command: String,
    /// Version of the program that made it.
    pub version: String,
    code: String,
    population: String,
    /// What it states.
    pub result: StudyResult,
    /// Level of each source and of the total in each draw, with the errors of methods \[dB re 1 pW s\]; null for silence.
    pub levels_db: BTreeMap<String, Vec<Option<f64>>>,
}

impl ProvidedStudy {
    /// A study of the shipped design of this path.
    ///
    /// # Errors
    /// A design that cannot be digested.
    pub fn new(path: &str, design: &Design, command: &str, result: &StudyResult, made: &Draws) -> Result<Self, Error> {
        let table = LevelTable::new(&made.draws);
        let rounded = |level: f64| level.is_finite().then(|| (DECIMALS * level).round() / DECIMALS);
        let column = |levels: Vec<f64>| levels.into_iter().map(rounded).collect();
        let sources = table.names.iter().enumerate();
        let mut levels_db: BTreeMap<String, Vec<Option<f64>>> = sources
            .map(|(place, name)| (name.clone(), column(table.column(place))))
            .collect();
        levels_db.insert(TOTAL.to_owned(), column(table.totals()));
        Ok(Self {
            schema: SCHEMA.to_owned(),
            design: path.to_owned(),
            command: command.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            code: code(),
            population: population(design, result)?,
            result: result.clone(),
            levels_db,
        })
    }

    /// The file: one line of JSON.
    ///
    /// # Errors
    /// [`Error::Json`].
    pub fn file(&self) -> Result<String, Error> {
        let mut value = serde_json::to_value(self).map_err(Error::Json)?;
        shorten(&mut value);
        Ok(serde_json::to_string(&value).map_err(Error::Json)? + "\n")
    }

    /// The provided study of a design: of a shipped one, or of one that differs from it in values that were drawn alone.
    ///
    /// # Errors
    /// A design that cannot be digested; a file that does not follow the layout.
    pub fn of(design: &Design) -> Result<Option<Self>, Error> {
        for (_, text) in shipped::STUDIES {
            let own: Self = serde_json::from_str(text).map_err(Error::Json)?;
            if let Some(base) = Design::shipped(&own.design)
                && population(&base, &own.result)? == population(design, &own.result)?
            {
                return Ok(Some(own));
            }
        }
        Ok(None)
    }

    /// What has changed since it was made: the shipped design, the code of the levels.
    ///
    /// # Errors
    /// A design that cannot be digested.
    pub fn changed(&self, design: &Design) -> Result<Vec<&'static str>, Error> {
        let of_design = (self.population != population(design, &self.result)?).then_some("the design");
        let of_code = (self.code != code()).then_some("the code");
        Ok(of_design.into_iter().chain(of_code).collect())
    }
}

/// Rounds all numbers to a few digits.
fn shorten(value: &mut Value) {
    match value {
        Value::Array(values) => values.iter_mut().for_each(shorten),
        Value::Object(values) => values.values_mut().for_each(shorten),
        Value::Number(number) if number.is_f64() => {
            let exact = number.as_f64().unwrap_or(0.0);
            let rounded = format!("{exact:.*e}", (DIGITS - 1) as usize).parse().unwrap_or(exact);
            if let Some(rounded) = Number::from_f64(rounded) {
                *number = rounded;
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    /// Every study of the folder is of a shipped design, and its own draws give the shares that it states.
    #[test]
    fn provided_studies_state_what_their_draws_give() {
        assert!(!shipped::STUDIES.is_empty());
        for (path, text) in shipped::STUDIES {
            assert!(text.len() < 300_000, "{path}");
            let own: ProvidedStudy = serde_json::from_str(text).unwrap();
            let design = Design::shipped(&own.design).unwrap_or_else(|| panic!("{path}: no design {}", own.design));
            let found = ProvidedStudy::of(&design).unwrap().unwrap();
            assert_eq!(found.design, own.design, "{path}");
            let total = &own.levels_db[TOTAL];
            assert_eq!(total.len(), own.result.draws, "{path}");
            for source in &own.result.sources {
                let levels = &own.levels_db[&source.source];
                let others = own
                    .levels_db
                    .iter()
                    .filter(|(name, _)| *name != TOTAL && **name != source.source);
                let others: Vec<_> = others.map(|(_, levels)| levels).collect();
                let first = (0..levels.len()).filter(|&draw| others.iter().all(|other| levels[draw] > other[draw]));
                let share = first.count() as f64 / levels.len() as f64;
                assert!(
                    (share - source.first.value.unwrap()).abs() < 1e-5,
                    "{path}: {}",
                    source.source
                );
            }
        }
    }

    #[test]
    fn a_design_with_another_drawn_value_has_the_same_study_and_one_with_another_range_has_none() {
        let (_, text) = shipped::STUDIES[0];
        let own: ProvidedStudy = serde_json::from_str(text).unwrap();
        let base = Design::shipped(&own.design).unwrap();
        let is_drawn = |key: &str| {
            own.result
                .variables
                .iter()
                .any(|variable| variable.drawn && variable.name == key)
        };
        let entries = base.entries();
        let drawn = entries
            .iter()
            .find(|entry| is_drawn(&entry.key) && entry.unit == "Pa")
            .unwrap();
        let [low, high] = drawn.range.unwrap();
        let mut moved = base.clone();
        moved
            .set(&[(&drawn.key, crate::design::Value::Number(0.4 * low + 0.6 * high))])
            .unwrap();
        assert!(ProvidedStudy::of(&moved).unwrap().is_some());
        assert_eq!(
            population(&moved, &own.result).unwrap(),
            population(&base, &own.result).unwrap()
        );
        let text = format!(
            "base = \"{}\"\n{} = {{ range = [{low}, {}] }}\n",
            own.design,
            drawn.key,
            1.01 * high
        );
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/designs/wider.toml");
        assert!(
            ProvidedStudy::of(&Design::parse(&text, folder).unwrap())
                .unwrap()
                .is_none()
        );
    }
}
