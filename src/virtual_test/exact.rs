//! The wrapping test computed with energies: the result of an infinite number of repeats without scatter.

use nailnoise_acoustics::signals::{REFERENCE_PRESSURE, Weighting};
use schemars::JsonSchema;
use serde::Serialize;

use super::sources::energies;
use crate::error::Error;
use crate::measurement::arrangement::Arrangement;
use crate::measurement::lines::{Bands, LENGTH, OneSecond};
use crate::measurement::wrapping::{Wrapping, configurations, separated, sources};

/// Range of the background noise, which has equal energy in each third octave \[Hz\].
pub(super) const BACKGROUND_HZ: [f64; 2] = [20.0, 20e3];

/// Levels of a wrapping test from energies \[dB re 1 pW s, A-weighted\]; `None` if no energy remains.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ExactTest {
    /// Unwrapped workpiece, exhaust and body, as measured by the array.
    pub sources_db: [Option<f64>; 3],
    /// The five configurations as recorded.
    pub configurations_db: [Option<f64>; 5],
    /// Workpiece, exhaust and body after subtraction of the residual: X_5, X_3, X_4.
    pub separated_db: [Option<f64>; 3],
    /// Upper bound of the workpiece.
    pub bound_db: Option<f64>,
    /// The total minus the level of the three sources.
    pub closure_db: Option<f64>,
    /// Least-squares estimate of the sources from all configurations, given the losses of the wraps.
    pub unmixed_db: [Option<f64>; 3],
    /// Level of the background alone.
    pub background_db: Option<f64>,
    /// Levels in one-third octaves.
    pub bands: Vec<ExactBand>,
}

/// A band of an [`ExactTest`].
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ExactBand {
    /// Nominal mid-band frequency \[Hz\].
    pub hz: f64,
    /// Same as [`ExactTest::sources_db`].
    pub sources_db: [Option<f64>; 3],
    /// Same as [`ExactTest::configurations_db`].
    pub configurations_db: [Option<f64>; 5],
    /// Same as [`ExactTest::separated_db`].
    pub separated_db: [Option<f64>; 3],
    /// Same as [`ExactTest::bound_db`].
    pub bound_db: Option<f64>,
}

/// Coefficient c of steady background noise with an A-weighted level \[dB re 20 uPa\] \[Pa2\]: the density of its mean
/// square is c/f, and that of its exposure over T seconds is c T/f.
pub fn background_density(level: f64) -> f64 {
    let [low, high] = BACKGROUND_HZ;
    // Number of steps of the trapezoidal rule over the logarithm of frequency, over which the density is constant.
    const STEPS: usize = 2000;
    let step = (high / low).ln() / STEPS as f64;
    let weight = |i: usize| Weighting::A.energy_factor(low * (step * i as f64).exp());
    let sum: f64 = (0..=STEPS)
        .map(|i| if i % STEPS == 0 { 0.5 } else { 1.0 } * weight(i))
        .sum();
    REFERENCE_PRESSURE.powi(2) * 10f64.powf(0.1 * level) / (sum * step)
}

/// The test of sources with these densities at the lines of one second \[Pa2 s/Hz\], recorded at `rate` \[1/s\], with
/// steady background noise of an A-weighted level \[dB\]; 0 for none.
///
/// # Errors
/// The errors of the room correction.
pub fn exact(
    arrangement: &Arrangement,
    rate: f64,
    wrapping: &Wrapping,
    densities: &[Vec<f64>; 3],
    background_level: f64,
) -> Result<ExactTest, Error> {
    let transform = OneSecond::new(rate);
    let frequency = transform.frequencies();
    let bands = Bands::new(&frequency, arrangement.range_hz);
    let room = arrangement.room_correction()?;
    let level = |energy: f64| arrangement.level(energy, room);
    let coefficient = if background_level > 0.0 {
        background_density(background_level) * LENGTH
    } else {
        0.0
    };
    let noise: Vec<f64> = frequency
        .iter()
        .map(|hz| {
            if (BACKGROUND_HZ[0]..=BACKGROUND_HZ[1]).contains(hz) {
                coefficient / hz
            } else {
                0.0
            }
        })
        .collect();
    let mut by_configuration: [Vec<f64>; 5] = std::array::from_fn(|_| Vec::with_capacity(frequency.len()));
    for (line, hz) in frequency.iter().enumerate() {
        let own = [0, 1, 2].map(|s: usize| densities[s].get(line).copied().unwrap_or(0.0));
        let mixed = configurations(&wrapping.at(*hz).matrix(), &own, noise[line]);
        by_configuration.iter_mut().zip(mixed).for_each(|(all, e)| all.push(e));
    }
    let bare = densities.each_ref().map(|density| energies(density, &bands));
    let recorded = by_configuration.each_ref().map(|density| energies(density, &bands));
    let background = energies(&noise, &bands);
    let whole = separated(&recorded.each_ref().map(|own| own.0));
    let mut unmixed = [0.0; 3];
    let of_band = |(place, hz): (usize, f64)| {
        let energies = recorded.each_ref().map(|own| own.1[place]);
        let parts = separated(&energies);
        let found = sources(&wrapping.at(hz).matrix(), &energies, background.1[place]);
        unmixed.iter_mut().zip(found).for_each(|(sum, e)| *sum += e);
        ExactBand {
            hz,
            sources_db: bare.each_ref().map(|own| level(own.1[place])),
            configurations_db: energies.map(level),
            separated_db: [parts.workpiece, parts.exhaust, parts.body].map(level),
            bound_db: level(parts.bound),
        }
    };
    let by_band = bands.nominal_hz().into_iter().enumerate().map(of_band).collect();
    Ok(ExactTest {
        sources_db: bare.each_ref().map(|own| level(own.0)),
        configurations_db: recorded.each_ref().map(|own| level(own.0)),
        separated_db: [whole.workpiece, whole.exhaust, whole.body].map(level),
        bound_db: level(whole.bound),
        closure_db: (whole.closure.is_finite() && whole.closure > 0.0).then(|| 10.0 * whole.closure.log10()),
        unmixed_db: unmixed.map(level),
        background_db: level(background.0),
        bands: by_band,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn background_noise_has_its_level() {
        let transform = OneSecond::new(48_000.0);
        let frequency = transform.frequencies();
        let c = background_density(40.0);
        let density: Vec<f64> = frequency
            .iter()
            .map(|hz| {
                if (BACKGROUND_HZ[0]..=BACKGROUND_HZ[1]).contains(hz) {
                    c / hz
                } else {
                    0.0
                }
            })
            .collect();
        let bands = Bands::new(&frequency, [20.0, 20e3]);
        let level = 10.0 * (energies(&density, &bands).0 / REFERENCE_PRESSURE.powi(2)).log10();
        assert!((level - 40.0).abs() < 0.01, "{level}");
    }
}
