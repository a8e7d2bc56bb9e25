//! Draws of a plate's inputs given its peaks. Peaks that contradict the others are left out, as in any calibration.

use nailnoise_acoustics::random::uniform;
use nailnoise_calibration::conflict::{self, Conflict};
use nailnoise_calibration::likelihood::{ErrorLaw, Likelihood, LikelihoodError};
use nailnoise_calibration::sampler::{Candidate, Diagnostics, Sampler, Settings, State};
use nailnoise_calibration::{Simulator, normal};
use rayon::prelude::*;

use super::plate::Ritz;
use super::tap_test::{INPUTS, Simulation, TapTest};

/// Fewest peaks that remain when others are left out.
const FEWEST: usize = 3;

/// Apart from the seeds of the sampler.
const CANDIDATES: u64 = 0x5EED_7A97;

/// Draws from a posterior.
pub(super) struct Posterior {
    pub(super) likelihood: Likelihood,
    pub(super) candidates: Vec<Candidate>,
    pub(super) state: State,
    pub(super) diagnostics: Diagnostics,
    /// Readings that were left out, in their order.
    pub(super) conflicts: Vec<Conflict>,
    /// Whether each reading conditions the inputs.
    pub(super) counts: Vec<bool>,
}

/// Draws from the posterior of a plate.
///
/// # Errors
/// None in practice: the errors of peaks are independent.
pub(super) fn posterior(
    ritz: &Ritz,
    test: &TapTest,
    draws: usize,
    settings: Settings,
    mut after: impl FnMut(),
) -> Result<Posterior, LikelihoodError> {
    let mut counts: Vec<bool> = test.is_check.iter().map(|is_check| !is_check).collect();
    counts.push(true);
    let mut conflicts = Vec::new();
    loop {
        let simulation = Simulation {
            ritz,
            test,
            counts: counts.clone(),
        };
        let likelihood = Likelihood::new(test.data(&counts), 1, &[], ErrorLaw::Student)?;
        let candidates = candidates(&simulation, draws, settings.seed);
        let sampler = Sampler::new(&simulation, &likelihood, settings);
        let mut state = sampler.begin(candidates.clone());
        sampler.run(&mut state, |_| after());
        let remaining = counts[..test.peaks.len()].iter().filter(|counts| **counts).count();
        let found = conflict::worst(&likelihood, &state.particles);
        let left_out = |own: &Conflict| 1 + usize::from(own.partner.is_some());
        match found.filter(|own| remaining >= FEWEST + left_out(own)) {
            Some(own) => {
                counts[own.datum] = false;
                own.partner.into_iter().for_each(|partner| counts[partner] = false);
                conflicts.push(own);
            }
            None => {
                return Ok(Posterior {
                    diagnostics: sampler.diagnostics(&state),
                    likelihood,
                    candidates,
                    state,
                    conflicts,
                    counts,
                });
            }
        }
    }
}

/// Draws from the ranges.
fn candidates(simulation: &Simulation<'_>, draws: usize, seed: u64) -> Vec<Candidate> {
    let candidate = |index: u64| {
        let place = |k: u64| normal::quantile(uniform(seed ^ CANDIDATES, index, k).max(f64::EPSILON));
        let z: Vec<f64> = (0..INPUTS as u64).map(place).collect();
        let predictions = simulation.predict(&z, 0).ok()?;
        Some(Candidate { z, predictions })
    };
    let mut found = Vec::new();
    let block = draws as u64;
    for first in (0..4).map(|number| number * block) {
        let next: Vec<Candidate> = (first..first + block).into_par_iter().filter_map(candidate).collect();
        found.extend(next);
        if found.len() >= draws {
            break;
        }
    }
    found.truncate(draws);
    found
}
