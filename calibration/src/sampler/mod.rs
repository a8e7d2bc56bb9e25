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

mod diagnostics;
mod moves;

use std::collections::{BTreeMap, VecDeque};
use std::convert::Infallible;

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

pub use diagnostics::{Diagnostics, NotConverged};
pub use moves::{Proposal, Simulated};

use crate::Simulator;
use crate::likelihood::{Likelihood, Prediction};
use crate::random::Stream;
use crate::statistics::{effective_size, log_mean_exp, resampled};
use crate::subspace::{Regression, directions};

/// Initial step size of the moves.
const FIRST_SIZE: f64 = 0.6;

/// Smallest rise of tau.
const LEAST_RISE: f64 = 1e-9;

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

/// Samples the posterior of a simulator's inputs.
pub struct Sampler<'a, S> {
    simulator: &'a S,
    likelihood: &'a Likelihood,
    settings: Settings,
    ruled: Vec<bool>,
    counting: Vec<usize>,
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
    pub fn run(&self, state: &mut State, after: impl FnMut(&State)) {
        let here = |proposals| Ok::<_, Infallible>(self.simulate(proposals));
        match self.run_with(state, here, after) {
            Ok(()) => (),
            Err(never) => match never {},
        }
    }

    /// [`Sampler::run`] with proposals simulated elsewhere: `simulate` returns the results of [`Sampler::simulate`] in
    /// the order of the proposals.
    ///
    /// # Errors
    /// Those of `simulate`. The run can be continued from the state.
    pub fn run_with<E>(
        &self,
        state: &mut State,
        simulate: impl Fn(Vec<Proposal>) -> Result<Vec<Simulated>, E>,
        mut after: impl FnMut(&State),
    ) -> Result<(), E> {
        while !state.is_finished() {
            // The first move of a step follows the raising of tau.
            if state.is_settled {
                self.begin_step(state);
            }
            let moved = simulate(self.proposals(state))?;
            self.accept(state, moved);
            after(state);
        }
        Ok(())
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
