use super::bands::Band;
use super::{BandLevel, SourceSpectrum, Weighting, bands_of, energy_level, energy_weights};

/// Order n of the low-pass prototype; the band-pass has 2 n poles. Three is the lowest order that meets class 1.
const ORDER: i32 = 3;

/// The band filter of a class 1 instrument: Butterworth (IEC 61260-1:2014).
///
/// ```text
/// |H|^2 = 1 / (1 + x^{2n})      x = (f/f_m - f_m/f) / (f_2/f_m - f_m/f_2)      n = 3
/// ```
///
/// Adjacent filters overlap, so the sum of the bands slightly exceeds the total. Use it for comparison with an
/// instrument, and [`SourceSpectrum::band_levels`] for everything else.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BandFilter {
    /// The band.
    pub band: Band,
}

impl BandFilter {
    /// The factor |H|² on energy at the frequency `hz`.
    pub fn energy_factor(&self, hz: f64) -> f64 {
        let detuning = |ratio: f64| ratio - 1.0 / ratio;
        let x = detuning(hz / self.band.hz) / detuning(self.band.high / self.band.hz);
        1.0 / (1.0 + x.powi(2 * ORDER))
    }

    /// Attenuation -10 lg |H|² at the frequency `hz` \[dB\]: the relative attenuation of the standard.
    pub fn attenuation_db(&self, hz: f64) -> f64 {
        -10.0 * self.energy_factor(hz).log10()
    }
}

impl SourceSpectrum {
    /// Levels measured by class 1 filters in the bands of a range (see [`bands_of`]), for the part of the spectrum
    /// inside it.
    ///
    /// The filter is evaluated at the spectrum's frequencies, which must be dense within the narrowest band.
    pub fn filter_levels(&self, range_hz: [f64; 2]) -> Vec<BandLevel> {
        let weights = |weighting| energy_weights(&self.frequency, range_hz, weighting);
        let (z, a) = (weights(Weighting::Z), weights(Weighting::A));
        let level_of = |band: Band| {
            let filter = BandFilter { band };
            let sum = |weights: &[f64]| -> f64 {
                let bins = self.frequency.iter().zip(&self.energy_density).zip(weights);
                bins.map(|((&hz, e), w)| filter.energy_factor(hz) * e * w).sum()
            };
            let (energy, a_energy) = (sum(&z), sum(&a));
            BandLevel {
                band,
                energy,
                lw: energy_level(energy),
                a_energy,
                lwa: energy_level(a_energy),
            }
        };
        bands_of(range_hz).into_iter().map(level_of).collect()
    }
}
