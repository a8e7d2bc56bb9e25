//! Readings that contradict each other are named, alone or as a pair; those that agree are not.

use nailnoise_calibration::conflict::{at_ends, left_out_probability, unreached, widening, worst};
use nailnoise_calibration::likelihood::{ErrorLaw, Likelihood};
use nailnoise_calibration::sampler::State;

use super::common::{Model, candidates, data, run};

/// Four readings of z_0 and one of z_1.
fn model() -> Model<impl Fn(&[f64]) -> Vec<f64> + Sync> {
    Model {
        variables: 12,
        function: |z: &[f64]| vec![z[0], z[0] + 0.1 * z[2], z[0] - 0.1 * z[3], z[0], z[1]],
    }
}

fn student(readings: &[[f64; 2]], counting: &[usize]) -> Likelihood {
    let mut data = data(readings);
    for (k, own) in data.iter_mut().enumerate() {
        own.counts = counting.contains(&k);
    }
    Likelihood::new(data, 1, &[], ErrorLaw::Student).unwrap()
}

fn sampled(readings: &[[f64; 2]], counting: &[usize]) -> (Likelihood, State) {
    let likelihood = student(readings, counting);
    let state = run(&model(), &likelihood, 3);
    (likelihood, state)
}

#[test]
fn readings_that_agree_are_no_conflict() {
    let (likelihood, state) = sampled(
        &[[0.5, 0.1], [0.45, 0.1], [0.6, 0.1], [0.5, 0.1], [-1.0, 0.1]],
        &[0, 1, 2, 3, 4],
    );
    assert_eq!(worst(&likelihood, &state.particles), None);
}

#[test]
fn one_wrong_reading_contradicts_the_rest() {
    let (likelihood, state) = sampled(
        &[[0.5, 0.1], [0.45, 0.1], [0.6, 0.1], [2.0, 0.1], [-1.0, 0.1]],
        &[0, 1, 2, 3, 4],
    );
    let found = worst(&likelihood, &state.particles).unwrap();
    assert_eq!((found.datum, found.partner), (3, None));
    assert!(found.probability < 0.01);
}

#[test]
fn two_readings_that_contradict_only_each_other_are_a_pair() {
    let (likelihood, state) = sampled(
        &[[0.5, 0.1], [0.0, 0.1], [0.0, 0.1], [2.0, 0.1], [-1.0, 0.1]],
        &[0, 3, 4],
    );
    let found = worst(&likelihood, &state.particles).unwrap();
    let mut pair = [Some(found.datum), found.partner];
    pair.sort_unstable();
    assert_eq!(pair, [Some(0), Some(3)]);
}

#[test]
fn widened_errors_make_a_pair_agree() {
    let readings = [[0.5, 0.1], [0.0, 0.1], [0.0, 0.1], [2.0, 0.1], [-1.0, 0.1]];
    let (likelihood, state) = sampled(&readings, &[4]);
    let factor = widening(&likelihood, &state.particles, 0, Some(3));
    assert!((2.0..20.0).contains(&factor), "{factor}");
    let mut widened = readings;
    for k in [0, 3] {
        widened[k][1] *= factor;
    }
    let (likelihood, state) = sampled(&widened, &[0, 3, 4]);
    assert_eq!(worst(&likelihood, &state.particles), None);
    let least = [0, 3].map(|k| left_out_probability(&likelihood, &state.particles, k, &[]));
    let least = least[0].min(least[1]);
    assert!((0.02..0.12).contains(&least), "{least}");
}

#[test]
fn a_reading_beyond_all_candidates_is_not_reached_and_one_between_them_is() {
    let model = model();
    let start = candidates(&model, 500, 1);
    let likelihood = student(&[[9.0, 0.1], [0.0, 1e-9], [0.0, 0.1], [0.0, 0.1], [0.0, 0.1]], &[0, 1]);
    let far = unreached(&likelihood, 0, &start).unwrap();
    assert!(far.nearest > 2.0 && far.nearest < 5.0 && far.distance > 30.0);
    assert_eq!(unreached(&likelihood, 1, &start), None);
}

#[test]
fn an_input_that_a_reading_presses_to_its_end_is_named() {
    let (_, state) = sampled(&[[2.2, 0.1], [0.0, 0.1], [0.0, 0.1], [0.0, 0.1], [0.0, 0.1]], &[0, 4]);
    let weights = vec![1.0 / state.particles.len() as f64; state.particles.len()];
    let found = at_ends(&state.particles, &weights, &[]);
    assert_eq!(found.len(), 1);
    assert!(found[0].variable == 0 && found[0].is_upper && found[0].share > 0.9);
}
