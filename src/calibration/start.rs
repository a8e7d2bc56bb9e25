//! Candidates with the observed outcomes: draws from the ranges of the design, in the order of the study's sequence.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;

use nailnoise_calibration::likelihood::{Likelihood, Prediction};
use nailnoise_calibration::sampler::Candidate;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::error::CalibrationError;
use super::random::standard_normal;
use super::tool::Tool;
use crate::design::Values;
use crate::study::{Frame, Rejections};

/// Largest number of candidates before the first is accepted, and per draw.
const MOST_IN_VAIN: u64 = 4096;
const MOST: u64 = 200;

/// Distinguishes these random numbers from those of the sequence.
const SHARED: u64 = 0x5EED_5A4E_D001;

/// Candidates so far.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct Start {
    /// Candidates with the observed outcomes.
    pub(super) accepted: Vec<Candidate>,
    /// Total number drawn.
    pub(super) drawn: u64,
    /// The rejected ones, by the condition and outcome at which they failed.
    pub(super) refused: BTreeMap<String, u64>,
    /// Smallest and largest value of each reading by outcome, over all shots under its condition.
    pub(super) reached: Vec<BTreeMap<String, [f64; 2]>>,
}

/// Result of trying a candidate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Tried {
    accepted: Option<Candidate>,
    /// Condition and outcome that failed.
    failed: Option<(usize, Cow<'static, str>)>,
    /// Outcome and predictions under each condition that was computed.
    shots: Vec<(usize, Cow<'static, str>, Vec<Prediction>)>,
}

impl Start {
    /// Draws candidates until `want` are accepted, and calls `after` after every block of at most `block` candidates.
    /// `try_block` returns the results of [`tried`]. The size of the blocks does not affect the result.
    ///
    /// # Errors
    /// Those of `try_block`; or if none of the first candidates is accepted, or too few overall.
    pub(super) fn complete(
        &mut self,
        tool: &Tool,
        likelihood: &Likelihood,
        (want, block): (usize, u64),
        try_block: impl Fn(Range<u64>) -> Result<Vec<Option<Tried>>, CalibrationError>,
        after: impl Fn(&Self),
    ) -> Result<(), CalibrationError> {
        self.reached.resize(likelihood.data().len(), BTreeMap::new());
        while self.accepted.len() < want {
            if self.accepted.is_empty() && self.drawn >= MOST_IN_VAIN {
                return Err(CalibrationError::NothingAccepted {
                    candidates: self.drawn,
                    outcomes: counted(&self.refused),
                });
            }
            let most = MOST * want as u64;
            if self.drawn >= most {
                return Err(CalibrationError::TooFewAccepted {
                    accepted: self.accepted.len(),
                    candidates: self.drawn,
                    wanted: want,
                });
            }
            let limit = if self.accepted.is_empty() {
                MOST_IN_VAIN.min(most)
            } else {
                most
            };
            for tried in try_block(self.drawn..limit.min(self.drawn + block))? {
                if self.accepted.len() == want {
                    break;
                }
                self.drawn += 1;
                match tried {
                    Some(tried) => self.add(tool, likelihood, tried),
                    None => *self.refused.entry("refused".to_owned()).or_default() += 1,
                }
            }
            after(self);
        }
        Ok(())
    }

    fn add(&mut self, tool: &Tool, likelihood: &Likelihood, tried: Tried) {
        for (condition, outcome, predictions) in tried.shots {
            for (k, prediction) in likelihood.of_condition(condition).zip(predictions) {
                if let Prediction::Value(value) = prediction {
                    let ends = self.reached[k]
                        .entry(outcome.clone().into_owned())
                        .or_insert([value; 2]);
                    *ends = [ends[0].min(value), ends[1].max(value)];
                }
            }
        }
        if let Some((condition, outcome)) = tried.failed {
            let name = format!(
                "{} under \"{}\"",
                outcome.replace('_', " "),
                tool.conditions[condition].name
            );
            *self.refused.entry(name).or_default() += 1;
        }
        self.accepted.extend(tried.accepted);
    }
}

/// Tries the candidates with these indices, in parallel; none for an index whose point breaks a rule.
pub(super) fn tried(tool: &Tool, likelihood: &Likelihood, seed: u64, indices: Range<u64>) -> Vec<Option<Tried>> {
    let bases: Vec<Values> = tool.conditions.iter().map(|own| Values::clone(&own.design)).collect();
    let active = vec![true; tool.keys()];
    let frame = Frame::new(&bases, &active, 0);
    let one = |index: u64| {
        let point = tool.sampler.point(frame, index, &mut Rejections::new()).ok()?;
        let mut z = tool.sampler.to_normal(&point);
        let shared = 0..tool.shared.len() as u64;
        z.extend(shared.map(|k| standard_normal(seed ^ SHARED, index, k)));
        Some(try_point(tool, likelihood, z))
    };
    indices.into_par_iter().map(one).collect()
}

fn try_point(tool: &Tool, likelihood: &Likelihood, z: Vec<f64>) -> Tried {
    let data = likelihood.data();
    let mut predictions = vec![Prediction::Missing; data.len()];
    let mut tried = Tried {
        accepted: None,
        failed: None,
        shots: Vec::new(),
    };
    for &condition in likelihood.order() {
        let observed = match tool.observe(&z, condition) {
            Ok(observed) => observed,
            Err(name) => {
                tried.failed = Some((condition, name.into()));
                return tried;
            }
        };
        let own: Vec<usize> = likelihood.of_condition(condition).collect();
        own.iter()
            .zip(&observed.predictions)
            .for_each(|(&k, own)| predictions[k] = *own);
        let allowed = &tool.conditions[condition].outcomes;
        let is_allowed = allowed.is_empty() || allowed.iter().any(|own| *own == observed.outcome);
        let is_missing = own
            .iter()
            .any(|&k| data[k].counts && predictions[k] == Prediction::Missing);
        let outcome = observed.outcome;
        tried.shots.push((condition, outcome.clone(), observed.predictions));
        if !is_allowed || is_missing {
            let name = if is_allowed { "no such event".into() } else { outcome };
            tried.failed = Some((condition, name));
            return tried;
        }
    }
    tried.accepted = Some(Candidate { z, predictions });
    tried
}

/// Describes counts, the largest first.
fn counted(counts: &BTreeMap<String, u64>) -> String {
    let mut counts: Vec<(&String, &u64)> = counts.iter().collect();
    counts.sort_by(|a, b| b.1.cmp(a.1));
    let words = counts.iter().map(|(name, count)| format!("{name} ({count})"));
    words.collect::<Vec<_>>().join(", ")
}
