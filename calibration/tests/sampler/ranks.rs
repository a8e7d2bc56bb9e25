//! Simulation-based calibration of the sampler: truths of the prior are measured, calibrated and placed among the
//! draws.

use nailnoise_calibration::Simulator;
use nailnoise_calibration::likelihood::{ErrorLaw, Likelihood, Prediction};
use nailnoise_calibration::normal;
use nailnoise_calibration::ranks::{place, uniformity};
use nailnoise_calibration::sampler::{Sampler, Settings};

use super::common::{Model, candidates, data, uniform};

const RUNS: u64 = 80;
const DRAWS: usize = 256;

/// Scales of the errors of two readings, x + y/2 and y^2 + z.
const SCALES: [f64; 2] = [0.3, 0.5];

/// The places of x, z and the first reading's value in the posteriors of a likelihood whose scales are `factor` times
/// those with which the truths are measured.
fn places(factor: f64) -> [Vec<f64>; 3] {
    let model = Model {
        variables: 6,
        function: |z: &[f64]| vec![z[0] + 0.5 * z[1], z[1] * z[1] + z[2]],
    };
    let of = |readings: [f64; 2], factor: f64| {
        let own = [0, 1].map(|k| [readings[k], factor * SCALES[k]]);
        Likelihood::new(data(&own), 1, &[], ErrorLaw::Student).unwrap()
    };
    let mut found = [const { Vec::new() }; 3];
    for run in 0..RUNS {
        let number = |k: u64| uniform(0x7A17, 100 * run + k);
        let truth: Vec<f64> = (0..6).map(|k| normal::quantile(number(k))).collect();
        let predicted = model.predict(&truth, 0).unwrap();
        let shares = [number(10), number(11)];
        let readings = of([0.0; 2], 1.0).measured(&truth, &predicted, &shares);
        let likelihood = of([0, 1].map(|k| readings[k].nearest(0.0)), factor);
        let settings = Settings { moves: 24, seed: run };
        let sampler = Sampler::new(&model, &likelihood, settings);
        let mut state = sampler.begin(candidates(&model, DRAWS, 1000 + run));
        sampler.run(&mut state, |_| {});
        let value = |own: &[Prediction]| own[0].value();
        let draws = || state.particles.iter();
        let own = [
            place(truth[0], draws().map(|own| own.z[0]), number(20)),
            place(truth[2], draws().map(|own| own.z[2]), number(21)),
            place(
                value(&predicted),
                draws().map(|own| value(&own.predictions)),
                number(22),
            ),
        ];
        found.iter_mut().zip(own).for_each(|(all, own)| all.push(own.unwrap()));
    }
    found
}

#[test]
fn truths_have_uniform_places_in_posteriors_of_the_right_likelihood() {
    for own in places(1.0) {
        let found = uniformity(&own).unwrap();
        assert!(found.p > 0.01, "{found:?}");
    }
}

#[test]
fn truths_are_at_the_ends_of_posteriors_with_half_the_true_error() {
    let [_, _, reading] = places(0.5);
    let found = uniformity(&reading).unwrap();
    assert!(found.p < 1e-3, "{found:?}");
    // Too narrow: more places beyond P5 and P95 than the tenth of the right likelihood.
    let beyond = reading.iter().filter(|own| !(0.05..=0.95).contains(*own)).count();
    assert!(beyond as u64 > RUNS / 5, "{beyond} of {RUNS}");
}
