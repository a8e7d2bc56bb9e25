//! Moves of the sampler: proposals, which can be simulated anywhere, and their acceptance.

use std::borrow::Cow;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::state::{Particle, State};
use super::target::Sampler;
use crate::Simulator;
use crate::likelihood::Prediction;
use crate::random::Stream;
use crate::statistics::{correlation, mean};
use crate::subspace::Reference;

/// Degrees of freedom of the proposal in the informed directions.
const DEGREES: f64 = 5.0;

/// Range of the step size of the moves.
const SIZES: [f64; 2] = [0.02, 0.98];

/// Target acceptance rate of the moves.
const ACCEPTANCE: f64 = 0.3;

/// Fewest moves per step, and the correlation with the starting points below which moving stops.
const FEWEST_MOVES: usize = 3;
const FORGOTTEN: f64 = 0.15;

/// Number of populations in the archive from which directions are computed.
const ARCHIVED: usize = 6;

/// A point proposed by a move.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Proposal {
    z: Vec<f64>,
    /// Least log-likelihood with which it is accepted.
    threshold: f64,
    ancestor: usize,
}

/// The result of simulating a proposal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Simulated {
    /// The new particle, if the proposal was accepted.
    accepted: Option<Particle>,
    /// The point with its predictions, if all conditions were simulated.
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

impl<S: Simulator> Sampler<'_, S> {
    /// The proposals of the next move, one for each particle.
    pub(super) fn proposals(&self, state: &State) -> Vec<Proposal> {
        let step = state.steps.len() - 1;
        let directions = columns(&state.directions, self.simulator.variables());
        let frames = [0, 1].map(|half| {
            let others = state.particles.iter().skip(1 - half).step_by(2);
            let other = informed(&directions, others.map(|own| &own.z));
            Frame {
                reference: (!other.is_empty()).then(|| Reference::of(&other)).flatten(),
                directions: directions.clone(),
                temperature: state.temperature,
                size: state.size,
                step: step as u64,
                number: state.steps[step].moves as u64,
            }
        });
        let particles = state.particles.par_iter().enumerate();
        particles
            .map(|(place, particle)| self.propose(&frames[place % 2], place as u64, particle))
            .collect()
    }

    /// Replaces the particles whose proposals were accepted, and completes the move.
    pub(super) fn accept(&self, state: &mut State, moved: Vec<Simulated>) {
        let step = state.steps.len() - 1;
        let (n, d) = (state.particles.len(), self.simulator.variables());
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
        let directions = columns(&state.directions, d);
        let before = informed(&directions, state.places.iter());
        let after = informed(&directions, now.iter().copied());
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

    fn propose(&self, frame: &Frame, place: u64, particle: &Particle) -> Proposal {
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
        Proposal {
            threshold: particle.log_likelihood + (stream(3).uniform(0).ln() - log_ratio) / frame.temperature,
            ancestor: particle.ancestor,
            z: proposed,
        }
    }

    /// Simulates proposals, in parallel. A worker can do this with a sampler of the same simulator and likelihood.
    pub fn simulate(&self, proposals: Vec<Proposal>) -> Vec<Simulated> {
        proposals.into_par_iter().map(|own| self.simulated(own)).collect()
    }

    /// Simulates a proposal condition by condition and stops as soon as it can no longer be accepted.
    fn simulated(&self, Proposal { z, threshold, ancestor }: Proposal) -> Simulated {
        let mut predictions = vec![Prediction::Missing; self.likelihood.data().len()];
        let mut log_likelihood = 0.0;
        let mut moved = Simulated {
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
            if log_likelihood.is_nan() || log_likelihood < threshold {
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
}

/// A matrix of `rows` rows from its columns.
fn columns(columns: &[Vec<f64>], rows: usize) -> DMatrix<f64> {
    DMatrix::from_fn(rows, columns.len(), |row, column| columns[column][row])
}

/// Coordinates of points in the informed directions, a column for each point.
fn informed<'z>(directions: &DMatrix<f64>, points: impl Iterator<Item = &'z Vec<f64>>) -> DMatrix<f64> {
    let points: Vec<DVector<f64>> = points
        .map(|z| directions.tr_mul(&DVector::from_column_slice(z)))
        .collect();
    DMatrix::from_fn(directions.ncols(), points.len(), |row, column| points[column][row])
}
