//! Whether a finished run of the sampler is reliable.

use serde::{Deserialize, Serialize};

use super::state::State;
use super::target::Sampler;
use crate::Simulator;
use crate::statistics::{log_mean_exp, mean, moments};

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

impl<S: Simulator> Sampler<'_, S> {
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
