//! Steps of a run: each raises the temperature, resamples, and moves the particles.

use std::collections::{BTreeMap, VecDeque};
use std::convert::Infallible;

use nalgebra::DMatrix;

use super::moves::{Proposal, Simulated};
use super::state::{Candidate, Particle, State, Step};
use super::target::Sampler;
use crate::Simulator;
use crate::random::Stream;
use crate::statistics::{effective_size, log_mean_exp, resampled};
use crate::subspace::{Regression, directions};

/// Initial step size of the moves.
const FIRST_SIZE: f64 = 0.6;

/// Smallest rise of tau.
const LEAST_RISE: f64 = 1e-9;

impl<S: Simulator> Sampler<'_, S> {
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
