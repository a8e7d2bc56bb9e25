//! Energies of signals in the one-third-octave bands of a range.

use nailnoise_acoustics::signals::fourier::RealTransform;
use nailnoise_acoustics::signals::{Band, Weighting, band_containing, energy_weights};
use nalgebra::Complex;

/// The bands of a range \[Hz\]; the first and the last are cut at its ends.
pub(super) fn bands(range: [f64; 2]) -> Vec<[f64; 2]> {
    let inside = (band_containing(range[0]).index..)
        .map(Band::new)
        .take_while(|band| band.low < range[1]);
    inside
        .map(|band| [band.low.max(range[0]), band.high.min(range[1])])
        .collect()
}

/// The parts of bands inside a range; bands outside have zero width.
pub(super) fn within(bands: &[[f64; 2]], [low, high]: [f64; 2]) -> Vec<[f64; 2]> {
    let cut = |band: &[f64; 2]| band.map(|edge| edge.clamp(low, high.max(low)));
    bands.iter().map(cut).collect()
}

/// A-weighted and unweighted energy of a density in each band: \[A, Z\].
pub(super) fn integrals(frequency: &[f64], density: &[f64], bands: &[[f64; 2]]) -> Vec<[f64; 2]> {
    Integration::new(frequency, bands).energies(density)
}

/// Integrates densities on a fixed frequency grid over bands, with and without A-weighting.
pub(super) struct Integration {
    /// Index of the first frequency of each band, and the weights from there on.
    bands: Vec<(usize, Vec<[f64; 2]>)>,
}

impl Integration {
    /// Weights for `bands` \[Hz\]; those with zero width have no energy.
    pub(super) fn new(frequency: &[f64], bands: &[[f64; 2]]) -> Self {
        let of_band = |&[low, high]: &[f64; 2]| {
            // One frequency beyond each end, whose hat function extends into the band.
            let first = frequency.partition_point(|hz| *hz <= low).saturating_sub(1);
            let end = (frequency.partition_point(|hz| *hz < high) + 1).min(frequency.len());
            let own = frequency.get(first..end).unwrap_or_default();
            let [a, z] = [Weighting::A, Weighting::Z].map(|weighting| energy_weights(own, [low, high], weighting));
            (first, a.into_iter().zip(z).map(|(a, z)| [a, z]).collect())
        };
        Self {
            bands: bands.iter().map(of_band).collect(),
        }
    }

    /// Energies \[A, Z\] of a density in each band.
    pub(super) fn energies(&self, density: &[f64]) -> Vec<[f64; 2]> {
        let of_band = |(first, weights): &(usize, Vec<[f64; 2]>)| {
            let pairs = weights.iter().zip(density.iter().skip(*first));
            pairs.fold([0.0; 2], |[a, z], (w, e)| [a + w[0] * e, z + w[1] * e])
        };
        self.bands.iter().map(of_band).collect()
    }
}

/// Spectra of signals with the same length, padded to at least four times that length. With lines this close, the
/// squared spectrum of a record is smooth, and samples that a filter shifts past one end do not return at the other.
pub(super) struct Spectra {
    rate: f64,
    transform: RealTransform,
    /// Frequencies of the lines \[Hz\].
    pub(super) frequency: Vec<f64>,
}

impl Spectra {
    /// Spectra of signals with up to `samples` at `rate` \[1/s\].
    pub(super) fn new(samples: usize, rate: f64) -> Self {
        let length = (4 * samples.max(8)).next_power_of_two();
        Self {
            rate,
            transform: RealTransform::new(length),
            frequency: (0..=length / 2).map(|k| k as f64 * rate / length as f64).collect(),
        }
    }

    /// X(f) = dt sum x e^(-j 2 pi f t) \[unit s\].
    pub(super) fn lines(&self, signal: &[f64]) -> Vec<Complex<f64>> {
        let mut lines = self.transform.lines(signal);
        lines.iter_mut().for_each(|x| *x /= self.rate);
        lines
    }

    /// The first `samples` of the signal with these lines.
    pub(super) fn signal(&self, lines: &[Complex<f64>], samples: usize) -> Vec<f64> {
        let mut signal = self.transform.signal(lines.iter().map(|x| x * self.rate).collect());
        signal.truncate(samples);
        signal
    }
}

/// One-sided energy density of lines, 2 |X|².
pub(super) fn density(lines: &[Complex<f64>]) -> Vec<f64> {
    lines.iter().map(|x| 2.0 * x.norm_sqr()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_cover_their_range_without_gaps() {
        let all = bands([50.0, 10_000.0]);
        assert_eq!((all[0][0], all[all.len() - 1][1], all.len()), (50.0, 10_000.0, 24));
        assert!(all.windows(2).all(|pair| pair[0][1] == pair[1][0]));
    }

    #[test]
    fn the_energies_of_bands_sum_to_that_of_a_signal_inside_them() {
        let rate = 48_000.0;
        let sample = |n: i32| {
            let t = f64::from(n) / rate - 0.05;
            (-(t / 0.01).powi(2)).exp() * (2.0 * std::f64::consts::PI * 900.0 * t).cos()
        };
        let signal: Vec<f64> = (0..4800).map(sample).collect();
        let spectra = Spectra::new(signal.len(), rate);
        let found = integrals(
            &spectra.frequency,
            &density(&spectra.lines(&signal)),
            &bands([50.0, 10_000.0]),
        );
        let exposure: f64 = signal.iter().map(|p| p * p / rate).sum();
        let sum: f64 = found.iter().map(|[_, z]| z).sum();
        assert!((sum / exposure - 1.0).abs() < 1e-6, "{sum} {exposure}");
    }
}
