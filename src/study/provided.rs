//! Studies of shipped designs that come with the program, so that `nailnoise run` states intervals without delay: the
//! result and the levels of each draw, in one compact file in the folder `designs/studies`.

use serde::{Deserialize, Serialize};
use serde_json::{Number, Value};

use super::draw_table::DrawTable;
use super::draws::{Draws, code_of_levels};
use super::population::{Difference, Population};
use super::result::StudyResult;
use super::study_store::Found;
use crate::design::{Design, renames};
use crate::error::Error;
use crate::shipped;

/// Version of the layout. Files with another version are ignored.
const SCHEMA: &str = "nailnoise-provided-study/2";

/// Significant digits of the figures.
const DIGITS: i32 = 5;

/// A study with its inputs.
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
    /// Number of draws that were computed again after a change of the code, with equal levels; `None` if the code made
    /// all draws.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    repeated: Option<usize>,
    population: Population,
    /// Its results, without bands and intervals between events.
    pub result: StudyResult,
    /// Levels and positions of its draws.
    #[serde(flatten)]
    pub draws: DrawTable,
}

/// The part of a file that is read to decide whether it applies to a design.
#[derive(Deserialize)]
struct Head {
    population: Population,
}

/// State of the study of a shipped design.
#[derive(Debug, Clone, PartialEq)]
pub struct ProvidedState {
    /// Path of the design in the folder `designs`.
    pub design: &'static str,
    /// Number of draws of its study; `None` without one.
    pub draws: Option<usize>,
    /// Inputs that have changed since it was made.
    pub changed: Vec<&'static str>,
    /// Number of draws that were computed again after a change of the code, with equal levels.
    pub repeated: Option<usize>,
}

/// A provided study that applies to a design.
#[derive(Debug)]
pub struct FoundProvided {
    /// The study.
    pub study: ProvidedStudy,
    /// Its results for the design.
    pub found: Found,
}

impl ProvidedStudy {
    /// A study of the shipped design with this path.
    ///
    /// # Errors
    /// If a design cannot be digested.
    pub fn new(path: &str, design: &Design, command: &str, result: &StudyResult, made: &Draws) -> Result<Self, Error> {
        Ok(Self {
            schema: SCHEMA.to_owned(),
            design: path.to_owned(),
            command: command.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            code: code_of_levels(),
            repeated: None,
            population: Population::of(design, result)?,
            result: brief(result),
            draws: DrawTable::of(made),
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

    /// The provided study that applies to a design. It is the largest study of a shipped design that has the same
    /// values, has the same distributions with other values of drawn quantities, or has a sufficient effective number
    /// of weighted draws.
    ///
    /// # Errors
    /// If a design cannot be digested, or a file does not follow the layout.
    pub fn of(design: &Design) -> Result<Option<FoundProvided>, Error> {
        let mut largest: Option<FoundProvided> = None;
        for (_, text) in current() {
            let head: Head = serde_json::from_str(text).map_err(Error::Json)?;
            if head.population.difference(design)? == Difference::Other {
                continue;
            }
            let study: Self = serde_json::from_str(text).map_err(Error::Json)?;
            let found = Found::of(design, &study.population, &study.result, &study.draws)?;
            if let Some(found) = found
                && largest.as_ref().is_none_or(|known| known.found.size() < found.size())
            {
                largest = Some(FoundProvided { study, found });
            }
        }
        Ok(largest)
    }

    /// Reads the text of a file, with the current names of renamed keys; `None` for a file of another layout.
    ///
    /// # Errors
    /// If a file of this layout does not follow it.
    pub fn read(text: &str) -> Result<Option<Self>, Error> {
        if !text.contains(&layout()) {
            return Ok(None);
        }
        let rename = |text: String, (old, new)| text.replace(&format!("\"{old}\""), &format!("\"{new}\""));
        let text = renames().fold(text.to_owned(), rename);
        serde_json::from_str(&text).map(Some).map_err(Error::Json)
    }

    /// Whether it has this number of draws with this seed.
    pub fn has_draws(&self, draws: usize, seed: u64) -> bool {
        (self.result.draws, self.result.seed) == (draws, seed) && self.draws.len() == draws
    }

    /// Whether its population is that of the current design.
    ///
    /// # Errors
    /// If a design cannot be digested.
    pub fn is_of(&self, design: &Design) -> Result<bool, Error> {
        Ok(self.population.difference(design)? == Difference::None)
    }

    /// The same study, renewed for the current code and design. The current code must have made a study with few draws
    /// of the design. The drawn quantities must have the same distributions in both studies, and the first draws must
    /// be equal. Values that are not drawn, and names, may have changed: the equal draws show that the levels do not
    /// depend on them.
    ///
    /// # Errors
    /// If a design cannot be digested.
    pub fn renewed(mut self, design: &Design, few: &StudyResult, made: &Draws) -> Result<Option<Self>, Error> {
        let population = Population::of(design, few)?;
        let repeated = DrawTable::of(made);
        if !self.population.has_distributions_of(&population) || !self.draws.begins_with(&repeated) {
            return Ok(None);
        }
        self.population = population;
        self.result.design = few.design.clone();
        code_of_levels().clone_into(&mut self.code);
        env!("CARGO_PKG_VERSION").clone_into(&mut self.version);
        self.repeated = Some(repeated.len());
        Ok(Some(self))
    }

    /// Whether the code that computes levels is the current one.
    pub fn is_of_this_code(&self) -> bool {
        self.code == code_of_levels()
    }

    /// The study of each shipped design, if there is one.
    ///
    /// # Errors
    /// If a design cannot be digested, or a file does not follow the layout.
    pub fn states() -> Result<Vec<ProvidedState>, Error> {
        let studies: Vec<Self> = current()
            .map(|(_, text)| serde_json::from_str(text).map_err(Error::Json))
            .collect::<Result<_, _>>()?;
        let state = |path: &'static str| {
            let Some(study) = studies.iter().find(|own| own.design == *path) else {
                return Ok(ProvidedState {
                    design: path,
                    draws: None,
                    changed: Vec::new(),
                    repeated: None,
                });
            };
            let same = match Design::shipped(path) {
                Some(design) => study.population.difference(&design)? == Difference::None,
                None => false,
            };
            let of_design = (!same).then_some("the design");
            let of_code = (!study.is_of_this_code()).then_some("the code");
            Ok(ProvidedState {
                design: path,
                draws: Some(study.result.draws),
                changed: of_design.into_iter().chain(of_code).collect(),
                repeated: study.repeated,
            })
        };
        shipped::studied().map(state).collect()
    }
}

/// A study without bands and intervals, which are most of its bytes; no command shows those of a provided study.
fn brief(result: &StudyResult) -> StudyResult {
    let mut brief = result.clone();
    for own in &mut brief.sources {
        own.bands.clear();
        own.intervals.clear();
    }
    brief
}

/// Text that only files of this layout contain.
fn layout() -> String {
    format!("\"schema\":\"{SCHEMA}\"")
}

/// The files of this layout.
fn current() -> impl Iterator<Item = &'static (&'static str, &'static str)> {
    let schema = layout();
    shipped::STUDIES.iter().filter(move |(_, text)| text.contains(&schema))
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
    use crate::result::TOTAL;

    /// Every study in the folder is of a shipped design, and its own draws give the fractions that it states.
    #[test]
    fn provided_studies_state_what_their_draws_give() {
        assert_eq!(current().count(), shipped::STUDIES.len(), "studies of another layout");
        for (path, text) in shipped::STUDIES {
            assert!(text.len() < 200_000, "{path}: {} bytes", text.len());
            let own: ProvidedStudy = serde_json::from_str(text).unwrap();
            let design = Design::shipped(&own.design).unwrap_or_else(|| panic!("{path}: no design {}", own.design));
            let found = ProvidedStudy::of(&design).unwrap().unwrap();
            // Designs with equal values have equal draws, and the first of their studies applies to all.
            assert_eq!(found.study.draws.levels_db, own.draws.levels_db, "{path}");
            assert_eq!(found.found.weighting, None, "{path}");
            let total = &own.draws.levels_db[TOTAL];
            assert_eq!(total.len(), own.result.draws, "{path}");
            for source in &own.result.sources {
                let levels = &own.draws.levels_db[&source.source];
                let others = own.draws.levels_db.iter();
                let others = others.filter(|(name, _)| *name != TOTAL && **name != source.source);
                let others: Vec<_> = others.map(|(_, levels)| levels).collect();
                let first = (0..levels.len()).filter(|&draw| others.iter().all(|other| levels[draw] > other[draw]));
                let share = first.count() as f64 / levels.len() as f64;
                // Levels have two decimals, so that a draw may be a tie.
                let tie = 1.1 / levels.len() as f64;
                assert!(
                    (share - source.first.value.unwrap()).abs() < tie,
                    "{path}: {}",
                    source.source
                );
            }
        }
    }

    /// A provided study of these draws, with another code and with levels that differ by `offset_db`.
    fn outdated(offset_db: f64) -> ProvidedStudy {
        let (path, text) = shipped::STUDIES[0];
        let mut own = ProvidedStudy::read(text).unwrap().unwrap_or_else(|| panic!("{path}"));
        own.code = "of another day".to_owned();
        for level in own.draws.levels_db.values_mut().flatten().flatten() {
            *level += offset_db;
        }
        own
    }

    #[test]
    fn equal_levels_of_repeated_draws_renew_a_study_and_others_do_not() {
        let first = |count| {
            let mut table = outdated(0.0).draws;
            table.levels_db.values_mut().for_each(|levels| levels.truncate(count));
            table.places.values_mut().for_each(|places| places.truncate(3 * count));
            table
        };
        assert!(outdated(0.0).draws.begins_with(&first(8)));
        assert!(
            outdated(0.01).draws.begins_with(&first(8)),
            "the last digit may round the other way"
        );
        assert!(!outdated(0.02).draws.begins_with(&first(8)));
        let mut silent = first(8);
        silent.levels_db.get_mut(TOTAL).unwrap()[7] = None;
        assert!(!outdated(0.0).draws.begins_with(&silent));
        assert!(!first(8).begins_with(&first(9)), "fewer draws");
        assert!(!first(8).begins_with(&DrawTable::default()), "no draw");
    }

    #[test]
    fn every_shipped_design_has_a_current_study_of_128_draws() {
        for state in ProvidedStudy::states().unwrap() {
            let draws = state.draws.unwrap_or(0);
            assert!(draws >= 128, "{}: {draws} draws", state.design);
            assert!(!state.changed.contains(&"the design"), "{}", state.design);
        }
    }
}
