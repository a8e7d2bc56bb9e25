//! A trial design: its shot, and its levels if the shot meets the constraints.

use serde::Serialize;

use super::constraint::{Constraint, DRIVE_ENERGY};
use crate::chain::{self, Chain, Options};
use crate::cost::{self, MemoryLimit};
use crate::design::{Assignment, Design};
use crate::error::Error;
use crate::graph::Graph;
use crate::result::TOTAL;
use crate::stages::levels::Levels;
use crate::study::{levels_of_shot, total_of, without_sensors};

/// A trial design.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trial {
    /// The value of each variable, written as in a design file but without quotes.
    pub values: Vec<String>,
    /// Its shot; `None` if the values are not a valid design or the shot cannot be computed.
    #[serde(flatten)]
    pub shot: Option<Shot>,
    /// Excess beyond each constraint relative to the limit; the constraint is met if the excess is at most 0. `None` if
    /// unknown.
    pub excesses: Vec<Option<f64>>,
    /// Whether its levels are known and it meets all constraints.
    pub feasible: bool,
    /// Reason why it is not a valid design; empty otherwise.
    pub refused: String,
}

/// The shot of a design.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Shot {
    /// Name of the outcome.
    pub outcome: String,
    /// Name and value of each figure of the cycle \[SI\]; `None` for a phase that does not occur.
    #[serde(serialize_with = "as_object")]
    pub figures: Vec<(String, Option<f64>)>,
    /// Levels of the sources; `None` if the shot violates a constraint.
    pub levels: Option<Levels>,
    /// Level of the sum of all sources \[dB re 1 pW s\].
    pub total_db: Option<f64>,
}

fn as_object<S: serde::Serializer>(figures: &[(String, Option<f64>)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(figures.iter().map(|(name, value)| (name, value)))
}

impl Shot {
    /// The cycle of a design, without levels.
    ///
    /// # Errors
    /// The errors of the cycle.
    fn of(design: &Design) -> Result<Self, Error> {
        let record = chain::cycle(design)?;
        let summary = serde_json::to_value(&record.summary).map_err(Error::Json)?;
        let figures = summary.as_object().into_iter().flatten();
        let figures = figures.map(|(name, value)| (name.clone(), value.as_f64()));
        let work = (DRIVE_ENERGY.to_owned(), Some(record.energy.penetration));
        Ok(Self {
            outcome: record.outcome.name().to_owned(),
            figures: figures.chain([work]).collect(),
            levels: None,
            total_db: None,
        })
    }

    /// The figure of the cycle \[SI\] or the level \[dB re 1 pW s\] with this name; `None` if it does not occur, is
    /// silent, or was not computed.
    pub fn figure(&self, name: &str) -> Option<f64> {
        if name == TOTAL {
            return self.total_db;
        }
        let of_source = self.levels.iter().flat_map(|levels| &levels.sources);
        let level = of_source.into_iter().find(|source| source.source == name);
        match level {
            Some(source) => source.lwa_db,
            None => self.figures.iter().find(|(own, _)| own == name)?.1,
        }
    }
}

/// A candidate whose cycle is known, but not yet its levels.
pub(super) struct Candidate {
    /// The values of the variables, and the assignments that make the design.
    pub(super) values: Vec<String>,
    design: Result<(Design, Shot), String>,
}

impl Candidate {
    /// The design of a file with these assignments and its cycle. Values that are not a valid design also give a
    /// result.
    pub(super) fn new(
        path: &std::path::Path,
        assignments: &[Assignment],
        values: Vec<String>,
        memory: MemoryLimit,
    ) -> Self {
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

    /// Excess beyond each constraint, as far as it follows from the cycle.
    fn excesses(&self, constraints: &[Constraint]) -> Vec<Option<f64>> {
        let shot = self.design.as_ref().ok().map(|(_, shot)| shot);
        constraints.iter().map(|own| own.excess(shot?)).collect()
    }

    /// Whether its cycle meets the constraints, so that its levels are computed.
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
                    // With the response of its support, the shot may have another outcome than the cycle alone.
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
