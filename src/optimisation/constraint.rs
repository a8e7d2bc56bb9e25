//! Constraints and objectives of an optimisation: figures of the shot, and levels.

use std::str::FromStr;

use nailnoise_quantities::{Dimension, measure};
use serde::Serialize;

use super::error::OptimisationError;
use super::shot::Shot;
use crate::model::sources;
use crate::result::TOTAL;
use crate::wording::unit_of_figure;

/// The outcome of the shot in a constraint.
const OUTCOME: &str = "outcome";

/// Excess of a shot with another outcome or without the figure. The excess of a shot with the required outcome is
/// smaller.
const MISSED: f64 = 1.0;

/// Whether a figure is a level, of a source or of the sum of all.
pub(crate) fn is_level(figure: &str) -> bool {
    figure == TOTAL || sources::by_name(figure).is_some()
}

/// SI unit of a figure; empty for plain numbers.
pub(super) fn unit_of(figure: &str) -> &'static str {
    match figure {
        _ if is_level(figure) => "dB",
        _ => unit_of_figure(figure),
    }
}

/// A limit on a figure of the shot or a level, or the outcome that the shot must have.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Constraint {
    /// As it was given.
    pub text: String,
    /// Name of the figure, or `outcome`.
    pub figure: String,
    #[serde(skip)]
    held: Held,
}

#[derive(Debug, Clone, PartialEq)]
enum Held {
    AtLeast(f64),
    AtMost(f64),
    Outcome(String),
}

impl FromStr for Constraint {
    type Err = OptimisationError;

    /// `penetration >= 80 mm`, `exhaust <= 92 dB` or `outcome == drives`.
    fn from_str(text: &str) -> Result<Self, OptimisationError> {
        let bad = |problem: &str| OptimisationError::BadConstraint {
            text: text.to_owned(),
            problem: problem.to_owned(),
        };
        let relation = |sign: &'static str| Some((sign, text.split_once(sign)?));
        let found = [">=", "<=", "==", "="].into_iter().find_map(relation);
        let (sign, (figure, value)) = found.ok_or_else(|| bad("it has no >=, <= or =="))?;
        let (figure, value) = (figure.trim().to_owned(), value.trim());
        let held = match (figure.as_str(), sign) {
            (OUTCOME, "==" | "=") => Held::Outcome(value.replace(' ', "_")),
            (OUTCOME, _) => return Err(bad("an outcome is held by ==")),
            (_, "==" | "=") => return Err(bad("a figure is held by >= or <=")),
            (_, sign) => {
                let limit = limit(&figure, value).map_err(|problem| bad(&problem))?;
                if sign == ">=" {
                    Held::AtLeast(limit)
                } else {
                    Held::AtMost(limit)
                }
            }
        };
        Ok(Self {
            text: text.to_owned(),
            figure,
            held,
        })
    }
}

/// A limit of a figure in its SI unit.
fn limit(figure: &str, value: &str) -> Result<f64, String> {
    let unit = unit_of(figure);
    if unit == "dB" {
        let number = value.strip_suffix("dB").unwrap_or(value).trim().parse::<f64>();
        return number
            .ok()
            .filter(|number| number.is_finite())
            .ok_or_else(|| "expected a level in dB".to_owned());
    }
    let plain = value.parse::<f64>().is_ok();
    if plain && !unit.is_empty() {
        return Err(format!("the unit of {figure} is missing, as in {value} {unit}"));
    }
    let dimension = Dimension::of_unit(unit).map_err(|error| error.to_string())?;
    measure(value, dimension).map_err(|problem| match unit {
        "" => format!(
            "there is no figure `{figure}` with a unit; figures are total, a source, and those that `nailnoise cycle` \
             prints, such as penetration or head_depth. --vary limits a key of the design"
        ),
        _ => problem,
    })
}

impl Constraint {
    /// Whether it depends on the levels of the design.
    pub(super) fn of_levels(&self) -> bool {
        is_level(&self.figure)
    }

    /// Whether it is about the outcome.
    pub fn is_of_outcome(&self) -> bool {
        self.figure == OUTCOME
    }

    /// Excess of a shot beyond the limit, relative to the limit; at most 0 if the constraint is met. `None` for a level
    /// that was not computed.
    pub(super) fn excess(&self, shot: &Shot) -> Option<f64> {
        let relative = |excess: f64, limit: f64| excess / if limit == 0.0 { 1.0 } else { limit.abs() };
        let value = match &self.held {
            Held::Outcome(outcome) => return Some(if shot.outcome == *outcome { -MISSED } else { MISSED }),
            _ if self.of_levels() && shot.levels.is_none() => return None,
            _ => shot.figure(&self.figure),
        };
        Some(match (&self.held, value) {
            (Held::AtLeast(limit), Some(value)) => relative(limit - value, *limit),
            (Held::AtMost(limit), Some(value)) => relative(value - limit, *limit),
            // Silence is below any limit, and a phase that does not occur has no figure.
            (Held::AtMost(_), None) if self.of_levels() => -MISSED,
            _ => MISSED,
        })
    }
}

/// A figure or level that is minimised, or maximised with a minus before its name.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Objective {
    /// Name of the figure.
    pub figure: String,
    /// Whether more is better.
    pub maximised: bool,
}

impl FromStr for Objective {
    type Err = OptimisationError;

    fn from_str(text: &str) -> Result<Self, OptimisationError> {
        let maximised = text.starts_with('-');
        Ok(Self {
            figure: text.trim_start_matches('-').trim().to_owned(),
            maximised,
        })
    }
}

impl Objective {
    /// The number to minimise. It is large if the figure does not occur, and `None` for a level that was not computed.
    pub(super) fn of(&self, shot: &Shot) -> Option<f64> {
        let value = match shot.figure(&self.figure) {
            Some(value) => value,
            None if is_level(&self.figure) => {
                // No level is lower than silence.
                shot.levels.as_ref()?;
                0.0
            }
            None => return None,
        };
        Some(if self.maximised { -value } else { value })
    }

    /// Text for the objective, with its unit.
    pub(crate) fn words(&self) -> String {
        let name = self.figure.replace('_', " ");
        match self.maximised {
            true => format!("{name}, maximised"),
            false => name,
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::result::Performance;

    fn shot(outcome: &str, penetration: f64) -> Shot {
        Shot {
            outcome: outcome.to_owned(),
            figures: vec![("penetration".to_owned(), Some(penetration))],
            performance: Performance::default(),
            levels: None,
            total_db: None,
        }
    }

    fn excess(text: &str, shot: &Shot) -> Option<f64> {
        text.parse::<Constraint>().unwrap().excess(shot)
    }

    #[test]
    fn an_excess_is_a_part_of_the_limit_and_negative_within() {
        let own = shot("drives", 0.06);
        assert!((excess("penetration >= 80 mm", &own).unwrap() - 0.25).abs() < 1e-12);
        assert!((excess("penetration <= 80 mm", &own).unwrap() + 0.25).abs() < 1e-12);
        assert!(excess("penetration >= 2 in", &own).unwrap() < 0.0);
        assert_eq!(excess("outcome == drives", &own), Some(-1.0));
        assert_eq!(excess("outcome == drives", &shot("underdriven", 0.06)), Some(1.0));
        assert_eq!(excess("exhaust <= 92 dB", &own), None);
    }

    #[test]
    fn what_is_no_constraint_is_refused_with_its_fault() {
        for (text, fault) in [
            ("penetration", "no >="),
            ("penetration == 80 mm", ">= or <="),
            ("penetration >= 80", "missing"),
            ("penetration >= 80 J", "mm"),
            ("outcome >= drives", "=="),
            ("exhaust <= loud", "dB"),
            ("supply.pressure <= 100 psi", "no figure `supply.pressure`"),
        ] {
            let error = text.parse::<Constraint>().unwrap_err().to_string();
            assert!(error.contains(fault), "{text}: {error}");
        }
    }

    #[test]
    fn a_minus_maximises() {
        let own = "-penetration".parse::<Objective>().unwrap();
        assert_eq!(own.of(&shot("drives", 0.06)), Some(-0.06));
        assert_eq!("total".parse::<Objective>().unwrap().of(&shot("drives", 0.06)), None);
    }
}
