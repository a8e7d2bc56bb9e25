//! Settings of a run, and its state between two moves.

use std::collections::{BTreeMap, VecDeque};

use serde::{Deserialize, Serialize};

use crate::likelihood::Prediction;

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
pub(super) type Population = Vec<(Vec<f64>, Vec<f64>)>;

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
    /// [`constant`](crate::likelihood::Likelihood::constant).
    pub log_evidence: [f64; 2],
    /// Whether the moves of the current step are complete.
    pub(super) is_settled: bool,
    pub(super) size: f64,
    /// Points before the moves of the current step.
    pub(super) places: Vec<Vec<f64>>,
    /// V, by columns.
    pub(super) directions: Vec<Vec<f64>>,
    pub(super) archive: VecDeque<Population>,
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
