//! The search: proposals of the optimiser, their shots, and their levels.

use std::path::Path;

use nailnoise_optimisation::{Observation, Optimiser, Space, front};
use serde::Serialize;

use super::constraint::{Constraint, Objective, is_level};
use super::error::OptimisationError;
use super::shot::Shot;
use super::trial::{Candidate, Trial};
use super::variable::{Variable, Varied};
use crate::chain::{Chain, Options};
use crate::cost::MemoryLimit;
use crate::design::{Assignment, Design};
use crate::error::Error;
use crate::graph::Graph;
use crate::model::sources;
use crate::result::{DesignId, TOTAL};
use crate::stages::Progress;
use crate::study::on_threads;

/// Maximum number of candidates for each trial; it ends a search if hardly any shot meets the constraints.
const CANDIDATES_A_TRIAL: usize = 20;

/// The request for a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// The keys that are varied.
    pub vary: Vec<Varied>,
    /// The objectives to minimise; the result for several objectives is a front.
    pub objectives: Vec<Objective>,
    /// The constraints on the designs.
    pub constraints: Vec<Constraint>,
    /// Number of designs whose levels are computed.
    pub trials: usize,
    /// Seed; the same seed tries the same designs.
    pub seed: u64,
    /// Number of designs proposed at a time, independent of each other's results.
    pub batch: usize,
}

/// The designs that a search has tried.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Optimisation {
    /// The design from which it started.
    pub design: DesignId,
    /// The keys that were varied.
    pub variables: Vec<Variable>,
    /// The objectives that were minimised.
    pub objectives: Vec<Objective>,
    /// The constraints on the designs.
    pub constraints: Vec<Constraint>,
    /// Seed.
    pub seed: u64,
    /// The design itself; values outside of the ranges are in words.
    pub start: Trial,
    /// All candidates, in order.
    pub trials: Vec<Trial>,
    /// Indices of the feasible designs that are not dominated in all objectives, sorted by the first objective.
    pub front: Vec<usize>,
}

impl Optimisation {
    /// The designs of the front.
    pub fn best(&self) -> impl Iterator<Item = &Trial> {
        self.front.iter().map(|&place| &self.trials[place])
    }

    /// Number of candidates whose levels were computed.
    pub fn with_levels(&self) -> usize {
        let known = |own: &&Trial| own.shot.as_ref().is_some_and(|shot| shot.levels.is_some());
        self.trials.iter().filter(known).count()
    }

    /// Number of candidates that meet all constraints.
    pub fn feasible(&self) -> usize {
        self.trials.iter().filter(|own| own.feasible).count()
    }
}

/// Searches for the designs with the lowest objectives, based on the design in a file with changes.
///
/// A shot that violates a constraint does not count as a trial; a search ends after `CANDIDATES_A_TRIAL` candidates
/// for each trial. Results are in the store of the graph, so that repeating the request resumes an interrupted search.
/// The callback `fill` receives designs as assignments. It may compute their levels elsewhere and add them to that
/// store before they are needed here.
///
/// # Errors
/// If no design can have the values, or a constraint refers to something that does not exist; the errors of the design
/// itself.
pub fn optimise(
    graph: &Graph,
    (path, changes): (&Path, &[Assignment]),
    request: &Request,
    memory: MemoryLimit,
    progress: &Progress,
    fill: &mut dyn FnMut(&[Vec<Assignment>]) -> Result<(), Error>,
) -> Result<Optimisation, Error> {
    let Request {
        vary,
        objectives,
        constraints,
        ..
    } = request;
    let design = Design::load_with(path, changes)?;
    let dimensions = vary.iter().map(|own| own.of((path, changes)));
    let dimensions: Vec<(Variable, Option<f64>)> = dimensions.collect::<Result<_, Error>>()?;
    let (variables, places): (Vec<Variable>, Vec<Option<f64>>) = dimensions.into_iter().unzip();
    let place: Option<Vec<f64>> = places.iter().copied().collect();
    let twice = variables
        .iter()
        .enumerate()
        .find(|(place, own)| variables[..*place].iter().any(|before| before.key == own.key));
    if let Some((_, own)) = twice {
        let key = own.key.clone();
        return Err(OptimisationError::VariedTwice { key }.into());
    }
    let words = variables.iter().zip(&places).map(|(variable, place)| match place {
        Some(place) => variable.value(*place),
        None => own_value(&design, &variable.key),
    });
    let start = Candidate::new(path, changes, words.collect(), memory).with_levels(graph, constraints);
    if let Some(shot) = &start.shot {
        refuse_unknown(shot, objectives, constraints)?;
    }
    // Structures stay in memory while the designs that share them are computed.
    let anchor = Chain::new(graph, &design, Options::default());
    let optimiser = Optimiser {
        space: Space::new(variables.iter().map(Variable::dimension).collect()),
        seed: request.seed,
    };
    let assigned = |values: &[String]| -> Result<Vec<Assignment>, Error> {
        let own = variables
            .iter()
            .zip(values)
            .map(|(variable, value)| variable.assign(value));
        Ok([changes, &own.collect::<Result<Vec<_>, _>>()?].concat())
    };
    let mut found = Optimisation {
        design: DesignId::from(&design),
        objectives: objectives.clone(),
        constraints: constraints.clone(),
        seed: request.seed,
        start,
        trials: Vec::new(),
        front: Vec::new(),
        variables: variables.clone(),
    };
    let mut observed = Vec::new();
    // The design itself is the first candidate if the ranges include it.
    if let Some(point) = place {
        observed.push(observation(point, &found.start, objectives));
        found.trials.push(found.start.clone());
    }
    while found.with_levels() < request.trials && found.trials.len() < CANDIDATES_A_TRIAL * request.trials {
        let missing = request.trials - found.with_levels();
        let points = optimiser.propose(&observed, request.batch.clamp(1, missing));
        if points.is_empty() {
            break;
        }
        let values = |point: &Vec<f64>| -> Vec<String> {
            let own = variables.iter().zip(point);
            own.map(|(variable, place)| variable.value(*place)).collect()
        };
        let values: Vec<Vec<String>> = points.iter().map(values).collect();
        let assignments = values.iter().map(|own| assigned(own)).collect::<Result<Vec<_>, _>>()?;
        let candidates: Vec<Candidate> = on_threads(values.len(), |place| {
            Candidate::new(path, &assignments[place], values[place].clone(), memory)
        });
        let counting: Vec<bool> = candidates.iter().map(|own| own.counts(constraints)).collect();
        let filled = assignments.into_iter().zip(&counting).filter(|(_, counts)| **counts);
        let filled: Vec<Vec<Assignment>> = filled.map(|(own, _)| own).collect();
        if !filled.is_empty() {
            fill(&filled)?;
        }
        let candidates: Vec<_> = candidates
            .into_iter()
            .map(|own| std::sync::Mutex::new(Some(own)))
            .collect();
        let trials = on_threads(candidates.len(), |place| {
            let own = candidates[place]
                .lock()
                .unwrap_or_else(std::sync::PoisonError::into_inner)
                .take()?;
            Some(match counting[place] {
                true => own.with_levels(graph, constraints),
                false => own.without_levels(constraints),
            })
        });
        for (point, trial) in points.into_iter().zip(trials.into_iter().flatten()) {
            observed.push(observation(point, &trial, objectives));
            found.trials.push(trial);
        }
        progress.done(found.with_levels() as u64, request.trials as u64);
    }
    drop(anchor);
    let feasible: Vec<usize> = (0..observed.len())
        .filter(|&place| observed[place].feasible())
        .collect();
    let scores = feasible.iter().filter_map(|&place| observed[place].objectives.clone());
    let places = front(&scores.collect::<Vec<_>>());
    found.front = places.into_iter().map(|place| feasible[place]).collect();
    Ok(found)
}

/// A trial in the form that the optimiser needs. Whether the values are a valid design is also a constraint.
fn observation(point: Vec<f64>, trial: &Trial, objectives: &[Objective]) -> Observation {
    let is_design = if trial.shot.is_some() { -1.0 } else { 1.0 };
    let shot = trial.shot.as_ref().filter(|shot| shot.levels.is_some());
    Observation {
        point,
        excesses: std::iter::once(Some(is_design))
            .chain(trial.excesses.iter().copied())
            .collect(),
        objectives: shot.and_then(|shot| objectives.iter().map(|own| own.of(shot)).collect()),
    }
}

/// Rejects objectives and constraints on figures that no shot has.
fn refuse_unknown(shot: &Shot, objectives: &[Objective], constraints: &[Constraint]) -> Result<(), Error> {
    let figures = shot.figures.iter().map(|(name, _)| name.as_str());
    let held = constraints
        .iter()
        .filter(|own| !own.is_of_outcome())
        .map(|own| &own.figure);
    let mut named = objectives.iter().map(|own| &own.figure).chain(held);
    let known = |name: &&String| is_level(name) || figures.clone().any(|own| own == name.as_str());
    match named.find(|name| !known(name)) {
        None => Ok(()),
        Some(name) => {
            let levels = sources::ALL.into_iter().map(|source| source.name());
            let known: Vec<&str> = [TOTAL].into_iter().chain(levels).chain(figures.clone()).collect();
            Err(OptimisationError::NoSuchFigure {
                name: name.clone(),
                known: known.join(", "),
            }
            .into())
        }
    }
}

/// The value of a key of the design in a readable unit.
fn own_value(design: &Design, key: &str) -> String {
    let entries = design.entries();
    let value = entries.into_iter().find(|entry| entry.key == key);
    value.map_or_else(String::new, |entry| design.value_in_words(key, entry.value))
}
