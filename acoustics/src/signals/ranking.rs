use std::borrow::Borrow;

use super::{Level, SourceSpectrum, Weighting, energy_level};

/// Default frequency range for the comparison of sources \[Hz\]; a design may set another one.
pub const COMMON_RANGE_HZ: [f64; 2] = [50.0, 10_000.0];

/// Levels of a source over the common range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RankedSource {
    /// Index of the source in the order given.
    pub index: usize,
    /// A-weighted level \[dB re 1 pW s\].
    pub lwa: Level,
    /// Unweighted level \[dB re 1 pW s\].
    pub lw: Level,
    /// Fraction of the A-weighted energy of all sources, 0 to 1; `None` if all are silent.
    pub share: Option<f64>,
}

/// Sources in descending order of level, and their sum.
#[derive(Debug, Clone, PartialEq)]
pub struct Ranking {
    /// The sources in descending order of A-weighted energy; silent ones last, ties in the original order.
    pub sources: Vec<RankedSource>,
    /// A-weighted level of the energy sum over the common range.
    pub total_lwa: Level,
    /// Unweighted level of the energy sum over the common range.
    pub total_lw: Level,
}

/// Ranks sources by their A-weighted energy over a common range.
///
/// Energies add, because the sources are mutually incoherent. Parts that vibrate coherently must be in the same
/// spectrum.
pub fn rank<S: Borrow<SourceSpectrum>>(spectra: &[S], range_hz: [f64; 2]) -> Ranking {
    let energies = |w| -> Vec<f64> { spectra.iter().map(|s| s.borrow().energy(range_hz, w)).collect() };
    let (a, z) = (energies(Weighting::A), energies(Weighting::Z));
    let (a_total, z_total) = (a.iter().sum::<f64>(), z.iter().sum::<f64>());
    let mut order: Vec<usize> = (0..spectra.len()).collect();
    order.sort_by(|&i, &j| a[j].total_cmp(&a[i]));
    let ranked = |index: usize| RankedSource {
        index,
        lwa: energy_level(a[index]),
        lw: energy_level(z[index]),
        share: (a_total > 0.0).then(|| a[index] / a_total),
    };
    Ranking {
        sources: order.into_iter().map(ranked).collect(),
        total_lwa: energy_level(a_total),
        total_lw: energy_level(z_total),
    }
}
