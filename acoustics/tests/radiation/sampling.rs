//! Adaptive sampling of a radiation resistance over frequency.

use nailnoise_acoustics::radiation::{ModalRadiation, Resistance, SampledRadiation, Sampling};
use nalgebra::DMatrix;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Resonances of the air between two parallel plates, 270 Hz apart, as a block on a table has them: frequency and half
/// width \[Hz\].
const RESONANCES: [[f64; 2]; 4] = [[2213.0, 6.0], [2486.0, 6.0], [2756.0, 7.0], [3025.0, 8.0]];

/// A resistance that rises with the square of the frequency, three times as high at each resonance.
fn resistance(hz: f64) -> f64 {
    let peak = |[at, half]: [f64; 2]| 2.0 / (1.0 + ((hz - at) / half).powi(2));
    hz.powi(2) * (1.0 + RESONANCES.into_iter().map(peak).sum::<f64>())
}

#[test]
fn narrow_resonances_are_resolved_where_they_are() {
    let sampling = Sampling {
        range_hz: [1280.0, 3200.0],
        tolerance: 0.02,
        floor: 1e-2,
        most_samples: 800,
    };
    let solved = AtomicUsize::new(0);
    let solve = |hz: f64| {
        solved.fetch_add(1, Ordering::Relaxed);
        let real = DMatrix::from_element(1, 1, resistance(hz));
        Ok(vec![vec![Resistance { real, imaginary: None }]])
    };
    let found = SampledRadiation::of_parities("peaks", &[1], &["all".to_owned()], &sampling, solve).unwrap();
    // A test sample seldom meets the top of a peak, so the tolerance applies to the power in a band rather than to each
    // frequency.
    for [low, high] in [[1280.0, 2080.0], [2080.0, 2640.0], [2640.0, 3200.0]] {
        let hz = (0..5000).map(|step| low + (high - low) * (f64::from(step) + 0.5) / 5000.0);
        let (sum, exact) = hz.fold((0.0, 0.0), |(sum, exact), hz| {
            (sum + found[0].resistance(hz).real[(0, 0)], exact + resistance(hz))
        });
        let error = sum / exact - 1.0;
        assert!(error.abs() < sampling.tolerance, "{low} to {high} Hz: {error}");
    }
    // One polynomial over the whole range would need about 900, equal intervals of one polynomial each about 800, and
    // halves that begin anew 452.
    let solved = solved.into_inner();
    assert!(solved < 250, "{solved} frequencies");
}
