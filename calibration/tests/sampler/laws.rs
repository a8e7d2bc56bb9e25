//! Laws of the sampler: changes of the input that must not affect its result, and changes that must.

use std::borrow::Cow;
use std::cell::Cell;

use nailnoise_calibration::Simulator;
use nailnoise_calibration::likelihood::Prediction;
use nailnoise_calibration::sampler::{Proposal, Sampler, Settings};

use super::common::{Model, N, candidates, gaussian, of, run};

const SETTINGS: Settings = Settings { moves: 6, seed: 4 };

fn model() -> Model<impl Fn(&[f64]) -> Vec<f64> + Sync> {
    Model {
        variables: 8,
        function: |z: &[f64]| vec![z[0] + z[1].powi(2), z[1] - z[2]],
    }
}

#[test]
fn without_readings_the_draws_are_the_candidates() {
    let model = model();
    let mut likelihood = gaussian(&[]);
    assert!(!likelihood.is_informed());
    let sampler = Sampler::new(&model, &likelihood, SETTINGS);
    let start = candidates(&model, N, 1);
    let mut state = sampler.begin(start.clone());
    sampler.run(&mut state, |_| panic!("there is no move"));
    assert!(
        state
            .particles
            .iter()
            .zip(&start)
            .all(|(own, candidate)| own.z == candidate.z)
    );
    // Readings that are held out predict and do not condition.
    let mut data = super::common::data(&[[9.0, 0.1], [9.0, 0.1]]);
    data.iter_mut().for_each(|own| own.counts = false);
    likelihood = nailnoise_calibration::likelihood::Likelihood::new(data, 1, &[], likelihood.law()).unwrap();
    assert!(Sampler::new(&model, &likelihood, SETTINGS).begin(start).is_finished());
}

#[test]
fn one_thread_and_eight_give_the_same_draws() {
    let (model, likelihood) = (model(), gaussian(&[[1.0, 0.1], [0.5, 0.1]]));
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(&model, &likelihood, 2))
    };
    assert_eq!(on(1), on(8));
}

#[test]
fn proposals_simulated_in_parts_give_the_same_draws() {
    let (model, likelihood) = (model(), gaussian(&[[1.0, 0.1], [0.5, 0.1]]));
    let sampler = Sampler::new(&model, &likelihood, SETTINGS);
    let [mut whole, mut parts] = [(); 2].map(|()| sampler.begin(candidates(&model, N, 1)));
    sampler.run(&mut whole, |_| {});
    let elsewhere = Sampler::new(&model, &likelihood, SETTINGS);
    let in_parts = |proposals: Vec<Proposal>| {
        let results = proposals.chunks(7).map(|own| elsewhere.simulate(own.to_vec()));
        Ok::<_, ()>(results.flatten().collect())
    };
    sampler.run_with(&mut parts, in_parts, |_| {}).unwrap();
    assert_eq!(parts, whole);
}

#[test]
fn a_run_whose_simulation_fails_can_be_continued() {
    let (model, likelihood) = (model(), gaussian(&[[1.0, 0.1], [0.5, 0.1]]));
    let sampler = Sampler::new(&model, &likelihood, SETTINGS);
    let mut whole = sampler.begin(candidates(&model, N, 1));
    sampler.run(&mut whole, |_| {});
    // A step has six moves at most, so one of seven moves in a row is the first of a step.
    for last in 0..7 {
        let mut state = sampler.begin(candidates(&model, N, 1));
        let moves = Cell::new(0);
        let failing = |proposals: Vec<Proposal>| {
            if moves.replace(moves.get() + 1) == last {
                return Err("no workers");
            }
            Ok(sampler.simulate(proposals))
        };
        assert_eq!(sampler.run_with(&mut state, failing, |_| {}), Err("no workers"));
        assert!(!state.is_finished());
        sampler.run(&mut state, |_| {});
        assert_eq!(state, whole);
    }
}

#[test]
fn a_run_that_is_interrupted_goes_on_to_the_same_draws() {
    let (model, likelihood) = (model(), gaussian(&[[1.0, 0.1], [0.5, 0.1]]));
    let sampler = Sampler::new(&model, &likelihood, SETTINGS);
    let mut whole = sampler.begin(candidates(&model, N, 1));
    let mut stored = Vec::new();
    sampler.run(&mut whole, |state| stored.push(state.clone()));
    assert!(stored.len() > 6, "the run has several steps");
    for mut state in stored.into_iter().step_by(5) {
        sampler.run(&mut state, |_| {});
        assert_eq!(state, whole);
    }
}

#[test]
fn a_reading_twice_with_twice_the_variance_is_the_reading_once() {
    let twice = Model {
        variables: 4,
        function: |z: &[f64]| vec![z[0] + z[1]; 2],
    };
    let scale = 0.2 * 2.0_f64.sqrt();
    let state = run(&twice, &gaussian(&[[1.0, scale]; 2]), 1);
    // z_0 + z_1 = 1 with an error of 0.2: mean 1/2.04, variance 1 - 1/2.04.
    for k in 0..2 {
        let [mean, deviation] = of(&state, k);
        let expected = (1.0_f64 - 1.0 / 2.04).sqrt();
        assert!((mean - 1.0 / 2.04).abs() < 0.15 * expected, "{mean}");
        assert!((deviation / expected - 1.0).abs() < 0.1, "{deviation}");
    }
}

/// x < y as a rule; the reading is x.
struct Ordered;

impl Simulator for Ordered {
    fn variables(&self) -> usize {
        3
    }

    fn predict(&self, z: &[f64], _: usize) -> Result<Vec<Prediction>, Cow<'static, str>> {
        if z[2] > 2.0 {
            return Err("too_far".into());
        }
        Ok(vec![Prediction::Value(z[0])])
    }

    fn is_ruled(&self) -> Vec<bool> {
        vec![true, true, false]
    }

    fn restore(&self, proposed: &mut [f64], current: &[f64]) {
        if proposed[0] >= proposed[1] {
            proposed[..2].copy_from_slice(&current[..2]);
        }
    }
}

#[test]
fn rules_and_outcomes_are_never_broken_and_the_rest_has_its_posterior() {
    let likelihood = gaussian(&[[0.5, 0.5]]);
    let sampler = Sampler::new(&Ordered, &likelihood, Settings { moves: 24, seed: 1 });
    let prior = Model {
        variables: 3,
        function: |z: &[f64]| vec![z[0]],
    };
    let mut start = candidates(&prior, 4 * N, 3);
    start.retain(|own| own.z[0] < own.z[1] && own.z[2] <= 2.0);
    start.truncate(N);
    let mut state = sampler.begin(start);
    sampler.run(&mut state, |_| {});
    assert!(state.particles.iter().all(|own| own.z[0] < own.z[1] && own.z[2] <= 2.0));
    // p(x) ~ phi(x) (1 - Phi(x)) exp(-(x - 1/2)^2/(2/4)), by quadrature.
    let weight =
        |x: f64| (-0.5 * x * x - 2.0 * (x - 0.5).powi(2)).exp() * (1.0 - nailnoise_calibration::normal::cumulative(x));
    let grid = || (0..8000).map(|k| -4.0 + 1e-3 * f64::from(k));
    let expected = grid().map(|x| x * weight(x)).sum::<f64>() / grid().map(weight).sum::<f64>();
    let [mean, deviation] = of(&state, 0);
    assert!((mean - expected).abs() < 0.2 * deviation, "{mean}, expected {expected}");
}
