//! Convergence of the expected force over shots that differ slightly.

use std::thread;

use nailnoise_dynamics::blow::{BlowInput, Course, elastic_blow};
use nailnoise_dynamics::{Settings, blow_input, simulate};

use super::{elastic_n80cb, third_octave};

const BANDS: [f64; 4] = [5000.0, 6300.0, 8000.0, 10000.0];
const SHOTS: usize = 16;

/// Mean energies of the force on the wood in [`BANDS`] with some numbers of elements, over shots at pressures within
/// 5 % of the design's.
fn mean_energies(elements: [usize; 2], shots: std::ops::Range<usize>) -> [[f64; 4]; 2] {
    let mut sums = [[0.0; 4]; 2];
    for k in shots {
        let mut parameters = elastic_n80cb();
        parameters.supply.pressure *= 0.95 + 0.1 * (k as f64 + 0.5) / SHOTS as f64;
        let cycle = simulate(&parameters, &Settings::default()).unwrap();
        let input = blow_input(&parameters).unwrap().unwrap();
        let course = Course::of_record(&input, &cycle.record).unwrap();
        for (sums, elements) in sums.iter_mut().zip(elements) {
            let input = BlowInput {
                elements,
                ..input.clone()
            };
            let force = elastic_blow(&input, &course).unwrap().on_wood;
            for (sum, band) in sums.iter_mut().zip(BANDS) {
                *sum += third_octave(&force, cycle.sample_interval(), band) / SHOTS as f64;
            }
        }
    }
    sums
}

/// In a single shot, bands from 6.3 kHz on change by up to 10 dB between two numbers of elements, because the times of
/// the last strikes depend on details.
#[test]
fn the_mean_force_of_shots_converges_up_to_10_khz() {
    let halves = thread::scope(|scope| {
        let halves = [0..SHOTS / 2, SHOTS / 2..SHOTS];
        let runs = halves.map(|shots| scope.spawn(move || mean_energies([64, 128], shots)));
        runs.map(|run| run.join().unwrap())
    });
    let changes = [0, 1, 2, 3].map(|band| {
        let [coarse, fine] = [0, 1].map(|own: usize| halves.iter().map(|half| half[own][band]).sum::<f64>());
        10.0 * (fine / coarse).log10()
    });
    assert!(
        changes.iter().all(|change| change.abs() < 3.0),
        "{changes:.1?} dB in {BANDS:?} Hz"
    );
}
