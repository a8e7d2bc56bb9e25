//! The posterior of a tool's inputs, and the treatment of readings that contradict each other.
//!
//! A conflict never makes a posterior narrower. Readings that no candidate approaches are excluded first. Then the
//! sampler runs. As long as the predictive probability of a reading given the others is below 1 %, it is excluded,
//! together with its partner if the two contradict only each other, and the sampler runs again. With widening, the
//! errors of these readings are finally multiplied by the factor at which they agree.

use std::collections::BTreeMap;
use std::ops::Range;

use nailnoise_acoustics::random::uniform;
use nailnoise_calibration::conflict::{self, Conflict, Pressed, Unreached};
use nailnoise_calibration::likelihood::Likelihood;
use nailnoise_calibration::sampler::{Diagnostics, Proposal, Sampler, Settings, State};
use nailnoise_calibration::statistics::log_mean_exp;

use super::error::CalibrationError;
use super::measurements::Measurements;
use super::request::{Request, Treatment};
use super::start::{Start, Tried, tried};
use super::tasks::{POINTS_PER_TASK, Points, Workers, distributed};
use super::tool::{Tool, likelihood};
use crate::error::Error;
use crate::stages::{Digest, Postcard, Progress};
use crate::store::{Key, Store};

/// Names of its store entries.
const START: &str = "candidates of a calibration";
const STATE: &str = "draws of a calibration";

/// Number of blocks of candidates between two store entries.
const BLOCKS: u64 = 16;

/// Largest number of readings excluded because of conflicts.
const MOST_CONFLICTS: usize = 8;

/// Fewest candidates whose ends are counted for a reading that is not reached: chance brings more than a quarter of 40
/// to the last twentieth of a range once in 300 000 times.
const NEAREST: usize = 40;

/// A conflict that was found.
#[derive(Debug, Clone, Default)]
pub(super) struct Found {
    pub(super) datum: usize,
    pub(super) partner: Option<usize>,
    /// For a level, the reading of the cycle that it contradicts.
    pub(super) of_cycle: Option<usize>,
    /// Predictive probability of the reading, given the other readings; 0 if no candidate reaches it.
    pub(super) probability: f64,
    /// The nearest candidate, for a reading out of reach.
    pub(super) unreached: Option<Unreached>,
    /// Inputs and shared errors that the draws with both readings press against the ends of their ranges.
    pub(super) pressed: Vec<Pressed>,
    /// Proposals of the last step that were rejected because of their outcome.
    pub(super) refusals: BTreeMap<String, u64>,
    /// Increase in log evidence if the readings are excluded.
    pub(super) gain: Option<f64>,
    /// Factor by which the errors were widened.
    pub(super) factor: Option<f64>,
}

/// Draws from a posterior, and their origin.
pub(super) struct Posterior {
    pub(super) tool: Tool,
    pub(super) start: Start,
    pub(super) likelihood: Likelihood,
    pub(super) state: State,
    pub(super) diagnostics: Diagnostics,
    pub(super) conflicts: Vec<Found>,
    /// Indices of the readings held out by the user.
    pub(super) held_out: Vec<usize>,
    /// Work counters over all runs of the sampler.
    pub(super) work: Work,
}

/// Work counters of the sampler.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct Work {
    /// Runs of the sampler: one, plus one after each conflict.
    pub runs: u64,
    /// Number of points simulated.
    pub likelihoods: u64,
    /// Number of nailing cycles among these.
    pub cycles: u64,
}

/// A calibration in progress.
pub(super) struct Calibration<'a> {
    pub(super) tool: Tool,
    pub(super) measured: &'a Measurements,
    pub(super) request: &'a Request,
    pub(super) store: &'a Store,
    /// Key of everything except which readings are used.
    pub(super) key: Key,
    /// Other processes that compute the shots.
    pub(super) workers: Option<&'a dyn Workers>,
    pub(super) progress: &'a Progress,
}

/// A run of the sampler.
struct Ran {
    likelihood: Likelihood,
    state: State,
    diagnostics: Diagnostics,
}

impl Calibration<'_> {
    /// Draws from the posterior; the readings `held_out` are only predicted.
    ///
    /// # Errors
    /// If there are no candidates or the correlations are impossible.
    pub(super) fn posterior(self, held_out: Vec<usize>) -> Result<Posterior, Error> {
        let start = self.start(&held_out)?;
        let mut left_out = held_out.clone();
        let mut conflicts = self.unreached(&start, &held_out)?;
        left_out.extend(conflicts.iter().map(|own| own.datum));
        let mut work = Work::default();
        let mut ran = self.run(&start, &left_out, &BTreeMap::new(), &mut work)?;
        while let Some(found) = conflict::worst(&ran.likelihood, &ran.state.particles) {
            if conflicts.len() >= MOST_CONFLICTS {
                break;
            }
            let before = log_mean_exp(&ran.state.log_evidence);
            let mut named = named(&self.tool, found, &ran);
            left_out.push(found.datum);
            left_out.extend(found.partner);
            ran = self.run(&start, &left_out, &BTreeMap::new(), &mut work)?;
            named.gain = Some(log_mean_exp(&ran.state.log_evidence) - before);
            conflicts.push(named);
        }
        if self.request.treatment == Treatment::Widen && !conflicts.is_empty() {
            let mut factors = BTreeMap::new();
            for own in &mut conflicts {
                let factor = conflict::widening(&ran.likelihood, &ran.state.particles, own.datum, own.partner);
                own.factor = Some(factor);
                factors.extend(
                    [Some(own.datum), own.partner]
                        .into_iter()
                        .flatten()
                        .map(|k| (k, factor)),
                );
            }
            ran = self.run(&start, &held_out, &factors, &mut work)?;
        }
        shuffle(&mut ran.state.particles, self.request.seed);
        Ok(Posterior {
            tool: self.tool,
            start,
            likelihood: ran.likelihood,
            state: ran.state,
            diagnostics: ran.diagnostics,
            conflicts,
            held_out,
            work,
        })
    }

    fn start(&self, held_out: &[usize]) -> Result<Start, Error> {
        self.progress.stage("shots of candidates");
        let likelihood = likelihood(&self.tool, self.measured, held_out, &BTreeMap::new())?;
        let key = self.key.clone().with(held_out).with(START).digest();
        let mut start: Start = self.store.load::<Start, Postcard>(START, &key).unwrap_or_default();
        let blocks = std::cell::Cell::new(0_u64);
        let want = self.request.draws;
        let tasks = self.workers.map_or(1, Workers::count).max(1) as u64;
        start.complete(
            &self.tool,
            &likelihood,
            (want, tasks * POINTS_PER_TASK as u64),
            |indices| self.tried(&likelihood, held_out, indices),
            |start| {
                self.progress.done(start.accepted.len() as u64, want as u64);
                blocks.set(blocks.get() + tasks);
                if blocks.get() >= BLOCKS || start.accepted.len() == want {
                    blocks.set(0);
                    self.store.save::<_, Postcard>(START, &key, start);
                }
            },
        )?;
        Ok(start)
    }

    /// Candidates by their indices, tried here or by the workers.
    fn tried(
        &self,
        likelihood: &Likelihood,
        left_out: &[usize],
        indices: Range<u64>,
    ) -> Result<Vec<Option<Tried>>, CalibrationError> {
        let Some(workers) = self.workers else {
            return Ok(tried(&self.tool, likelihood, self.request.seed, indices));
        };
        let firsts = indices.clone().step_by(POINTS_PER_TASK);
        let tasks = firsts.map(|first| Points::Candidates {
            left_out: left_out.to_vec(),
            indices: first..indices.end.min(first + POINTS_PER_TASK as u64),
        });
        distributed(workers, &self.key.clone().digest(), tasks, indices.clone().count())
    }

    /// Readings out of reach of all candidates.
    fn unreached(&self, start: &Start, held_out: &[usize]) -> Result<Vec<Found>, Error> {
        let likelihood = likelihood(&self.tool, self.measured, held_out, &BTreeMap::new())?;
        let counting = (0..likelihood.data().len()).filter(|&k| likelihood.data()[k].counts);
        let found = counting.filter_map(|datum| {
            let unreached = conflict::unreached(&likelihood, datum, &start.accepted)?;
            Some(Found {
                datum,
                partner: None,
                probability: 0.0,
                pressed: nearest_ends(&self.tool, &likelihood, start, datum),
                unreached: Some(unreached),
                ..Found::default()
            })
        });
        Ok(found.collect())
    }

    fn run(
        &self,
        start: &Start,
        left_out: &[usize],
        factors: &BTreeMap<usize, f64>,
        work: &mut Work,
    ) -> Result<Ran, Error> {
        let likelihood = likelihood(&self.tool, self.measured, left_out, factors)?;
        let settings = Settings {
            moves: self.request.moves,
            seed: self.request.seed,
        };
        let key: Digest = self
            .key
            .clone()
            .with(left_out)
            .with(factors)
            .with(&settings)
            .with(STATE)
            .digest();
        let sampler = Sampler::new(&self.tool, &likelihood, settings);
        self.progress.stage("draws from the posterior");
        let mut state = match self.store.load::<State, Postcard>(STATE, &key) {
            Some(state) => state,
            None => sampler.begin(start.accepted.clone()),
        };
        let simulate = |proposals: Vec<Proposal>| {
            let Some(workers) = self.workers else {
                return Ok(sampler.simulate(proposals));
            };
            let tasks = proposals.chunks(POINTS_PER_TASK).map(|own| Points::Proposals {
                left_out: left_out.to_vec(),
                factors: factors.clone(),
                proposals: own.to_vec(),
            });
            distributed(workers, &self.key.clone().digest(), tasks, proposals.len())
        };
        let after = |state: &State| {
            self.store.save::<_, Postcard>(STATE, &key, state);
            // Steps of tau are roughly uniform in its logarithm, so the fraction completed is only known at the end.
            let last = state.steps.last().map_or(0, |step| step.moves);
            self.progress
                .done((last as u64).min(settings.moves as u64), settings.moves as u64);
        };
        sampler.run_with(&mut state, simulate, after)?;
        work.runs += 1;
        work.likelihoods += state.likelihoods;
        work.cycles += state.simulations;
        Ok(Ran {
            diagnostics: sampler.diagnostics(&state),
            likelihood,
            state,
        })
    }
}

/// Brings draws in random order: neighbours descend from the same candidates.
pub(super) fn shuffle<T>(particles: &mut Vec<T>, seed: u64) {
    /// Apart from the seeds of the sampler.
    const ORDER: u64 = 0x5EED_0BDE_12AD;
    let mut keyed: Vec<(f64, T)> = (0..)
        .zip(particles.drain(..))
        .map(|(place, own)| (uniform(seed ^ ORDER, place, 0), own))
        .collect();
    keyed.sort_by(|a, b| a.0.total_cmp(&b.0));
    particles.extend(keyed.into_iter().map(|(_, own)| own));
}

fn named(tool: &Tool, found: Conflict, ran: &Ran) -> Found {
    let weights = vec![1.0 / ran.state.particles.len() as f64; ran.state.particles.len()];
    let errors: Vec<usize> = (0..tool.shared.len()).map(|k| tool.keys() + k).collect();
    Found {
        datum: found.datum,
        partner: found.partner,
        probability: found.probability,
        pressed: conflict::at_ends(&ran.state.particles, &weights, &errors),
        refusals: ran.state.refusals.clone(),
        ..Found::default()
    }
}

/// Ends to which the candidates nearest to a reading are pressed: a twentieth of all, and enough that chance does not
/// bring a quarter of them to an end.
fn nearest_ends(tool: &Tool, likelihood: &Likelihood, start: &Start, datum: usize) -> Vec<Pressed> {
    let settings = Settings { moves: 0, seed: 0 };
    let mut particles = Sampler::new(tool, likelihood, settings)
        .begin(start.accepted.clone())
        .particles;
    let reading = likelihood.data()[datum].reading;
    let distance = |value: f64| (reading.nearest(value) - value).abs();
    particles.sort_by(|a, b| {
        let [a, b] = [a, b].map(|own| distance(own.predictions[datum].value()));
        a.total_cmp(&b)
    });
    particles.truncate((particles.len() / 20).max(NEAREST));
    let weights = vec![1.0 / particles.len() as f64; particles.len()];
    conflict::at_ends(&particles, &weights, &[])
}
