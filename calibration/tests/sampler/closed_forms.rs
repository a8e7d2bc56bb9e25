//! Posteriors that are known: linear models in closed form, bent and bimodal ones by quadrature.
//!
//! Limits are three times the scatter over seeds that a separate implementation of the method had with as many
//! particles.

use nailnoise_calibration::statistics::correlation;

use super::common::{Model, gaussian, log_evidence, of, run};

const SEEDS: std::ops::Range<u64> = 0..3;

#[test]
fn five_variables_with_three_linear_readings_have_their_gaussian_posterior() {
    let model = Model {
        variables: 5,
        function: |z: &[f64]| vec![z[0] + 0.5 * z[1], z[1] + 0.5 * z[2], 0.3 * z[0] + z[3]],
    };
    let likelihood = gaussian(&[[1.0, 0.2], [-0.5, 0.2], [2.0, 0.2]]);
    let means = [1.131_072, -0.314_307, -0.320_161, 1.596_806, 0.0];
    let deviations = [0.295_123, 0.460_844, 0.877_072, 0.213_796, 1.0];
    for seed in SEEDS {
        let state = run(&model, &likelihood, seed);
        let evidence = log_evidence(&state, &likelihood) + 5.036_357;
        assert!(
            evidence.abs() < 3.0 * 0.091,
            "seed {seed}: log evidence off by {evidence}"
        );
        for (k, (mean, deviation)) in means.into_iter().zip(deviations).enumerate() {
            let got = of(&state, k);
            assert!(
                (got[0] - mean).abs() < 3.0 * 0.048 * deviation,
                "seed {seed}, {k}: {got:?}"
            );
            assert!(
                (got[1] / deviation - 1.0).abs() < 3.0 * 0.032,
                "seed {seed}, {k}: {got:?}"
            );
        }
        let [a, b] = [0, 1].map(|k| state.particles.iter().map(|own| own.z[k]).collect::<Vec<_>>());
        assert!((correlation(&a, &b) + 0.748_247).abs() < 0.06);
        assert!((state.log_evidence[0] - state.log_evidence[1]).abs() < 3.0 * 0.18);
    }
}

#[test]
fn sixty_variables_with_twelve_linear_readings_have_their_gaussian_posterior() {
    let model = Model {
        variables: 60,
        function: |z: &[f64]| {
            let reading = |k: u32| (1..).zip(z).map(|(i, z)| (f64::from(k) * f64::from(i)).cos() * z).sum();
            (1..=12).map(reading).collect()
        },
    };
    let readings: Vec<[f64; 2]> = (1..=12).map(|k| [4.0 * f64::from(k).sin(), 0.5]).collect();
    let likelihood = gaussian(&readings);
    let means = [-0.021_613, -0.026_542, -0.034_619, -0.070_902, -0.434_824];
    let deviations = [0.897_780, 0.898_724, 0.907_001, 0.896_821, 0.896_497];
    for seed in SEEDS {
        let state = run(&model, &likelihood, seed);
        let evidence = log_evidence(&state, &likelihood) + 33.224_746;
        assert!(
            evidence.abs() < 3.0 * 0.204,
            "seed {seed}: log evidence off by {evidence}"
        );
        for (k, (mean, deviation)) in means.into_iter().zip(deviations).enumerate() {
            let got = of(&state, k);
            assert!(
                (got[0] - mean).abs() < 3.0 * 0.045 * deviation,
                "seed {seed}, {k}: {got:?}"
            );
            assert!(
                (got[1] / deviation - 1.0).abs() < 3.0 * 0.031,
                "seed {seed}, {k}: {got:?}"
            );
        }
    }
}

#[test]
fn a_banana_in_twenty_variables_has_the_moments_of_the_quadrature() {
    let model = Model {
        variables: 20,
        function: |z: &[f64]| vec![z[0] + z[1], z[1] - z[0] * z[0] + 1.0],
    };
    let likelihood = gaussian(&[[0.0, 0.5], [0.0, 0.1]]);
    for seed in SEEDS {
        let state = run(&model, &likelihood, seed);
        let evidence = log_evidence(&state, &likelihood) + 2.7206;
        assert!(
            evidence.abs() < 3.0 * 0.115,
            "seed {seed}: log evidence off by {evidence}"
        );
        let [x, y] = [of(&state, 0)[0], of(&state, 1)[0]];
        assert!(
            (x - 0.1388).abs() < 3.0 * 0.061 && (y + 0.3719).abs() < 3.0 * 0.031,
            "{x} {y}"
        );
        let positive = state.particles.iter().filter(|own| own.z[0] > 0.0).count() as f64;
        assert!((positive / state.particles.len() as f64 - 0.7356).abs() < 3.0 * 0.037);
    }
}

#[test]
fn two_modes_have_their_shares() {
    let model = Model {
        variables: 20,
        function: |z: &[f64]| vec![z[0] * z[0] + 0.3 * z[0], z[0] + z[1]],
    };
    let likelihood = gaussian(&[[2.25, 0.15], [0.5, 0.6]]);
    for seed in SEEDS {
        let state = run(&model, &likelihood, seed);
        let evidence = log_evidence(&state, &likelihood) + 4.1358;
        assert!(
            evidence.abs() < 3.0 * 0.086,
            "seed {seed}: log evidence off by {evidence}"
        );
        let positive = state.particles.iter().filter(|own| own.z[0] > 0.0).count() as f64;
        assert!((positive / state.particles.len() as f64 - 0.8678).abs() < 3.0 * 0.030);
    }
}
