//! A design that is tried: its shot, and its levels where the shot meets the constraints.

use std::path::Path;

use serde::Serialize;

use super::constraint::Constraint;
use super::shot::Shot;
use crate::chain::{Chain, Options};
use crate::cost::{self, MemoryLimit};
use crate::design::{Assignment, Design};
use crate::error::Error;
use crate::graph::Graph;
use crate::study::{levels_of_shot, total_of, without_sensors};

/// A design that was tried.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trial {
    /// The value of each variable, as in a design file, without quotes.
    pub values: Vec<String>,
    /// Its shot; none if the values are no design or the shot cannot be computed.
    #[serde(flatten)]
    pub shot: Option<Shot>,
    /// How far it is beyond each constraint, in parts of the limit; met where at most 0. None where that is not known.
    pub excesses: Vec<Option<f64>>,
    /// Whether its levels are known and it meets all constraints.
    pub feasible: bool,
    /// Why it is no design; empty for a design.
    pub refused: String,
}

/// A candidate between its cycle and its levels.
pub(super) struct Candidate {
    /// The values of the variables, and the assignments that make the design.
    pub(super) values: Vec<String>,
    design: Result<(Design, Shot), String>,
}

impl Candidate {
    /// The design of a file with these assignments and its cycle. Values that are no design are a result, too.
    pub(super) fn new(path: &Path, assignments: &[Assignment], values: Vec<String>, memory: MemoryLimit) -> Self {
        let made = || -> Result<(Design, Shot), Error> {
            let design = without_sensors(&Design::load_with(path, assignments)?);
            let shot = Shot::of(&design)?;
            cost::refuse(&design, &cost::of_run(&design)?, memory)?;
            Ok((design, shot))
        };
        Self {
            values,
            design: made().map_err(|error| error.in_words()),
        }
    }

    /// How far it is beyond each constraint, as far as its cycle says.
    fn excesses(&self, constraints: &[Constraint]) -> Vec<Option<f64>> {
        let shot = self.design.as_ref().ok().map(|(_, shot)| shot);
        constraints.iter().map(|own| own.excess(shot?)).collect()
    }

    /// Whether its cycle meets the constraints, so that its levels count.
    pub(super) fn counts(&self, constraints: &[Constraint]) -> bool {
        let met = |excess: &Option<f64>| excess.is_none_or(|excess| excess <= 0.0);
        self.design.is_ok() && self.excesses(constraints).iter().all(met)
    }

    /// The trial without levels.
    pub(super) fn without_levels(self, constraints: &[Constraint]) -> Trial {
        let excesses = self.excesses(constraints);
        let (shot, refused) = match self.design {
            Ok((_, shot)) => (Some(shot), String::new()),
            Err(reason) => (None, reason),
        };
        Trial {
            values: self.values,
            shot,
            excesses,
            feasible: false,
            refused,
        }
    }

    /// The trial with its levels.
    pub(super) fn with_levels(mut self, graph: &Graph, constraints: &[Constraint]) -> Trial {
        if let Ok((design, shot)) = &mut self.design {
            match levels_of_shot(Chain::new(graph, design, Options::default())) {
                Ok(levels) => {
                    shot.total_db = total_of(&levels);
                    // The shot with the response of its support may end otherwise than the one of the cycle alone.
                    shot.outcome.clone_from(&levels.outcome);
                    shot.levels = Some(levels);
                }
                Err(error) => self.design = Err(error.in_words()),
            }
        }
        let mut trial = self.without_levels(constraints);
        let met = |excess: &Option<f64>| excess.is_some_and(|excess| excess <= 0.0);
        trial.feasible =
            trial.shot.as_ref().is_some_and(|shot| shot.levels.is_some()) && trial.excesses.iter().all(met);
        trial
    }
}
