use super::{BandLevel, Level, SourceSpectrum, Weighting, energy_level};
use serde::Serialize;

/// Range in which sources are compared unless the design says otherwise \[Hz\].
pub const COMMON_RANGE_HZ: [f64; 2] = [50.0, 10_000.0];

/// A source's place among the others.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RankedSource {
    /// Name of the source.
    pub source: String,
    /// How its energy was found.
    pub method: String,
    /// A-weighted level over the common range \[dB re 1 pW s\].
    pub lwa: Level,
    /// Unweighted level over the common range \[dB re 1 pW s\].
    pub lw: Level,
    /// Its share of the A-weighted energy of all sources, 0 to 1; none when all are silent.
    pub share: Option<f64>,
    /// Range over which the source was computed \[Hz\].
    pub range_hz: [f64; 2],
    /// A-weighted level over its own range \[dB re 1 pW s\].
    pub own_lwa: Level,
    /// Bands over its own range.
    pub bands: Vec<BandLevel>,
}

/// Sources, loudest first, and their sum.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Ranking {
    /// The common range \[Hz\].
    pub range_hz: [f64; 2],
    /// The sources by falling A-weighted energy; silent ones last, ties in the order given.
    pub sources: Vec<RankedSource>,
    /// A-weighted level of the energy sum over the common range.
    pub total_lwa: Level,
    /// Unweighted level of the energy sum over the common range.
    pub total_lw: Level,
}

/// Ranks sources by their A-weighted energy over one common range.
///
/// Energies add: the sources are incoherent by their mechanisms. Parts that move coherently belong into one spectrum.
pub fn rank(spectra: &[SourceSpectrum], range_hz: [f64; 2]) -> Ranking {
    let energies = |w| spectra.iter().map(|s| s.energy(range_hz, w)).collect::<Vec<f64>>();
    let (a, z) = (energies(Weighting::A), energies(Weighting::Z));
    let (a_total, z_total) = (a.iter().sum::<f64>(), z.iter().sum::<f64>());
    let mut order: Vec<usize> = (0..spectra.len()).collect();
    order.sort_by(|&i, &j| a[j].total_cmp(&a[i]));
    let ranked = |i: usize| RankedSource {
        source: spectra[i].source.clone(),
        method: spectra[i].method.clone(),
        lwa: energy_level(a[i]),
        lw: energy_level(z[i]),
        share: (a_total > 0.0).then(|| a[i] / a_total),
        range_hz: spectra[i].range_hz,
        own_lwa: spectra[i].level(spectra[i].range_hz, Weighting::A),
        bands: spectra[i].band_levels(spectra[i].range_hz),
    };
    Ranking {
        range_hz,
        sources: order.into_iter().map(ranked).collect(),
        total_lwa: energy_level(a_total),
        total_lw: energy_level(z_total),
    }
}
