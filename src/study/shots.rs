//! Designs drawn for the nailing cycle alone: what becomes of each shot.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::Serialize;

use super::law;
use super::parameters::{Parameter, taking_part};
use super::sampling::{Frame, Rejections, Sampler};
use super::screening::cycles_of;
use super::variables::{Drawn, Kind, Scope, Variable, law_scores, without_sensors};
use crate::design::{Design, Value, Values};
use crate::error::Error;
use crate::stages::Progress;
use crate::stages::outcomes::{Fate, fate};

/// Candidates drawn at most for each design asked for, lest a design whose ranges hardly go together never ends.
const MOST_CANDIDATES: usize = 1000;
/// Candidates computed at a time.
const BATCH: usize = 256;

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

/// Draws `count` designs from the ranges of the keys of `design` that take part in the cycle, and computes the cycle of each.
///
/// The draws depend on `seed` and the ranges alone, not on the number of threads. Fewer than `count` designs come back
/// where a thousand candidates for each were not enough.
///
/// # Errors
/// As [`ShotSampler::new`].
pub fn shots(design: &Design, count: usize, seed: u64, progress: &Progress) -> Result<Shots, Error> {
    let sampler = ShotSampler::new(design, seed)?;
    let mut draws = Vec::new();
    let counted = sampler.each(count, progress, |draw| {
        draws.push(draw);
        Ok(())
    })?;
    Ok(Shots {
        seed,
        parameters: sampler.parameters,
        scores: sampler.scores,
        candidates: counted.candidates,
        refused: counted.refused,
        rejections: counted.rejections,
        counts: counted.counts,
        draws,
    })
}

/// What became of the candidates for drawn shots.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Counted {
    /// Designs drawn.
    pub drawn: usize,
    /// Candidates drawn for them, those that were refused among them.
    pub candidates: usize,
    /// How many were refused, by the rule of the cycle that is broken.
    pub refused: BTreeMap<String, usize>,
    /// Values drawn anew because they do not go together, by their keys.
    pub rejections: Rejections,
    /// How many designs came to each end: an outcome, `dry_fire` or `solver_failure`.
    pub counts: BTreeMap<String, usize>,
}

/// Draws designs for the cycle alone, one batch after the other: no draw is kept.
pub struct ShotSampler {
    design: Design,
    sampler: Sampler,
    /// The keys that are drawn.
    pub parameters: Vec<Parameter>,
    /// Names of the scores by which a fitted penetration law is drawn.
    pub scores: Vec<String>,
}

impl ShotSampler {
    /// For the keys of a design that take part in the cycle.
    ///
    /// # Errors
    /// As [`taking_part`].
    pub fn new(design: &Design, seed: u64) -> Result<Self, Error> {
        let mut parameters = taking_part(design)?;
        law::leave_out_held(design, &mut parameters)?;
        let variable = |parameter: &Parameter| Variable {
            name: parameter.key.clone(),
            scope: Scope::Shot,
            kind: Kind::Quantity(parameter.clone()),
        };
        let design = without_sensors(design);
        let scores = law_scores(std::slice::from_ref(&design))?;
        let names = scores.iter().map(|score| score.name.clone()).collect();
        let variables = parameters.iter().map(variable).chain(scores).collect();
        Ok(Self {
            sampler: Sampler::new(&design, variables, seed),
            design,
            parameters,
            scores: names,
        })
    }

    /// Draws `count` designs and hands each to `sink`, in their order.
    ///
    /// # Errors
    /// Those of `sink`.
    pub fn each(
        &self,
        count: usize,
        progress: &Progress,
        mut sink: impl FnMut(DrawnShot) -> Result<(), Error>,
    ) -> Result<Counted, Error> {
        let active = vec![true; self.sampler.variables().len()];
        let bases = [Values::clone(&self.design)];
        let frame = Frame {
            bases: &bases,
            active: &active,
            stream: 0,
            partner_of: None,
        };
        let mut all = Counted::default();
        while all.drawn < count && all.candidates < MOST_CANDIDATES.saturating_mul(count) {
            let first = all.candidates;
            let candidate = |index: usize| {
                let mut rejections = Rejections::new();
                let designs = std::slice::from_ref(&self.design);
                let cycle = cycles_of((designs, &self.sampler), frame, index as u64, &mut rejections);
                let shot = cycle.and_then(|(point, cycles)| match fate(&cycles[0]) {
                    Fate::Refused(reason) => Err(reason),
                    fate => Ok((point, fate)),
                });
                (index, shot, rejections)
            };
            let batch: Vec<_> = (first..first + BATCH).into_par_iter().map(candidate).collect();
            for (candidate, shot, rejections) in batch {
                if all.drawn == count {
                    break;
                }
                all.candidates += 1;
                for (keys, count) in rejections {
                    *all.rejections.entry(keys).or_default() += count;
                }
                match shot {
                    Ok((point, fate)) => {
                        *all.counts.entry(fate.name().to_owned()).or_default() += 1;
                        all.drawn += 1;
                        let value = |drawn| match drawn {
                            Some(Drawn::Value(value)) => Some(value),
                            _ => None,
                        };
                        sink(DrawnShot {
                            candidate,
                            values: point.drawn.into_iter().filter_map(value).collect(),
                            fate,
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
