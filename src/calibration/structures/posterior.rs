//! Draws of a plate's inputs given its peaks. Peaks that contradict the others are left out, as in any calibration.

use nailnoise_calibration::Simulator;
use nailnoise_calibration::conflict::{self, Conflict};
use nailnoise_calibration::likelihood::{ErrorLaw, Likelihood, LikelihoodError};
use nailnoise_calibration::sampler::{Candidate, Diagnostics, Sampler, Settings, State};
use rayon::prelude::*;

use super::super::random::standard_normal;
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
        sampler.run(&mut state, |_| ());
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
        let z: Vec<f64> = (0..INPUTS as u64)
            .map(|k| standard_normal(seed ^ CANDIDATES, index, k))
            .collect();
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

#[cfg(test)]
mod tests {
    use nailnoise_documents::Document;

    use super::super::reader;
    use super::super::tap_test::{E_L, E_R, G_LR};
    use super::*;

    const SPRUCE: &str = include_str!("../../../examples/plates/spruce.toml");

    /// A plate of the example with the first peaks of a hidden plate, and its point.
    fn hidden(ritz: &Ritz) -> (TapTest, [f64; INPUTS]) {
        let document = Document::new("plates.toml".as_ref(), SPRUCE);
        let mut test = reader::read(&document).unwrap().tests.remove(0);
        let z = [0.3, -0.2, 0.5, 0.4, -0.8, 0.7, 0.9, -0.5, 0.6, 0.2, -0.4];
        let modes = ritz.modes(&test.plate(&z)).unwrap();
        test.peaks = modes.iter().take(6).map(|own| own.hz).collect();
        (test, z)
    }

    const SETTINGS: Settings = Settings { moves: 6, seed: 3 };

    #[test]
    fn three_moduli_of_a_hidden_plate_lie_within_their_draws() {
        let ritz = Ritz::new([8, 6]);
        let (test, z) = hidden(&ritz);
        let found = posterior(&ritz, &test, 256, SETTINGS).unwrap();
        assert!(found.conflicts.is_empty());
        for k in [E_L, E_R, G_LR] {
            let mut own: Vec<f64> = found.state.particles.iter().map(|draw| draw.z[k]).collect();
            own.sort_by(f64::total_cmp);
            let (low, high) = (own[5], own[250]);
            assert!(low < z[k] && z[k] < high, "input {k}: {} in {low} .. {high}", z[k]);
            assert!(high - low < 2.0, "input {k} is not determined: {low} .. {high}");
        }
    }

    #[test]
    fn a_wrong_peak_is_left_out() {
        let ritz = Ritz::new([8, 6]);
        let (mut test, _) = hidden(&ritz);
        test.peaks[1] *= 1.3;
        test.peaks.sort_by(f64::total_cmp);
        let found = posterior(&ritz, &test, 256, SETTINGS).unwrap();
        assert!(!found.conflicts.is_empty() && found.counts.contains(&false));
    }
}
