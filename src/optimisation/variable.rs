//! Keys of a design as dimensions of a search.

use std::path::Path;
use std::str::FromStr;

use nailnoise_optimisation::Dimension;
use serde::Serialize;

use super::error::OptimisationError;
use crate::design::{Assignment, Design, DesignError, Problem, Value};
use crate::error::Error;
use crate::study::{StudyError, number_and_unit};

/// Maximum number of integers in a range.
const MOST_STEPS: f64 = 1e5;

/// A key with a range or choices, as given on the command line: `KEY=LOW..HIGH`, `KEY=LOW..HIGH:log` or `KEY=A,B,C`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Varied {
    key: String,
    values: String,
}

/// A key that is varied.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Variable {
    /// Full name of the key.
    pub key: String,
    /// Its values.
    #[serde(flatten)]
    pub domain: Domain,
}

/// Values of a key that is varied.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Domain {
    /// A range in the unit that was given.
    Range {
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
        /// Unit; empty for plain numbers.
        unit: String,
        /// Whether only integers are valid.
        whole: bool,
        /// Whether equal ratios are equally likely, instead of equal differences.
        log: bool,
    },
    /// Values without an order, written as in a design file but without quotes.
    Choices(Vec<String>),
}

impl FromStr for Varied {
    type Err = OptimisationError;

    fn from_str(text: &str) -> Result<Self, OptimisationError> {
        let parts = text.split_once('=').map(|(key, values)| (key.trim(), values.trim()));
        let given = parts.filter(|(key, values)| !key.is_empty() && !values.is_empty());
        let (key, values) = given.ok_or_else(|| OptimisationError::NotVaried { text: text.to_owned() })?;
        let choices = || values.split(',').map(str::trim);
        if !values.contains("..") && (choices().count() < 2 || choices().any(str::is_empty)) {
            return Err(OptimisationError::NotVaried { text: text.to_owned() });
        }
        Ok(Self {
            key: key.to_owned(),
            values: values.to_owned(),
        })
    }
}

impl Varied {
    /// The variable in a design file with these changes; designs are read at the ends of the range, or with each of the
    /// choices.
    ///
    /// # Errors
    /// If no design can have the values, or the range is empty.
    pub(super) fn of(&self, base: (&Path, &[Assignment])) -> Result<(Variable, Option<f64>), Error> {
        let variable = Variable {
            key: self.key.clone(),
            domain: self.domain(base)?,
        };
        let own = variable.place_of(base)?;
        Ok((variable, own))
    }

    fn domain(&self, (path, changes): (&Path, &[Assignment])) -> Result<Domain, Error> {
        let Some((low, rest)) = self.values.split_once("..") else {
            return Ok(Domain::Choices(
                self.values.split(',').map(|choice| choice.trim().to_owned()).collect(),
            ));
        };
        let bad = |problem: String| OptimisationError::BadRange {
            key: self.key.clone(),
            problem,
        };
        let (high, log) = match rest.split_once(':') {
            None => (rest, false),
            Some((high, "log")) => (high, true),
            Some((_, scale)) => return Err(bad(format!("`{scale}` is not a scale; `log` is one")).into()),
        };
        let ((low, unit_of_low), (high, unit)) =
            (number_and_unit(low).map_err(bad)?, number_and_unit(high).map_err(bad)?);
        if !unit_of_low.is_empty() && unit_of_low != unit {
            return Err(bad(format!("its ends are in `{unit_of_low}` and `{unit}`")).into());
        }
        let counts = |design: &Design| {
            let entries = design.entries();
            let own = entries.into_iter().find(|entry| entry.key == self.key);
            own.is_some_and(|entry| matches!(entry.value, Value::Count(_)))
        };
        let whole = counts(&Design::load_with(path, changes)?);
        let [from, to] = if whole { [low.ceil(), high.floor()] } else { [low, high] };
        if from >= to || (log && from <= 0.0) {
            return Err(bad(format!("{} is empty or not above zero", self.values)).into());
        }
        if whole && to - from > MOST_STEPS {
            return Err(bad(format!("it has more than {MOST_STEPS} whole numbers")).into());
        }
        Ok(Domain::Range {
            low: from,
            high: to,
            unit,
            whole,
            log,
        })
    }
}

impl Variable {
    /// The variable as a dimension of a search.
    pub(super) fn dimension(&self) -> Dimension {
        match &self.domain {
            Domain::Choices(choices) => Dimension::Choices(choices.len()),
            Domain::Range { whole: false, .. } => Dimension::Real,
            Domain::Range { low, high, .. } => {
                let numbers = (*low as i64)..=(*high as i64);
                Dimension::Ordered(numbers.map(|number| self.share(number as f64)).collect())
            }
        }
    }

    /// Position of a number in its unit within a range, 0 to 1; 0 for choices.
    fn share(&self, number: f64) -> f64 {
        match &self.domain {
            Domain::Choices(_) => 0.0,
            Domain::Range {
                low, high, log: false, ..
            } => (number - low) / (high - low),
            Domain::Range { low, high, .. } => (number / low).ln() / (high / low).ln(),
        }
    }

    /// The value at a position in the dimension, written as in a design file but without quotes.
    pub(super) fn value(&self, place: f64) -> String {
        match &self.domain {
            Domain::Choices(choices) => choices.get(place as usize).cloned().unwrap_or_default(),
            Domain::Range {
                low,
                high,
                unit,
                whole,
                log,
            } => {
                let number = match log {
                    true => low * (high / low).powf(place),
                    false => low + place * (high - low),
                };
                if *whole {
                    return format!("{number:.0}");
                }
                // Six digits are readable and more than a workshop needs.
                let number: f64 = format!("{number:.5e}").parse().unwrap_or(number);
                format!("{number} {unit}").trim_end().to_owned()
            }
        }
    }

    /// The assignment of a value.
    ///
    /// # Errors
    /// If the text cannot be a key or a value.
    pub(super) fn assign(&self, value: &str) -> Result<Assignment, Error> {
        let text = format!("{}={value}", self.key);
        text.parse().map_err(|error| StudyError::NoAxis { error }.into())
    }

    /// The position of the design's own value in the dimension; `None` if it is outside.
    fn place_of(&self, (path, changes): (&Path, &[Assignment])) -> Result<Option<f64>, Error> {
        let with = |value: &str| -> Result<Design, Error> {
            Ok(Design::load_with(path, &[changes, &[self.assign(value)?]].concat())?)
        };
        let own = Design::load_with(path, changes)?;
        match &self.domain {
            Domain::Choices(choices) => {
                let mut place = None;
                for (number, choice) in choices.iter().enumerate() {
                    if with(choice)?.digest() == own.digest() {
                        place = place.or(Some(number as f64));
                    }
                }
                Ok(place)
            }
            Domain::Range { low, high, unit, .. } => {
                let number = |design: &Design| {
                    let entries = design.entries();
                    match &entries.iter().find(|entry| entry.key == self.key)?.value {
                        Value::Number(number) => Some(*number),
                        Value::Count(count) => Some(f64::from(*count)),
                        _ => None,
                    }
                };
                let at = |end: f64| match with(&format!("{end} {unit}")) {
                    Ok(design) => Ok(number(&design)),
                    // Ends that conflict with other values are not a fault of the range.
                    Err(Error::Design(DesignError {
                        problem: Problem::Conflict { .. },
                        ..
                    })) => Ok(None),
                    Err(error) => Err(error),
                };
                let [Some(from), Some(to)] = [at(*low)?, at(*high)?] else {
                    return Ok(None);
                };
                let part = number(&own).map(|number| (number - from) / (to - from));
                // Rounding may place a value just outside an end.
                let part = part.filter(|part| (-1e-9..=1.0 + 1e-9).contains(part));
                Ok(part.map(|part| self.share(low + part.clamp(0.0, 1.0) * (high - low))))
            }
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    const SMALL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/small.toml");

    fn variable(text: &str) -> Result<(Variable, Option<f64>), Error> {
        text.parse::<Varied>()?.of((Path::new(SMALL), &[]))
    }

    #[test]
    fn a_range_of_a_count_has_whole_numbers_and_the_designs_own_place() {
        let (own, place) = variable("exhaust.holes=2..9").unwrap();
        let Dimension::Ordered(shares) = own.dimension() else {
            panic!("{own:?}")
        };
        let values: Vec<String> = shares.iter().map(|share| own.value(*share)).collect();
        assert_eq!(values, ["2", "3", "4", "5", "6", "7", "8", "9"]);
        let holes = Design::load(SMALL).unwrap().exhaust.holes;
        assert_eq!(own.value(place.unwrap()), holes.to_string());
    }

    #[test]
    fn values_have_the_unit_that_was_given_and_six_digits() {
        let (own, place) = variable("supply.pressure=50psig..150psig").unwrap();
        assert_eq!(
            [0.0, 1.0 / 3.0, 1.0].map(|share| own.value(share)),
            ["50 psig", "83.3333 psig", "150 psig"]
        );
        let set = Design::load_with(SMALL, &[own.assign(&own.value(place.unwrap())).unwrap()]).unwrap();
        let pressure = Design::load(SMALL).unwrap().supply.pressure;
        assert!((set.supply.pressure / pressure - 1.0).abs() < 1e-5);
    }

    #[test]
    fn a_logarithmic_range_has_equal_ratios() {
        let (own, _) = variable("wood.loss_factor=0.01..0.16:log").unwrap();
        assert_eq!([0.0, 0.5, 1.0].map(|share| own.value(share)), ["0.01", "0.04", "0.16"]);
        let (own, _) = variable("exhaust.holes=1..16:log").unwrap();
        let Dimension::Ordered(shares) = own.dimension() else {
            panic!("{own:?}")
        };
        assert_eq!((shares[3], own.value(shares[3])), (0.5, "4".to_owned()));
    }

    #[test]
    fn what_cannot_be_searched_is_refused() {
        for text in [
            "exhaust.holes",
            "exhaust.holes=",
            "exhaust.holes=3",
            "exhaust.holes=3,,4",
            "=1..2",
        ] {
            assert!(text.parse::<Varied>().is_err(), "{text}");
        }
        for text in [
            "exhaust.holes=9..2",
            "exhaust.holes=2.2..2.8",
            "supply.pressure=80psig..6bar",
            "supply.pressure=80psig..110psig:cubic",
            "wood.loss_factor=0..1:log",
            "exhaust.hole=1..9",
        ] {
            assert!(variable(text).is_err(), "{text}");
        }
    }
}
