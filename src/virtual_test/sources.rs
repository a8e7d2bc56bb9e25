//! Sound pressure of each source at the microphones of a virtual test, over the complete range of its levels.

use nalgebra::Complex;
use rayon::prelude::*;

use super::resampling::Resampling;
use crate::measurement::lines::{Bands, OneSecond};
use crate::stages::microphones::{AtMicrophones, Continuation, SAMPLE_RATE};
use crate::stages::sound::SoundSource;

/// Time after the end of a shot's signals for the delays of filters and propagation \[s\].
const TAIL: f64 = 0.05;

/// Makes signals at the microphones of one test.
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
    /// As far as the source's pressures are known, these are the run's signals. Above that frequency, noise continues
    /// them as in the files of the run. Bands are not scaled to the expected energies, because each shot has its own
    /// draw.
    pub(super) fn signals(&self, source: &SoundSource, received: &AtMicrophones, noise: (u64, u64)) -> Vec<Vec<f64>> {
        // The operator's ear, which follows the microphones, has no channel.
        let known = received.signals.get(..self.travel.len()).unwrap_or_default();
        let length = known.first().map_or(0, Vec::len);
        let old = f64::from(SAMPLE_RATE);
        let samples = ((length as f64 / old + TAIL) * self.rate).ceil() as usize;
        let resampling = Resampling::new((length, old), (samples, self.rate));
        let mut signals: Vec<Vec<f64>> = known.par_iter().map(|signal| resampling.apply(signal)).collect();
        let parts = [source];
        if let Some(continuation) = Continuation::new(&parts, known, [received.range_hz[1], self.top_hz]) {
            let added = continuation.noise(&self.travel, (self.rate, samples), noise);
            let samples = signals.iter_mut().flatten().zip(added.iter().flatten());
            samples.for_each(|(p, x)| *p += x);
        }
        signals
    }
}

/// Densities of the exposure of a source, averaged over the microphones \[Pa2 s/Hz\], at the lines of one second.
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
