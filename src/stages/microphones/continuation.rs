//! Noise that continues the signals of a source above the frequencies at which its pressures are known.

use std::f64::consts::PI;

use nailnoise_acoustics::radiation::radiator::FADE_OCTAVES;
use nailnoise_acoustics::signals::fourier::RealTransform;
use nailnoise_acoustics::signals::{PowerHistory, Weighting, energy_weights};
use rayon::prelude::*;

use super::SAMPLE_RATE;
use super::bands::density;
use super::noise::under_envelope;
use crate::stages::sound::SoundSource;

/// The directivity is taken from this number of octaves below the end of the known pressures.
const DIRECTIVITY_OCTAVES: f64 = 1.0;

/// Continuation of a source above its known pressures (above the boundary elements), where only its power is known.
///
/// Gaussian noise with the density of the power and its history over time replaces the pressures where they fade, over
/// [`FADE_OCTAVES`]. Each receiver gets the same fraction of the power as in the octave below. Its waveforms and peaks
/// are one choice among many; its energies are those of the power.
pub(crate) struct Continuation<'a> {
    /// The parts of the source, whose energies sum to its own.
    parts: &'a [&'a SoundSource],
    /// End of the known pressures \[Hz\].
    end: f64,
    /// Ratio of the exposure at each receiver to the radiated energy \[Pa² s/J\].
    pub(super) shares: Vec<f64>,
}

impl<'a> Continuation<'a> {
    /// The continuation of a source whose `signals` at each receiver, at [`SAMPLE_RATE`], are known up to `end`. `None`
    /// if they extend to `top`, or if the source radiates nothing in between.
    pub(crate) fn new(parts: &'a [&'a SoundSource], signals: &[Vec<f64>], [end, top]: [f64; 2]) -> Option<Self> {
        let radiated = |range| -> f64 { parts.iter().map(|part| part.spectrum.energy(range, Weighting::Z)).sum() };
        if end >= top * (1.0 - 1e-9) || radiated([end, top]) <= 0.0 {
            return None;
        }
        let below = [end * 2f64.powf(-DIRECTIVITY_OCTAVES), end];
        Some(Self {
            parts,
            end,
            shares: shares(signals, below, radiated(below)),
        })
    }

    /// Fraction of the power that is noise; it rises as that of the known pressures falls \[-\].
    pub(super) fn risen(&self, hz: f64) -> f64 {
        let fading = ((hz / self.end).log2() / FADE_OCTAVES).clamp(0.0, 1.0);
        (0.5 * PI * fading).sin().powi(2)
    }

    /// The noise at each receiver from the trigger on \[Pa\], at any `rate` \[1/s\]; `travel` are the travel times from
    /// the source \[s\].
    pub(crate) fn noise(
        &self,
        travel: &[f64],
        (rate, samples): (f64, usize),
        (seed, stream): (u64, u64),
    ) -> Vec<Vec<f64>> {
        let histories: Vec<&PowerHistory> = self.parts.iter().flat_map(|part| &part.histories).collect();
        let radiated = |hz: f64| -> f64 { self.parts.iter().map(|part| part.spectrum.density_at(hz)).sum() };
        let at = |(place, (travel, share)): (usize, (&f64, &f64))| {
            let envelope = envelope(&histories, *travel, rate, samples);
            let density = |hz: f64| share * self.risen(hz) * radiated(hz).max(0.0);
            under_envelope(&envelope, rate, density, (seed, 64 * stream + place as u64))
        };
        travel.par_iter().zip(&self.shares).enumerate().map(at).collect()
    }
}

/// Ratio of the exposure at each receiver to the energy radiated in the same range \[Pa² s/J\].
fn shares(signals: &[Vec<f64>], range: [f64; 2], radiated: f64) -> Vec<f64> {
    let rate = f64::from(SAMPLE_RATE);
    let longest = signals.iter().map(Vec::len).max().unwrap_or(0);
    let transform = RealTransform::new(longest.max(SAMPLE_RATE as usize));
    let df = rate / transform.length() as f64;
    let frequency: Vec<f64> = (0..=transform.length() / 2).map(|k| k as f64 * df).collect();
    let weights = energy_weights(&frequency, range, Weighting::Z);
    let exposure = |signal: &Vec<f64>| {
        let density = density(&transform.lines(signal));
        let sum: f64 = weights.iter().zip(&density).map(|(w, e)| w * e).sum();
        if radiated > 0.0 {
            sum / (rate * rate * radiated)
        } else {
            0.0
        }
    };
    signals.par_iter().map(exposure).collect()
}

/// Power of a source over time, one value per sample, delayed by a travel time.
fn envelope(histories: &[&PowerHistory], travel: f64, rate: f64, samples: usize) -> Vec<f64> {
    let at = |time: f64| -> f64 {
        let of = |history: &&PowerHistory| {
            let cell = (time - history.start) / history.sample_interval;
            // Cells are centred on their instants.
            let cell = (cell + 0.5).floor();
            if cell < 0.0 {
                0.0
            } else {
                history.power.get(cell as usize).copied().unwrap_or(0.0)
            }
        };
        compensated(histories.iter().map(of)).max(0.0)
    };
    (0..samples).map(|n| at(n as f64 / rate - travel)).collect()
}

/// A compensated sum, in which a part that is subtracted and added again leaves nothing (Neumaier 1974).
fn compensated(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut lost) = (0.0_f64, 0.0_f64);
    for value in values {
        let next = sum + value;
        lost += if sum.abs() >= value.abs() {
            (sum - next) + value
        } else {
            (value - next) + sum
        };
        sum = next;
    }
    sum + lost
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_envelope_is_late_by_the_travel_time() {
        let history = PowerHistory {
            start: 0.0,
            sample_interval: 1e-3,
            power: vec![0.0, 5.0, 0.0],
        };
        let found = envelope(&[&history], 2e-3, 1e4, 60);
        let peak: Vec<usize> = found
            .iter()
            .enumerate()
            .filter(|(_, p)| **p > 0.0)
            .map(|(n, _)| n)
            .collect();
        assert!(peak.first() == Some(&25) && peak.len() == 10, "{peak:?}");
    }

    #[test]
    fn a_part_that_is_taken_away_and_added_again_leaves_the_power_as_it_was() {
        let history = |power: f64| PowerHistory {
            start: 0.0,
            sample_interval: 1e-3,
            power: vec![power; 4],
        };
        let (own, part) = (history(1e-9), history(0.7));
        let found = envelope(&[&own, &part.scaled(-1.0), &part], 0.0, 1e3, 2);
        assert!((found[1] / 1e-9 - 1.0).abs() < 1e-14, "{found:?}");
    }

    #[test]
    fn the_share_of_a_receiver_is_its_exposure_over_the_energy() {
        // A sine of 2 Pa over half a second has an exposure of 1 Pa² s.
        let sample = |n: i32| 2.0 * (2.0 * PI * 1000.0 * f64::from(n) / 48e3).sin();
        let signal: Vec<f64> = (0..24_000).map(sample).collect();
        let found = shares(&[signal], [500.0, 2000.0], 4.0);
        assert!((found[0] / 0.25 - 1.0).abs() < 2e-3, "{found:?}");
    }
}
