//! Third-octave levels of a pressure record by the standard's filters, for time-varying and steady sounds.

use super::error::LoudnessError;
use crate::checks::{InputError, finite};
use crate::signals::REFERENCE_PRESSURE;

/// Third octaves of the method, 25 Hz to 12.5 kHz.
pub const BANDS: usize = 28;

/// Sampling rate of the pressure \[1/s\].
pub const SAMPLE_RATE: f64 = 48_000.0;

/// Rate of the levels over time \[1/s\].
pub(super) const LEVEL_RATE: f64 = 2000.0;

/// Number of samples between two levels.
const DECIMATION: usize = 24;

/// Index of the band of 1 kHz.
const INDEX_1_KHZ: i32 = 16;

/// Squared pressure added before taking levels \[Pa²\].
const FLOOR: f64 = 1e-12;

/// Number of second-order sections per band.
const SECTIONS: usize = 3;

/// Numerators of the sections, for z^0, z^-1 and z^-2 (table A.1).
const NUMERATORS: [[f64; 3]; SECTIONS] = [[1.0, 2.0, 1.0], [1.0, 0.0, -1.0], [1.0, -2.0, 1.0]];

/// For each band, the gain, then for each section the differences of -2 and 1 minus its denominator coefficients of
/// z^-1 and z^-2 (table A.2).
const FILTERS: [[f64; 1 + 2 * SECTIONS]; BANDS] = [
    [
        4.30764e-11,
        -6.70260e-4,
        6.59453e-4,
        -3.75071e-4,
        3.61926e-4,
        -3.06523e-4,
        2.97634e-4,
    ],
    [
        8.59340e-11,
        -8.47258e-4,
        8.30131e-4,
        -4.76448e-4,
        4.55616e-4,
        -3.88773e-4,
        3.74685e-4,
    ],
    [
        1.71424e-10,
        -1.07210e-3,
        1.04496e-3,
        -6.06567e-4,
        5.73553e-4,
        -4.94004e-4,
        4.71677e-4,
    ],
    [
        3.41944e-10,
        -1.35836e-3,
        1.31535e-3,
        -7.74327e-4,
        7.22007e-4,
        -6.29154e-4,
        5.93771e-4,
    ],
    [
        6.82035e-10,
        -1.72380e-3,
        1.65564e-3,
        -9.91780e-4,
        9.08866e-4,
        -8.03529e-4,
        7.47455e-4,
    ],
    [
        1.36026e-9,
        -2.19188e-3,
        2.08388e-3,
        -1.27545e-3,
        1.14406e-3,
        -1.02976e-3,
        9.40900e-4,
    ],
    [
        2.71261e-9,
        -2.79386e-3,
        2.62274e-3,
        -1.64828e-3,
        1.44006e-3,
        -1.32520e-3,
        1.18438e-3,
    ],
    [
        5.40870e-9,
        -3.57182e-3,
        3.30071e-3,
        -2.14252e-3,
        1.81258e-3,
        -1.71397e-3,
        1.49082e-3,
    ],
    [
        1.07826e-8,
        -4.58305e-3,
        4.15355e-3,
        -2.80413e-3,
        2.28135e-3,
        -2.23006e-3,
        1.87646e-3,
    ],
    [
        2.14910e-8,
        -5.90655e-3,
        5.22622e-3,
        -3.69947e-3,
        2.87118e-3,
        -2.92205e-3,
        2.36178e-3,
    ],
    [
        4.28228e-8,
        -7.65243e-3,
        6.57493e-3,
        -4.92540e-3,
        3.61318e-3,
        -3.86007e-3,
        2.97240e-3,
    ],
    [
        8.54316e-8,
        -1.00023e-2,
        8.29610e-3,
        -6.63788e-3,
        4.55999e-3,
        -5.15982e-3,
        3.75306e-3,
    ],
    [
        1.70009e-7,
        -1.31230e-2,
        1.04220e-2,
        -9.02274e-3,
        5.73132e-3,
        -6.94543e-3,
        4.71734e-3,
    ],
    [
        3.38215e-7,
        -1.73693e-2,
        1.30947e-2,
        -1.24176e-2,
        7.20526e-3,
        -9.46002e-3,
        5.93145e-3,
    ],
    [
        6.71990e-7,
        -2.31934e-2,
        1.64308e-2,
        -1.73009e-2,
        9.04761e-3,
        -1.30358e-2,
        7.44926e-3,
    ],
    [
        1.33531e-6,
        -3.13292e-2,
        2.06370e-2,
        -2.44342e-2,
        1.13731e-2,
        -1.82108e-2,
        9.36778e-3,
    ],
    [
        2.65172e-6,
        -4.28261e-2,
        2.59325e-2,
        -3.49619e-2,
        1.43046e-2,
        -2.57855e-2,
        1.17912e-2,
    ],
    [
        5.25477e-6,
        -5.91733e-2,
        3.25054e-2,
        -5.06072e-2,
        1.79513e-2,
        -3.69401e-2,
        1.48094e-2,
    ],
    [
        1.03780e-5,
        -8.26348e-2,
        4.05894e-2,
        -7.40348e-2,
        2.24476e-2,
        -5.34977e-2,
        1.85371e-2,
    ],
    [
        2.04870e-5,
        -1.17018e-1,
        5.08116e-2,
        -1.09516e-1,
        2.81387e-2,
        -7.85097e-2,
        2.32872e-2,
    ],
    [
        4.05198e-5,
        -1.67714e-1,
        6.37872e-2,
        -1.63378e-1,
        3.53729e-2,
        -1.16419e-1,
        2.93723e-2,
    ],
    [
        7.97914e-5,
        -2.42528e-1,
        7.98576e-2,
        -2.45161e-1,
        4.43370e-2,
        -1.73972e-1,
        3.70015e-2,
    ],
    [
        1.56511e-4,
        -3.53142e-1,
        9.96330e-2,
        -3.69163e-1,
        5.53535e-2,
        -2.61399e-1,
        4.65428e-2,
    ],
    [
        3.04954e-4,
        -5.16316e-1,
        1.24177e-1,
        -5.55473e-1,
        6.89403e-2,
        -3.93998e-1,
        5.86715e-2,
    ],
    [
        5.99157e-4,
        -7.56635e-1,
        1.55023e-1,
        -8.34281e-1,
        8.58123e-2,
        -5.94547e-1,
        7.43960e-2,
    ],
    [
        1.16544e-3,
        -1.10165,
        1.91713e-1,
        -1.23939,
        1.05243e-1,
        -8.91666e-1,
        9.40354e-2,
    ],
    [
        2.27488e-3, -1.58477, 2.39049e-1, -1.80505, 1.28794e-1, -1.32500, 1.21333e-1,
    ],
    [
        3.91006e-3, -2.50630, 1.42308e-1, -2.19464, 2.76470e-1, -1.90231, 1.47304e-1,
    ],
];

/// Pressure of a band \[Pa\] from the pressure of all bands \[Pa\].
fn filtered(pressure: &[f64], band: usize) -> Vec<f64> {
    let [gain, differences @ ..] = FILTERS[band];
    let mut signal: Vec<f64> = pressure.iter().map(|p| gain * p).collect();
    for (numerator, difference) in NUMERATORS.iter().zip(differences.chunks_exact(2)) {
        let [a1, a2] = [-2.0 - difference[0], 1.0 - difference[1]];
        // Transposed direct form II.
        let (mut first, mut second) = (0.0, 0.0);
        for sample in &mut signal {
            let input = *sample;
            let output = numerator[0] * input + first;
            first = numerator[1] * input - a1 * output + second;
            second = numerator[2] * input - a2 * output;
            *sample = output;
        }
    }
    signal
}

/// Level of a mean squared pressure \[Pa²\] in dB re 20 uPa, with a floor of about -26 dB.
fn level(squared: f64) -> f64 {
    10.0 * ((squared + FLOOR) / REFERENCE_PRESSURE.powi(2)).log10()
}

/// Third-octave levels over time, one row every 0.5 ms \[dB re 20 uPa\] (ISO 532-1:2017, 6.2).
///
/// Three first-order low-pass filters smooth the square of each band's pressure; their time constant is 2/(3 f_m),
/// with f_m limited to 1 kHz.
///
/// # Errors
/// If a pressure is not finite.
pub(super) fn levels_over_time(pressure: &[f64]) -> Result<Vec<[f64; BANDS]>, LoudnessError> {
    finite("pressure", pressure)?;
    let mut levels = vec![[0.0; BANDS]; pressure.len().div_ceil(DECIMATION)];
    for (band, index) in (0..).enumerate().take(BANDS) {
        let hz = 1000.0 * 10f64.powf(0.1 * f64::from(index - INDEX_1_KHZ));
        let time_constant = 2.0 / (3.0 * hz.min(1000.0));
        let retained = (-1.0 / (SAMPLE_RATE * time_constant)).exp();
        let mut states = [0.0; 3];
        for (i, p) in filtered(pressure, band).into_iter().enumerate() {
            let mut input = p * p;
            for state in &mut states {
                *state = retained * *state + (1.0 - retained) * input;
                input = *state;
            }
            if i % DECIMATION == 0 {
                levels[i / DECIMATION][band] = level(input);
            }
        }
    }
    Ok(levels)
}

/// Third-octave levels of a steady sound \[dB re 20 uPa\] from its pressure \[Pa\] at 48 kHz (ISO 532-1:2017, 5.2). The
/// first `skip` \[s\] are excluded, because the filters settle during that time.
///
/// # Errors
/// If a pressure is not finite or nothing follows `skip`.
pub fn steady_levels(pressure: &[f64], skip: f64) -> Result<[f64; BANDS], LoudnessError> {
    finite("pressure", pressure)?;
    let from = (skip * SAMPLE_RATE) as usize;
    if from >= pressure.len() {
        let (what, value) = (
            "record after the skipped time [s]",
            pressure.len() as f64 / SAMPLE_RATE - skip,
        );
        return Err(InputError::NotPositive { what, value }.into());
    }
    let mut levels = [0.0; BANDS];
    for (band, own) in levels.iter_mut().enumerate() {
        let kept = &filtered(pressure, band)[from..];
        *own = level(kept.iter().map(|p| p * p).sum::<f64>() / kept.len() as f64);
    }
    Ok(levels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tone_at_the_middle_of_a_band_has_its_level_there_and_little_elsewhere() {
        for (band, hz) in [(3, 50.12), (16, 1000.0), (27, 12_589.0)] {
            let omega = 2.0 * std::f64::consts::PI * hz / SAMPLE_RATE;
            let tone: Vec<f64> = (0..96_000).map(|i| 2f64.sqrt() * (omega * i as f64).sin()).collect();
            let levels = steady_levels(&tone, 1.0).unwrap_or([0.0; BANDS]);
            assert!((levels[band] - 93.979).abs() < 0.1, "{hz}: {}", levels[band]);
            if let Some(&upper) = levels.get(band + 1) {
                assert!(upper < levels[band] - 16.6, "{hz}: {upper}");
            }
        }
    }
}
