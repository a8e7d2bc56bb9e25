//! Designs drawn only for the nailing cycle, with the outcome of each shot.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::Serialize;

use super::law;
use super::parameters::{Parameter, taking_part};
use super::sampling::{Frame, Rejections, Sampler};
use super::screening::{BLOCK, block_of};
use super::variables::{Drawn, Scope, Variable, VariableKind, law_scores, without_sensors};
use crate::design::{Design, Value, Values};
use crate::error::Error;
use crate::graph::Graph;
use crate::stages::outcomes::ShotOutcome;
use crate::stages::{Progress, Stage};

/// Maximum number of candidates drawn for each requested design, so that drawing ends if the ranges hardly ever yield
/// compatible values.
const MOST_CANDIDATES: usize = 1000;

/// Designs drawn from the ranges of one, with their shots.
#[derive(Debug, Clone, Serialize)]
pub struct Shots {
    /// Seed of the draws.
    pub seed: u64,
    /// The keys that were drawn.
    pub parameters: Vec<Parameter>,
    /// Names of the scores with which a fitted penetration law is drawn.
    pub scores: Vec<String>,
    /// Outcomes of the candidates.
    #[serde(flatten)]
    pub counted: Counted,
    /// The designs, in the order in which they were drawn.
    pub draws: Vec<DrawnShot>,
}

/// A drawn design.
#[derive(Debug, Clone, Serialize)]
pub struct DrawnShot {
    /// Number of the candidate.
    pub candidate: usize,
    /// Values of the parameters, then the scores, in their order.
    pub values: Vec<Value>,
    /// Outcome of its shot.
    pub outcome: ShotOutcome,
}

/// Draws `count` designs from the ranges of the keys of `design` that affect the cycle, and computes the cycle of each
/// on a graph.
///
/// The draws depend only on `seed` and the ranges, not on the number of threads. Returns fewer than `count` designs if
/// a thousand candidates for each are not enough.
///
/// # Errors
/// Same as [`ShotSampler::new`].
pub fn shots(graph: &Graph, design: &Design, count: usize, seed: u64, progress: &Progress) -> Result<Shots, Error> {
    let sampler = ShotSampler::new(design, seed)?;
    let mut draws = Vec::new();
    let counted = sampler.each(graph, count, progress, |draw| {
        draws.push(draw);
        Ok(())
    })?;
    Ok(Shots {
        seed,
        parameters: sampler.parameters,
        scores: sampler.scores,
        counted,
        draws,
    })
}

/// Outcomes of the candidates for drawn shots.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Counted {
    /// Number of designs drawn. It is the length of their list, so it is not written.
    #[serde(skip)]
    pub drawn: usize,
    /// Number of candidates drawn for them, including rejected ones.
    pub candidates: usize,
    /// Number of rejected candidates, by the rule of the cycle that is broken.
    pub refused: BTreeMap<String, usize>,
    /// Number of values drawn again because of conflicts, by their keys.
    pub rejections: Rejections,
    /// Number of designs with each result: an outcome, `dry_fire` or `solver_failure`.
    pub counts: BTreeMap<String, usize>,
}

/// Only the variables of the cycle: its keys, and the scores of a fitted penetration law.
///
/// # Errors
/// Same as [`taking_part`].
pub fn cycle_variables(design: &Design) -> Result<Vec<Variable>, Error> {
    let mut parameters = taking_part(design)?;
    law::leave_out_held(design, &mut parameters)?;
    let variable = |parameter: Parameter| Variable {
        name: parameter.key.clone(),
        scope: Scope::Shot,
        kind: VariableKind::Quantity(parameter),
    };
    let scores = law_scores(std::slice::from_ref(&without_sensors(design)))?;
    Ok(parameters.into_iter().map(variable).chain(scores).collect())
}

/// Draws designs only for the cycle, in batches; no draw is stored.
pub struct ShotSampler {
    pub(super) design: Design,
    pub(super) sampler: Sampler,
    /// The keys that are drawn.
    pub parameters: Vec<Parameter>,
    /// Names of the scores with which a fitted penetration law is drawn.
    pub scores: Vec<String>,
}

impl ShotSampler {
    /// For the keys of a design that affect the cycle.
    ///
    /// # Errors
    /// Same as [`taking_part`].
    pub fn new(design: &Design, seed: u64) -> Result<Self, Error> {
        let variables = cycle_variables(design)?;
        let design = without_sensors(design);
        let parameter = |own: &Variable| match &own.kind {
            VariableKind::Quantity(parameter) => Some(parameter.clone()),
            _ => None,
        };
        let is_score = |own: &&Variable| matches!(own.kind, VariableKind::LawScore);
        Ok(Self {
            parameters: variables.iter().filter_map(parameter).collect(),
            scores: variables.iter().filter(is_score).map(|own| own.name.clone()).collect(),
            sampler: Sampler::new(&design, variables, seed),
            design,
        })
    }

    /// Draws `count` designs, computes their cycles on a graph and passes each to `sink`, in order.
    ///
    /// # Errors
    /// The errors of the graph and of `sink`.
    pub fn each(
        &self,
        graph: &Graph,
        count: usize,
        progress: &Progress,
        mut sink: impl FnMut(DrawnShot) -> Result<(), Error>,
    ) -> Result<Counted, Error> {
        let active = vec![true; self.sampler.variables().len()];
        let bases = [Values::clone(&self.design)];
        let frame = Frame::new(&bases, &active, 0);
        let designs = std::slice::from_ref(&self.design);
        let mut all = Counted::default();
        while all.drawn < count && all.candidates < MOST_CANDIDATES.saturating_mul(count) {
            let first = all.candidates;
            let block = first as u64..first as u64 + BLOCK;
            let (block, outcomes) = block_of((designs, &self.sampler), frame, block);
            // Without a store, a graph would retain the outcomes of all blocks.
            let outcomes = match graph.store().folder() {
                Some(_) => graph.get(outcomes)?,
                None => Arc::new(outcomes.compute(progress)?),
            };
            let mut outcomes = outcomes.iter();
            for (candidate, (cycles, rejections)) in (first..).zip(block) {
                if all.drawn == count {
                    break;
                }
                all.candidates += 1;
                for (keys, count) in rejections {
                    *all.rejections.entry(keys).or_default() += count;
                }
                let shot = cycles.and_then(|(point, _)| match outcomes.next() {
                    Some(ShotOutcome::Refused(reason)) => Err(reason.clone()),
                    Some(outcome) => Ok((point, outcome.clone())),
                    None => Err("its computation ended".to_owned()),
                });
                match shot {
                    Ok((point, outcome)) => {
                        *all.counts.entry(outcome.name().to_owned()).or_default() += 1;
                        all.drawn += 1;
                        let value = |(variable, share): (&Variable, &f64)| match variable.drawn(*share) {
                            Some(Drawn::Value(value)) => Some(value),
                            _ => None,
                        };
                        let variables = self.sampler.variables();
                        sink(DrawnShot {
                            candidate,
                            values: variables.iter().zip(&point.shares).filter_map(value).collect(),
                            outcome,
                        })?;
                    }
                    Err(reason) => *all.refused.entry(reason).or_default() += 1,
                }
            }
            progress.done(all.drawn as u64, count as u64);
        }
        Ok(all)
    }
}
