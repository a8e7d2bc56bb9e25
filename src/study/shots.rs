//! Designs drawn for the nailing cycle alone: what becomes of each shot.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::Serialize;

use super::law;
use super::parameters::{Parameter, taking_part};
use super::sampling::{Frame, Rejections, Sampler};
use super::screening::block_of;
use super::variables::{Drawn, Kind, Scope, Variable, law_scores, without_sensors};
use crate::design::{Design, Value, Values};
use crate::error::Error;
use crate::graph::Graph;
use crate::stages::outcomes::Fate;
use crate::stages::{Progress, Stage};

/// Candidates drawn at most for each design asked for, lest a design whose ranges hardly go together never ends.
const MOST_CANDIDATES: usize = 1000;
/// Designs drawn from the ranges of one, with their shots.
#[derive(Debug, Clone, Serialize)]
pub struct Shots {
    /// Seed of the draws.
    pub seed: u64,
    /// The keys that were drawn.
    pub parameters: Vec<Parameter>,
    /// Names of the scores by which a fitted penetration law is drawn.
    pub scores: Vec<String>,
    /// Candidates drawn for the designs, those that were refused among them.
    pub candidates: usize,
    /// How many were refused, by the rule of the cycle that is broken.
    pub refused: BTreeMap<String, usize>,
    /// Values drawn anew because they do not go together, by their keys.
    pub rejections: Rejections,
    /// How many designs came to each end: an outcome, `dry_fire` or `solver_failure`.
    pub counts: BTreeMap<String, usize>,
    /// The designs, in the order they were drawn.
    pub draws: Vec<DrawnShot>,
}

/// One design drawn.
#[derive(Debug, Clone, Serialize)]
pub struct DrawnShot {
    /// Number of the candidate.
    pub candidate: usize,
    /// Values of the parameters, then the scores, in their order.
    pub values: Vec<Value>,
    /// What became of it.
    pub fate: Fate,
}

/// The design without its sensors, and the sampler of all that takes part in its cycle.
pub(super) fn shots_sampler(design: &Design, seed: u64) -> Result<(Design, Sampler), Error> {
    let mut parameters = taking_part(design)?;
    law::leave_out_held(design, &mut parameters)?;
    let variable = |parameter: Parameter| Variable {
        name: parameter.key.clone(),
        scope: Scope::Shot,
        kind: Kind::Quantity(parameter),
    };
    let design = without_sensors(design);
    let scores = law_scores(std::slice::from_ref(&design))?;
    let sampler = Sampler::new(
        &design,
        parameters.into_iter().map(variable).chain(scores).collect(),
        seed,
    );
    Ok((design, sampler))
}

/// Draws `count` designs from the ranges of the keys of `design` that take part in the cycle, and computes the cycle of each on a graph.
///
/// The draws depend on `seed` and the ranges alone, not on the number of threads. Fewer than `count` designs come back
/// where a thousand candidates for each were not enough.
///
/// # Errors
/// As [`taking_part`].
pub fn shots(graph: &Graph, design: &Design, count: usize, seed: u64, progress: &Progress) -> Result<Shots, Error> {
    let (design, sampler) = shots_sampler(design, seed)?;
    let (mut parameters, mut scores) = (Vec::new(), Vec::new());
    for variable in sampler.variables() {
        match &variable.kind {
            Kind::Quantity(parameter) => parameters.push(parameter.clone()),
            _ => scores.push(variable.name.clone()),
        }
    }
    let active = vec![true; sampler.variables().len()];
    let bases = [Values::clone(&design)];
    let frame = Frame {
        bases: &bases,
        active: &active,
        stream: 0,
    };
    let mut all = Shots {
        seed,
        parameters,
        scores,
        candidates: 0,
        refused: BTreeMap::new(),
        rejections: Rejections::new(),
        counts: BTreeMap::new(),
        draws: Vec::new(),
    };
    let designs = std::slice::from_ref(&design);
    while all.draws.len() < count && all.candidates < MOST_CANDIDATES.saturating_mul(count) {
        let first = all.candidates;
        let (block, outcomes) = block_of((designs, &sampler), frame, first as u64);
        let fates = match graph.store().folder() {
            Some(_) => graph.get(outcomes)?,
            None => Arc::new(outcomes.compute(progress)?),
        };
        let mut fates = fates.iter();
        for (candidate, (cycles, rejections)) in (first..).zip(block) {
            if all.draws.len() == count {
                break;
            }
            all.candidates += 1;
            for (keys, count) in rejections {
                *all.rejections.entry(keys).or_default() += count;
            }
            let shot = cycles.and_then(|(point, _)| match fates.next() {
                Some(Fate::Refused(reason)) => Err(reason.clone()),
                Some(fate) => Ok((point, fate.clone())),
                None => Err("its computation ended".to_owned()),
            });
            match shot {
                Ok((point, fate)) => {
                    *all.counts.entry(fate.name().to_owned()).or_default() += 1;
                    let value = |drawn| match drawn {
                        Some(Drawn::Value(value)) => Some(value),
                        _ => None,
                    };
                    all.draws.push(DrawnShot {
                        candidate,
                        values: point.drawn.into_iter().filter_map(value).collect(),
                        fate,
                    });
                }
                Err(reason) => *all.refused.entry(reason).or_default() += 1,
            }
        }
        progress.done(all.draws.len() as u64, count as u64);
    }
    Ok(all)
}
