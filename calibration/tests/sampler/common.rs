//! Models with known posteriors, and their runs.

use std::borrow::Cow;

use nailnoise_calibration::Simulator;
use nailnoise_calibration::likelihood::{Datum, ErrorLaw, Likelihood, Prediction, Reading};
use nailnoise_calibration::normal;
use nailnoise_calibration::sampler::{Candidate, Sampler, Settings, State};
use nailnoise_calibration::statistics::{log_mean_exp, moments};

pub(crate) const N: usize = 512;

/// A function of the variables as a simulator of one condition.
pub(crate) struct Model<F> {
    pub(crate) variables: usize,
    pub(crate) function: F,
}

impl<F: Fn(&[f64]) -> Vec<f64> + Sync> Simulator for Model<F> {
    fn variables(&self) -> usize {
        self.variables
    }

    fn predict(&self, z: &[f64], _: usize) -> Result<Vec<Prediction>, Cow<'static, str>> {
        Ok((self.function)(z).into_iter().map(Prediction::Value).collect())
    }
}

/// Readings of one condition: values and scales.
pub(crate) fn data(readings: &[[f64; 2]]) -> Vec<Datum> {
    let datum = |(k, [value, scale]): (usize, &[f64; 2])| Datum {
        name: format!("y{k}"),
        condition: 0,
        reading: Reading::Value(*value),
        scale: *scale,
        shared: Vec::new(),
        counts: true,
    };
    readings.iter().enumerate().map(datum).collect()
}

pub(crate) fn gaussian(readings: &[[f64; 2]]) -> Likelihood {
    Likelihood::new(data(readings), 1, &[], ErrorLaw::Gaussian).unwrap()
}

/// The finaliser of MurmurHash3 after a step.
fn mixed(x: u64) -> u64 {
    let mut x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
    for factor in [0xFF51_AFD7_ED55_8CCD, 0xC4CE_B9FE_1A85_EC53] {
        x = (x ^ (x >> 33)).wrapping_mul(factor);
    }
    x ^ (x >> 33)
}

/// Independent numbers in (0, 1) from a counter; not those of the sampler.
pub(crate) fn uniform(seed: u64, counter: u64) -> f64 {
    let x = mixed(mixed(seed).wrapping_add(counter));
    ((x >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
}

/// Draws from the prior with their predictions.
pub(crate) fn candidates<S: Simulator>(model: &S, count: usize, seed: u64) -> Vec<Candidate> {
    let d = model.variables();
    let candidate = |k: usize| {
        let z: Vec<f64> = (0..d)
            .map(|i| normal::quantile(uniform(seed, (k * d + i) as u64)))
            .collect();
        let predictions = model.predict(&z, 0).unwrap();
        Candidate { z, predictions }
    };
    (0..count).map(candidate).collect()
}

pub(crate) fn run<S: Simulator>(model: &S, likelihood: &Likelihood, seed: u64) -> State {
    let sampler = Sampler::new(model, likelihood, Settings { moves: 24, seed });
    let mut state = sampler.begin(candidates(model, N, seed));
    sampler.run(&mut state, |_| {});
    state
}

/// Log evidence with the constant of the likelihood.
pub(crate) fn log_evidence(state: &State, likelihood: &Likelihood) -> f64 {
    log_mean_exp(&state.log_evidence) + likelihood.constant()
}

/// Mean and standard deviation of a variable.
pub(crate) fn of(state: &State, variable: usize) -> [f64; 2] {
    moments(&state.particles.iter().map(|own| own.z[variable]).collect::<Vec<_>>())
}
