//! Candidates and their shots: the inexpensive part of a study, before any sound is computed.

use std::collections::BTreeMap;
use std::ops::Range;

use rayon::prelude::*;

use super::condition::Counts;
use super::request::Subset;
use super::sampling::{Frame, Point, Rejections, Sampler};
use super::variables::drawn_scores;
use crate::chain::engine;
use crate::design::{Design, Values};
use crate::error::Error;
use crate::graph::Graph;
use crate::stages::cycle::Engine;
use crate::stages::outcomes::{Outcomes, ShotOutcome};
use crate::study::StudyError;

/// Number of candidates that are computed and stored at a time. Only one partner of a point is needed. For a partner,
/// this is the first number, which then doubles each time.
pub(super) const BLOCK: u64 = 64;
const FIRST_BLOCK: u64 = 2;
/// Maximum number of candidates for each requested draw, and before any is accepted.
const MOST: u64 = 1000;
const MOST_IN_VAIN: u64 = 4096;
/// Sampling interval \[s\]; outcomes need no samples.
const SAMPLES: f64 = 1e-3;

/// A candidate whose shots were computed.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Its number in the sequence.
    pub index: u64,
    /// The drawn point.
    pub point: Point,
    /// Outcome of its shot in each design.
    pub outcomes: Vec<ShotOutcome>,
}

/// Outcomes of all candidates.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Tally {
    /// Number of candidates drawn.
    pub candidates: u64,
    /// Number of values drawn again because of conflicts, by their keys.
    pub rejections: Rejections,
    /// Number of candidates that are not valid designs, by reason.
    pub refused: BTreeMap<String, u64>,
    /// Number of shots by outcome, `dry_fire` or `solver_failure`.
    pub outcomes: BTreeMap<String, u64>,
    /// Candidates whose shot cannot be computed, with the message.
    pub failures: Vec<(u64, String)>,
    /// Positions of the counting shots in the distributions.
    pub condition: Counts,
}

impl Tally {
    /// Adds another tally. The condition remains that of the first, because further candidates on an accepted structure
    /// are not independent of it.
    pub fn add(&mut self, other: Self) {
        self.candidates += other.candidates;
        let into = |own: &mut BTreeMap<String, u64>, counts: BTreeMap<String, u64>| {
            counts
                .into_iter()
                .for_each(|(name, count)| *own.entry(name).or_default() += count);
        };
        into(&mut self.rejections, other.rejections);
        into(&mut self.refused, other.refused);
        into(&mut self.outcomes, other.outcomes);
        self.failures.extend(other.failures);
    }

    /// Number of shots that were computed.
    pub fn shots(&self) -> u64 {
        self.outcomes.values().sum()
    }
}

/// The design with these values.
pub(crate) fn with_values(design: &Design, values: &Values) -> Design {
    let mut design = design.clone();
    *std::ops::DerefMut::deref_mut(&mut design) = values.clone();
    design
}

/// The design of a point.
pub(crate) fn drawn(design: &Design, sampler: &Sampler, base: &Values, point: &Point) -> Result<Design, String> {
    let mut drawn = with_values(design, base);
    drawn.set(&sampler.changes(point)).map_err(|error| error.to_string())?;
    drawn.draw_law(drawn_scores(sampler.variables(), &point.shares));
    match drawn.conflict() {
        Some(conflict) => Err(conflict.keys().join(", ")),
        None => Ok(drawn),
    }
}

/// A candidate's point and the cycle of each design, or the reason why it is not a valid design.
pub(super) fn cycles_of(
    (designs, sampler): (&[Design], &Sampler),
    frame: Frame<'_>,
    index: u64,
    rejections: &mut Rejections,
) -> Result<(Point, Vec<Engine>), String> {
    let point = sampler
        .point(frame, index, rejections)
        .map_err(|error| error.to_string())?;
    let cycle = |(design, base): (&Design, &Values)| {
        let design = drawn(design, sampler, base, &point)?;
        let engine = engine(&design).map_err(|error| error.to_string())?;
        Ok(engine.sampled(SAMPLES))
    };
    let cycles = designs
        .iter()
        .zip(frame.bases)
        .map(cycle)
        .collect::<Result<_, String>>()?;
    Ok((point, cycles))
}

/// A candidate before its shot: its point and cycles, or the reason why it is not a valid design; and the values that
/// were drawn again for it.
pub(super) type Prepared = (Result<(Point, Vec<Engine>), String>, Rejections);

/// The candidates of a block, and the stage that computes their shots.
pub(super) fn block_of(
    (designs, sampler): (&[Design], &Sampler),
    frame: Frame<'_>,
    indices: Range<u64>,
) -> (Vec<Prepared>, Outcomes) {
    let candidate = |index: u64| {
        let mut rejections = Rejections::new();
        let cycles = cycles_of((designs, sampler), frame, index, &mut rejections);
        (cycles, rejections)
    };
    let block: Vec<Prepared> = indices.into_par_iter().map(candidate).collect();
    let cycles = block
        .iter()
        .filter_map(|(cycles, _)| Some(cycles.as_ref().ok()?.1.clone()));
    let engines = cycles.flatten().collect();
    (block, Outcomes { engines })
}

/// The name under which the outcomes of a candidate are counted: a single name, or those of all designs.
fn name(outcomes: &[ShotOutcome]) -> String {
    let mut names: Vec<&str> = outcomes.iter().map(ShotOutcome::name).collect();
    names.dedup();
    names.join(" / ")
}

/// Draws candidates in the order of the sequence until `want` of them are accepted in all of the designs. Returns fewer
/// if 1000 candidates for each are not enough. Tasks that share a store share the work. In each round with as many
/// blocks as tasks, each task computes one, and then reads those of the others that are stored by then.
///
/// # Errors
/// [`StudyError::NothingDrawn`] if no candidate is accepted.
pub fn screen(
    graph: &Graph,
    (designs, sampler): (&[Design], &Sampler),
    frame: Frame<'_>,
    want: usize,
    part: Subset,
    found: impl Fn(usize),
) -> Result<(Vec<Candidate>, Tally), Error> {
    let (mut accepted, mut tally) = (Vec::new(), Tally::default());
    let mut size = match frame.partner_of {
        Some(_) => FIRST_BLOCK,
        None => BLOCK,
    };
    let block = |first: u64, size: u64| block_of((designs, sampler), frame, first..first + size);
    while accepted.len() < want && tally.candidates < MOST.saturating_mul(want as u64) {
        if accepted.is_empty() && tally.candidates >= MOST_IN_VAIN {
            break;
        }
        let first = tally.candidates;
        if let Subset::Task { number, of } = part
            && (first / BLOCK).is_multiple_of(u64::from(of))
        {
            graph.get(block(first + u64::from(number - 1) * BLOCK, BLOCK).1)?;
        }
        let (block, outcomes) = block(first, size);
        size = BLOCK.min(2 * size);
        let outcomes = graph.get(outcomes)?;
        let mut outcomes = outcomes.chunks(designs.len());
        for (index, (cycles, rejections)) in (first..).zip(block) {
            if accepted.len() == want {
                break;
            }
            tally.candidates += 1;
            for (keys, count) in rejections {
                *tally.rejections.entry(keys).or_default() += count;
            }
            let (point, outcomes) = match cycles {
                Ok((point, _)) => (point, outcomes.next().unwrap_or_default().to_vec()),
                Err(reason) => {
                    *tally.refused.entry(reason).or_default() += 1;
                    continue;
                }
            };
            let refused = outcomes.iter().find_map(|outcome| match outcome {
                ShotOutcome::Refused(reason) => Some(reason.clone()),
                _ => None,
            });
            if let Some(reason) = refused {
                *tally.refused.entry(reason).or_default() += 1;
                continue;
            }
            *tally.outcomes.entry(name(&outcomes)).or_default() += 1;
            let messages = outcomes.iter().filter_map(|outcome| match outcome {
                ShotOutcome::SolverFailure(message) => Some((index, message.clone())),
                _ => None,
            });
            tally.failures.extend(messages);
            let counts = outcomes
                .iter()
                .zip(designs)
                .all(|(outcome, design)| qualifies(design, outcome));
            tally.condition.add(&point.shares, counts);
            if counts {
                accepted.push(Candidate { index, point, outcomes });
            }
        }
        found(accepted.len());
    }
    if accepted.is_empty() && want > 0 {
        let counted = |counts: &BTreeMap<String, u64>, space: &str| {
            let counts = counts
                .iter()
                .map(|(name, count)| format!("{} ({count})", name.replace('_', space)));
            counts.collect::<Vec<_>>().join(", ")
        };
        return Err(StudyError::NothingDrawn {
            candidates: tally.candidates,
            outcomes: counted(&tally.outcomes, " "),
            refused: counted(&tally.refused, "_"),
            require: designs[0].study().require.join(", "),
        }
        .into());
    }
    Ok((accepted, tally))
}

/// Whether a study of a design counts a shot.
pub(super) fn qualifies(design: &Design, outcome: &ShotOutcome) -> bool {
    let require = &design.study().require;
    match outcome {
        ShotOutcome::Shot(shot) => require.is_empty() || require.contains(&shot.outcome),
        ShotOutcome::DryFire | ShotOutcome::SolverFailure(_) | ShotOutcome::Refused(_) => false,
    }
}
