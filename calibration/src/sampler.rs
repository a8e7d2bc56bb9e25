//! Samples the posterior of the inputs by sequential Monte Carlo with tempering (Del Moral, Doucet and Jasra,
//! "Sequential Monte Carlo samplers", Journal of the Royal Statistical Society B 68, 411 (2006)).
//!
//! N particles start as draws from the prior and pass through the densities p(z) exp(tau l(z)) while tau increases from
//! 0 to 1. Each step raises tau until the effective sample size is N/2, resamples, and moves the particles until they
//! have decorrelated. In the r directions V informed by the readings, with y = V^T z, a move proposes
//!
//! ```text
//! e  = L^-1 (y - m),   g = 2 Gamma((r+5)/2, 1)/(5 + |e|^2)
//! e' = sqrt(1-b^2) e + b xi/sqrt(g),   y' = m + L e'
//! w' = sqrt(1-b^2) (z - V y) + b (I - V V^T) xi,   z' = V y' + w'
//! ```
//!
//! The first is reversible for a Student t distribution with 5 degrees of freedom, mean m and scale matrix L L^T, the
//! second for the prior (Cotter, Roberts, Stuart and White, "MCMC methods for functions", Statistical Science 28, 424
//! (2013)). m and L are computed from the other half of the particles, so that no particle influences its own proposal.
//! Without this split, the evidence is biased low and directions without data become too narrow.
//!
//! All random numbers are functions of seed, step, move and particle, so results depend neither on threads nor on
//! interruptions between moves.

use std::borrow::Cow;
use std::collections::{BTreeMap, VecDeque};

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::Simulator;
use crate::likelihood::{Likelihood, Prediction};
use crate::random::Stream;
use crate::statistics::{correlation, effective_size, log_mean_exp, moments, resampled};
use crate::subspace::{Reference, Regression, directions};

/// Degrees of freedom of the proposal in the informed directions.
const DEGREES: f64 = 5.0;

/// Initial step size of the moves, and its range.
const FIRST_SIZE: f64 = 0.6;
const SIZES: [f64; 2] = [0.02, 0.98];

/// Target acceptance rate of the moves.
const ACCEPTANCE: f64 = 0.3;

/// Fewest moves per step, and the correlation with the starting points below which moving stops.
const FEWEST_MOVES: usize = 3;
const FORGOTTEN: f64 = 0.15;

/// Number of populations in the archive from which directions are computed.
const ARCHIVED: usize = 6;

/// Smallest rise of tau.
const LEAST_RISE: f64 = 1e-9;

/// Convergence criteria: largest difference between the halves' log evidence, largest difference between their means in
/// standard errors, largest correlation with the points before the moves of the last step, and smallest step size.
const HALVES_APART: f64 = 1.5;
const MEANS_APART: f64 = 4.0;
const NOT_FORGOTTEN: f64 = 0.985;
const SMALLEST_SIZE: f64 = 0.05;

/// Maximum number of particles per initial ancestor in a converged run, and its minimum number of ancestors. The width
/// of a 90 % interval of n independent normal draws has the relative standard error 0.9/sqrt(n), 16 % for 32.
const PARTICLES_PER_ANCESTOR: usize = 8;
const FEWEST_ANCESTORS: usize = 32;

/// Settings of a sampler.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Settings {
    /// Most moves per step.
    pub moves: usize,
    /// Seed of all random numbers.
    pub seed: u64,
}

/// A draw from the prior that yields the observed outcomes, with its predictions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// The point.
    pub z: Vec<f64>,
    /// A prediction for each reading.
    pub predictions: Vec<Prediction>,
}

/// A particle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Particle {
    /// The point.
    pub z: Vec<f64>,
    /// A prediction for each reading.
    pub predictions: Vec<Prediction>,
    /// l, log-likelihood of the conditioning readings.
    pub log_likelihood: f64,
    /// Index of the candidate from which it descends.
    pub ancestor: usize,
}

/// A step of the sampler.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// tau after raising.
    pub temperature: f64,
    /// Moves made so far.
    pub moves: usize,
    /// Acceptance rate of the last move.
    pub acceptance: f64,
    /// b, step size of the next move.
    pub size: f64,
    /// r, number of informed directions.
    pub directions: usize,
    /// Number of initial candidates that have descendants.
    pub ancestors: usize,
    /// Mean correlation with the points before the moves: over the informed directions and over all variables.
    pub correlations: [f64; 2],
}

/// Points with their predictions, in the order of the conditioning readings.
type Population = Vec<(Vec<f64>, Vec<f64>)>;

/// The state of a run between two moves; it can be stored and resumed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// The particles.
    pub particles: Vec<Particle>,
    /// tau.
    pub temperature: f64,
    /// All steps so far.
    pub steps: Vec<Step>,
    /// Number of points for which at least one condition was simulated.
    pub likelihoods: u64,
    /// Number of condition simulations.
    pub simulations: u64,
    /// Counts, by outcome, of proposals at tau = 1 that were rejected because of their outcome.
    pub refusals: BTreeMap<String, u64>,
    /// Log evidence from each half, relative to candidates with the observed outcomes and without
    /// [`Likelihood::constant`].
    pub log_evidence: [f64; 2],
    /// Whether the moves of the current step are complete.
    is_settled: bool,
    size: f64,
    /// Points before the moves of the current step.
    places: Vec<Vec<f64>>,
    /// V, by columns.
    directions: Vec<Vec<f64>>,
    archive: VecDeque<Population>,
}

impl State {
    /// Whether the particles are draws from the posterior.
    pub fn is_finished(&self) -> bool {
        self.temperature >= 1.0 && self.is_settled
    }

    /// Number of initial candidates that have descendants.
    pub fn ancestors(&self) -> usize {
        let mut ancestors: Vec<usize> = self.particles.iter().map(|own| own.ancestor).collect();
        ancestors.sort_unstable();
        ancestors.dedup();
        ancestors.len()
    }
}

/// Why a run has not converged.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, thiserror::Error)]
pub enum NotConverged {
    /// The halves disagree on the evidence, by this much.
    #[error("the two halves of the draws differ by {0:.2} in log evidence (limit 1.5)")]
    Evidence(f64),
    /// The halves disagree on a prediction.
    #[error("the two halves of the draws predict `{name}` {errors:.1} standard errors apart (limit 4)")]
    Mean {
        /// The reading.
        name: String,
        /// Difference in standard errors.
        errors: f64,
    },
    /// Too few initial candidates have descendants.
    #[error("the draws descend from {ancestors} candidates (at least {least})")]
    Ancestors {
        /// Their number.
        ancestors: usize,
        /// The limit.
        least: usize,
    },
    /// The step size of the last moves was too small.
    #[error("the last moves were {0:.3} of the prior's width (at least 0.05)")]
    Size(f64),
    /// The last moves left the particles correlated with their starting points.
    #[error("after the last moves the draws correlate by {0:.3} with their places before (limit 0.985)")]
    Correlation(f64),
}

/// Reliability of a finished run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Diagnostics {
    /// Log evidence of the readings, among candidates with the observed outcomes.
    pub log_evidence: f64,
    /// Difference between the halves' log evidence.
    pub halves_apart: f64,
    /// Number of initial candidates that have descendants.
    pub ancestors: usize,
    /// Reasons why the run has not converged; empty if it has.
    pub faults: Vec<NotConverged>,
}

/// Samples the posterior of a simulator's inputs.
pub struct Sampler<'a, S> {
    simulator: &'a S,
    likelihood: &'a Likelihood,
    settings: Settings,
    ruled: Vec<bool>,
    counting: Vec<usize>,
}

/// A proposal and its fate.
struct Moved {
    /// The new particle, if the proposal was accepted.
    accepted: Option<Particle>,
    /// Predictions of a proposal, if it was simulated completely.
    complete: Option<(Vec<f64>, Vec<f64>)>,
    simulations: u64,
    refusal: Option<Cow<'static, str>>,
}

/// Data shared by all proposals of a move for the particles of one half.
struct Frame {
    directions: DMatrix<f64>,
    reference: Option<Reference>,
    temperature: f64,
    size: f64,
    step: u64,
    number: u64,
}

impl<'a, S: Simulator> Sampler<'a, S> {
    /// A sampler of the posterior of a likelihood.
    pub fn new(simulator: &'a S, likelihood: &'a Likelihood, settings: Settings) -> Self {
        let data = likelihood.data();
        Self {
            simulator,
            likelihood,
            settings,
            ruled: simulator.is_ruled(),
            counting: (0..data.len()).filter(|&k| data[k].counts).collect(),
        }
    }

    /// The state before the first step. Candidates with zero likelihood are discarded.
    pub fn begin(&self, candidates: Vec<Candidate>) -> State {
        let particle = |(ancestor, Candidate { z, predictions }): (usize, Candidate)| {
            let log_likelihood = self.likelihood.total(&z, &predictions);
            let particle = Particle {
                z,
                predictions,
                log_likelihood,
                ancestor,
            };
            log_likelihood.is_finite().then_some(particle)
        };
        let particles: Vec<Particle> = candidates.into_iter().enumerate().filter_map(particle).collect();
        let is_informed = self.likelihood.is_informed() && !particles.is_empty();
        let first = particles.iter().map(|own| self.row(&own.z, &own.predictions)).collect();
        State {
            temperature: if is_informed { 0.0 } else { 1.0 },
            steps: Vec::new(),
            likelihoods: 0,
            simulations: 0,
            refusals: BTreeMap::new(),
            log_evidence: [0.0; 2],
            is_settled: true,
            size: FIRST_SIZE,
            places: Vec::new(),
            directions: Vec::new(),
            archive: VecDeque::from([first]),
            particles,
        }
    }

    /// Runs to completion and calls `after` after every move.
    pub fn run(&self, state: &mut State, mut after: impl FnMut(&State)) {
        while !state.is_finished() {
            self.advance(state);
            after(state);
        }
    }

    /// Makes one move; the first of a step follows the raising of tau.
    pub fn advance(&self, state: &mut State) {
        if state.is_finished() {
            return;
        }
        if state.is_settled {
            self.begin_step(state);
        }
        self.move_all(state);
    }

    /// A point with its predictions in the order of the conditioning readings.
    fn row(&self, z: &[f64], predictions: &[Prediction]) -> (Vec<f64>, Vec<f64>) {
        let total = |&k: &usize| predictions[k].value() + self.likelihood.shared(k, z);
        (z.to_vec(), self.counting.iter().map(total).collect())
    }

    fn begin_step(&self, state: &mut State) {
        let n = state.particles.len();
        let log: Vec<f64> = state.particles.iter().map(|own| own.log_likelihood).collect();
        let rise = rise(&log, state.temperature);
        let parts: Vec<f64> = log.iter().map(|l| rise * l).collect();
        for half in 0..2 {
            let own: Vec<f64> = parts.iter().skip(half).step_by(2).copied().collect();
            state.log_evidence[half] += log_mean_exp(&own);
        }
        let step = state.steps.len() as u64;
        let stream = Stream::new(self.settings.seed, &[step, u64::MAX]);
        let mut chosen: Vec<usize> = (0..n).collect();
        for half in 0..2 {
            let members: Vec<usize> = (half..n).step_by(2).collect();
            let weights: Vec<f64> = members.iter().map(|&k| parts[k]).collect();
            let most = weights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let weights: Vec<f64> = weights.iter().map(|w| (w - most).exp()).collect();
            let places = resampled(&weights, weights.len(), stream.uniform(half as u64));
            members
                .iter()
                .zip(places)
                .for_each(|(&to, from)| chosen[to] = members[from]);
        }
        state.particles = chosen.iter().map(|&k| state.particles[k].clone()).collect();
        state.temperature = if state.temperature + rise >= 1.0 {
            1.0
        } else {
            state.temperature + rise
        };
        state.places = state.particles.iter().map(|own| own.z.clone()).collect();
        let present = state.particles.iter().map(|own| self.row(&own.z, &own.predictions));
        let rows: Vec<_> = state.archive.iter().flatten().cloned().chain(present).collect();
        let d = self.simulator.variables();
        let scale = |k: usize| self.likelihood.data()[self.counting[k]].scale;
        let regression = Regression {
            points: DMatrix::from_fn(rows.len(), d, |row, column| rows[row].0[column]),
            predictions: DMatrix::from_fn(rows.len(), self.counting.len(), |row, k| rows[row].1[k] / scale(k)),
        };
        let found = directions(regression, &self.ruled);
        state.directions = found.column_iter().map(|own| own.iter().copied().collect()).collect();
        state.steps.push(Step {
            temperature: state.temperature,
            moves: 0,
            acceptance: 0.0,
            size: state.size,
            directions: state.directions.len(),
            ancestors: state.ancestors(),
            correlations: [1.0; 2],
        });
        state.is_settled = false;
    }

    fn move_all(&self, state: &mut State) {
        let step = state.steps.len() - 1;
        let (n, d) = (state.particles.len(), self.simulator.variables());
        let directions = DMatrix::from_fn(d, state.directions.len(), |row, column| state.directions[column][row]);
        let informed = |points: &mut dyn Iterator<Item = &Vec<f64>>| -> DMatrix<f64> {
            let columns: Vec<DVector<f64>> = points
                .map(|z| directions.tr_mul(&DVector::from_column_slice(z)))
                .collect();
            DMatrix::from_fn(directions.ncols(), columns.len(), |row, column| columns[column][row])
        };
        let frames = [0, 1].map(|half| {
            let other = informed(&mut state.particles.iter().skip(1 - half).step_by(2).map(|own| &own.z));
            Frame {
                reference: (!other.is_empty()).then(|| Reference::of(&other)).flatten(),
                directions: directions.clone(),
                temperature: state.temperature,
                size: state.size,
                step: step as u64,
                number: state.steps[step].moves as u64,
            }
        });
        let moved: Vec<Moved> = state
            .particles
            .par_iter()
            .enumerate()
            .map(|(place, particle)| self.propose(&frames[place % 2], place as u64, particle))
            .collect();
        let mut accepted = 0;
        let mut complete = Vec::new();
        for (particle, own) in state.particles.iter_mut().zip(moved) {
            state.likelihoods += u64::from(own.simulations > 0);
            state.simulations += own.simulations;
            complete.extend(own.complete);
            if let (Some(name), true) = (&own.refusal, state.temperature >= 1.0) {
                *state.refusals.entry(name.clone().into_owned()).or_default() += 1;
            }
            if let Some(new) = own.accepted {
                accepted += 1;
                *particle = new;
            }
        }
        state.archive.push_back(complete);
        while state.archive.len() > ARCHIVED {
            state.archive.pop_front();
        }
        let acceptance = f64::from(accepted) / n as f64;
        state.size = (state.size * (acceptance - ACCEPTANCE).exp()).clamp(SIZES[0], SIZES[1]);
        let now: Vec<&Vec<f64>> = state.particles.iter().map(|own| &own.z).collect();
        let all = (0..d).map(|k| {
            let [before, after]: [Vec<f64>; 2] = [
                state.places.iter().map(|z| z[k]).collect(),
                now.iter().map(|z| z[k]).collect(),
            ];
            correlation(&before, &after)
        });
        let [before, after] = [informed(&mut state.places.iter()), informed(&mut now.iter().copied())];
        let rows = before.row_iter().zip(after.row_iter());
        let within = rows.map(|(x, y)| {
            let [x, y]: [Vec<f64>; 2] = [x, y].map(|row| row.iter().copied().collect());
            correlation(&x, &y)
        });
        let correlations = [mean(within), mean(all)];
        let own = &mut state.steps[step];
        own.moves += 1;
        (own.acceptance, own.size, own.correlations) = (acceptance, state.size, correlations);
        let is_forgotten = own.moves >= FEWEST_MOVES && correlations.iter().all(|own| *own < FORGOTTEN);
        state.is_settled = is_forgotten || own.moves >= self.settings.moves;
    }

    fn propose(&self, frame: &Frame, place: u64, particle: &Particle) -> Moved {
        let stream = |kind: u64| Stream::new(self.settings.seed, &[frame.step, frame.number, place, kind]);
        let (d, r) = frame.directions.shape();
        let (b, kept) = (frame.size, (1.0 - frame.size * frame.size).sqrt());
        let z = DVector::from_column_slice(&particle.z);
        let y = frame.directions.tr_mul(&z);
        let within = &frame.directions * &y;
        let mut log_ratio = 0.0;
        let mut moved_within = within.clone();
        if let Some(reference) = &frame.reference {
            let e = reference.standardised(&y);
            let shape = 0.5 * (r as f64 + DEGREES);
            let g = 2.0 * stream(0).gamma(shape, 0) / (DEGREES + e.norm_squared());
            let xi = DVector::from_fn(r, |k, _| stream(1).normal(k as u64));
            let e1 = &e * kept + xi * (b / g.sqrt());
            let y1 = reference.point(&e1);
            let student = |e: &DVector<f64>| shape * (e.norm_squared() / DEGREES).ln_1p();
            log_ratio = student(&e1) - student(&e) - 0.5 * (y1.norm_squared() - y.norm_squared());
            moved_within = &frame.directions * y1;
        }
        let xi = DVector::from_fn(d, |k, _| stream(2).normal(k as u64));
        let xi = &xi - &frame.directions * frame.directions.tr_mul(&xi);
        let proposed = moved_within + (&z - within) * kept + xi * b;
        let mut proposed: Vec<f64> = proposed.iter().copied().collect();
        self.simulator.restore(&mut proposed, &particle.z);
        let need = particle.log_likelihood + (stream(3).uniform(0).ln() - log_ratio) / frame.temperature;
        self.judge(proposed, need, particle.ancestor)
    }

    /// Simulates a proposal condition by condition and stops as soon as it can no longer be accepted.
    fn judge(&self, z: Vec<f64>, need: f64, ancestor: usize) -> Moved {
        let mut predictions = vec![Prediction::Missing; self.likelihood.data().len()];
        let mut log_likelihood = 0.0;
        let mut moved = Moved {
            accepted: None,
            complete: None,
            simulations: 0,
            refusal: None,
        };
        let order = self.likelihood.order();
        for (known, &condition) in (1..).zip(order) {
            moved.simulations += 1;
            match self.simulator.predict(&z, condition) {
                Ok(values) => {
                    let own = self.likelihood.of_condition(condition);
                    own.zip(values).for_each(|(k, value)| predictions[k] = value);
                }
                Err(name) => {
                    moved.refusal = Some(name);
                    return moved;
                }
            }
            log_likelihood += self.likelihood.of_step(known, &z, &predictions);
            let is_last = known == order.len();
            if is_last && log_likelihood.is_finite() {
                moved.complete = Some(self.row(&z, &predictions));
            }
            if log_likelihood.is_nan() || log_likelihood < need {
                return moved;
            }
        }
        moved.accepted = Some(Particle {
            z,
            predictions,
            log_likelihood,
            ancestor,
        });
        moved
    }

    /// Assesses the reliability of a finished run.
    pub fn diagnostics(&self, state: &State) -> Diagnostics {
        let halves_apart = (state.log_evidence[0] - state.log_evidence[1]).abs();
        let ancestors = state.ancestors();
        let mut faults = Vec::new();
        if halves_apart >= HALVES_APART {
            faults.push(NotConverged::Evidence(halves_apart));
        }
        for (k, datum) in self.likelihood.data().iter().enumerate() {
            let values = state.particles.iter().map(|own| own.predictions[k].value());
            let values: Vec<f64> = values.collect();
            let [_, deviation] = moments(&values);
            let [a, b] = [0, 1].map(|half| mean(values.iter().copied().skip(half).step_by(2)));
            let errors = (a - b).abs() / (deviation * (4.0 / ancestors as f64).sqrt());
            if errors >= MEANS_APART {
                let name = datum.name.clone();
                faults.push(NotConverged::Mean { name, errors });
            }
        }
        let least = (state.particles.len() / PARTICLES_PER_ANCESTOR).max(FEWEST_ANCESTORS);
        if ancestors < least {
            faults.push(NotConverged::Ancestors { ancestors, least });
        }
        if let Some(last) = state.steps.last() {
            if last.size < SMALLEST_SIZE {
                faults.push(NotConverged::Size(last.size));
            }
            let most = last.correlations[0].max(last.correlations[1]);
            if most >= NOT_FORGOTTEN {
                faults.push(NotConverged::Correlation(most));
            }
        }
        Diagnostics {
            log_evidence: log_mean_exp(&state.log_evidence),
            halves_apart,
            ancestors,
            faults,
        }
    }
}

/// The value of tau that leaves half of the particles effective, or 1 if more than half remain.
fn rise(log: &[f64], temperature: f64) -> f64 {
    let enough = 0.5 * log.len() as f64;
    let most = log.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let effective = |rise: f64| {
        let weights: Vec<f64> = log.iter().map(|l| (rise * (l - most)).exp()).collect();
        effective_size(&weights)
    };
    let rest = 1.0 - temperature;
    if effective(rest) >= enough {
        return rest;
    }
    let (mut low, mut high) = (0.0, rest);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if effective(middle) >= enough {
            low = middle;
        } else {
            high = middle;
        }
    }
    low.max(LEAST_RISE).min(rest)
}

fn mean(numbers: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for number in numbers {
        sum += number;
        count += 1.0;
    }
    if count > 0.0 { sum / count } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_temperature_rises_to_half_of_the_particles() {
        let log: Vec<f64> = (0..100).map(|k| -f64::from(k)).collect();
        let rise = rise(&log, 0.0);
        let weights: Vec<f64> = log.iter().map(|l| (rise * l).exp()).collect();
        assert!((effective_size(&weights) - 50.0).abs() < 1e-6);
        assert_eq!(super::rise(&[-0.1, -0.2], 0.25), 0.75);
    }
}
