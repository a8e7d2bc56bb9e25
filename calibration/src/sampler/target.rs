//! The target of the sampler: the inputs of a simulator, given a likelihood of its predictions.

use super::state::Settings;
use crate::Simulator;
use crate::likelihood::{Likelihood, Prediction};

/// Samples the posterior of a simulator's inputs.
pub struct Sampler<'a, S> {
    pub(super) simulator: &'a S,
    pub(super) likelihood: &'a Likelihood,
    pub(super) settings: Settings,
    pub(super) ruled: Vec<bool>,
    pub(super) counting: Vec<usize>,
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

    /// A point with its predictions in the order of the conditioning readings.
    pub(super) fn row(&self, z: &[f64], predictions: &[Prediction]) -> (Vec<f64>, Vec<f64>) {
        let total = |&k: &usize| predictions[k].value() + self.likelihood.shared(k, z);
        (z.to_vec(), self.counting.iter().map(total).collect())
    }
}
