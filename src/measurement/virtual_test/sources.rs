//! Sound pressure of each source at the microphones of a virtual test, over the whole range of its levels.

use nailnoise_acoustics::levels::{PowerHistory, Weighting};
use nailnoise_acoustics::radiator::FADE_OCTAVES;
use nalgebra::Complex;
use rayon::prelude::*;

use super::noise::under_envelope;
use super::resampling::Resampling;
use crate::measurement::lines::{Bands, OneSecond};
use crate::stages::microphones::{AtMicrophones, SAMPLE_RATE};
use crate::stages::sound::SoundSource;

/// Room after the end of a shot's signals for what filters and travel times delay \[s\].
const TAIL: f64 = 0.05;

/// Octaves below the end of a signal's range over which its directivity is taken.
const DIRECTIVITY_OCTAVES: f64 = 1.0;

/// What makes signals at the microphones of one test.
pub(super) struct Synthesis {
    /// Sampling rate of the recordings \[1/s\].
    pub(super) rate: f64,
    /// Travel time from the device's centre to each microphone \[s\].
    pub(super) travel: Vec<f64>,
    /// Upper end of the levels' range \[Hz\].
    pub(super) top_hz: f64,
}

impl Synthesis {
    /// Pressures of a source at each microphone from the trigger on \[Pa\].
    ///
    /// Up to the end of the range in which the source's pressures are known, these are the run's signals. Above it (beyond the
    /// boundary elements) only the power is known: Gaussian noise of its density under the power history takes over, where the
    /// signals fade. Each microphone receives the share of the power that it receives in the octave below.
    pub(super) fn signals(&self, source: &SoundSource, received: &AtMicrophones, noise: (u64, u64)) -> Vec<Vec<f64>> {
        let known = received.signals.first().map_or(0, Vec::len);
        let old = f64::from(SAMPLE_RATE);
        let samples = ((known as f64 / old + TAIL) * self.rate).ceil() as usize;
        let resampling = Resampling::new((known, old), (samples, self.rate));
        let mut signals: Vec<Vec<f64>> = received
            .signals
            .par_iter()
            .map(|signal| resampling.apply(signal))
            .collect();
        let end = received.range_hz[1];
        if end >= self.top_hz * (1.0 - 1e-9) || source.spectrum.energy([end, self.top_hz], Weighting::Z) <= 0.0 {
            return signals;
        }
        let from = end * 2f64.powf(-DIRECTIVITY_OCTAVES);
        let radiated = source.spectrum.energy([from, end], Weighting::Z);
        let shares = shares(&received.signals, old, [from, end], radiated);
        let high = |(place, signal): (usize, &mut Vec<f64>)| {
            let envelope = envelope(&source.histories, self.travel[place], self.rate, samples);
            let density = |hz: f64| {
                let fading = ((hz / end).log2() / FADE_OCTAVES).clamp(0.0, 1.0);
                let risen = (0.5 * std::f64::consts::PI * fading).sin().powi(2);
                shares[place] * risen * density_at(&source.spectrum.frequency, &source.spectrum.energy_density, hz)
            };
            let added = under_envelope(&envelope, self.rate, density, (noise.0, 64 * noise.1 + place as u64));
            signal.iter_mut().zip(added).for_each(|(p, x)| *p += x);
        };
        signals.par_iter_mut().enumerate().for_each(high);
        signals
    }
}

/// Exposure at each microphone over the energy radiated in the same range \[Pa2 s/J\].
fn shares(signals: &[Vec<f64>], rate: f64, range: [f64; 2], radiated: f64) -> Vec<f64> {
    let transform = OneSecond::new(rate);
    let frequency = transform.frequencies();
    let weights = nailnoise_acoustics::levels::energy_weights(&frequency, range, Weighting::Z);
    let exposure = |signal: &Vec<f64>| {
        let lines: Vec<Complex<f64>> = transform.lines(&signal[..signal.len().min(transform.samples())]);
        let energy: f64 = weights.iter().zip(&lines).map(|(w, x)| w * 2.0 * x.norm_sqr()).sum();
        if radiated > 0.0 { energy / radiated } else { 0.0 }
    };
    signals.par_iter().map(exposure).collect()
}

/// Power of a source over time, one value a sample, delayed by a travel time.
fn envelope(histories: &[PowerHistory], travel: f64, rate: f64, samples: usize) -> Vec<f64> {
    let at = |time: f64| -> f64 {
        let of = |history: &PowerHistory| {
            let cell = (time - history.start) / history.sample_interval;
            // Cells lie around their instants.
            let cell = (cell + 0.5).floor();
            if cell < 0.0 {
                0.0
            } else {
                history.power.get(cell as usize).copied().unwrap_or(0.0).max(0.0)
            }
        };
        histories.iter().map(of).sum()
    };
    (0..samples).map(|n| at(n as f64 / rate - travel)).collect()
}

/// A density between its samples, linear; zero outside.
fn density_at(frequency: &[f64], density: &[f64], hz: f64) -> f64 {
    let right = frequency.partition_point(|f| *f < hz);
    if right == 0 || right >= frequency.len() {
        return 0.0;
    }
    let (low, high) = (frequency[right - 1], frequency[right]);
    let share = (hz - low) / (high - low);
    ((1.0 - share) * density[right - 1] + share * density[right]).max(0.0)
}

/// Densities of the exposure of a source, mean over the microphones \[Pa2 s/Hz\], at the lines of one second.
pub(super) fn mean_density(signals: &[Vec<f64>], transform: &OneSecond) -> Vec<f64> {
    let mut sum = vec![0.0; transform.samples() / 2 + 1];
    let of = |signal: &Vec<f64>| transform.lines(&signal[..signal.len().min(transform.samples())]);
    let all: Vec<Vec<Complex<f64>>> = signals.par_iter().map(of).collect();
    let share = 1.0 / signals.len().max(1) as f64;
    for lines in &all {
        sum.iter_mut()
            .zip(lines)
            .for_each(|(sum, x)| *sum += share * 2.0 * x.norm_sqr());
    }
    sum
}

/// A-weighted energies of a density by band and over the range.
pub(super) fn energies(density: &[f64], bands: &Bands) -> (f64, Vec<f64>) {
    let lines: Vec<Complex<f64>> = density.iter().map(|d| Complex::from((0.5 * d).sqrt())).collect();
    (bands.energy(&lines), bands.band_energies(&lines))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_density_is_linear_between_its_samples_and_zero_outside() {
        let (frequency, density) = ([100.0, 200.0], [1.0, 3.0]);
        assert_eq!(density_at(&frequency, &density, 150.0), 2.0);
        assert_eq!(density_at(&frequency, &density, 50.0), 0.0);
        assert_eq!(density_at(&frequency, &density, 250.0), 0.0);
    }

    #[test]
    fn an_envelope_is_late_by_the_travel_time() {
        let history = PowerHistory {
            start: 0.0,
            sample_interval: 1e-3,
            power: vec![0.0, 5.0, 0.0],
        };
        let found = envelope(&[history], 2e-3, 1e4, 60);
        let peak: Vec<usize> = found
            .iter()
            .enumerate()
            .filter(|(_, p)| **p > 0.0)
            .map(|(n, _)| n)
            .collect();
        assert!(peak.first() == Some(&25) && peak.len() == 10, "{peak:?}");
    }
}
