use std::borrow::Borrow;

use super::{Level, SourceSpectrum, Weighting, energy_level};

/// Range in which sources are compared unless the design says otherwise \[Hz\].
pub const COMMON_RANGE_HZ: [f64; 2] = [50.0, 10_000.0];

/// A source's place among the others, over the common range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Index of the source in the order given.
    pub index: usize,
    /// A-weighted level \[dB re 1 pW s\].
    pub lwa: Level,
    /// Unweighted level \[dB re 1 pW s\].
    pub lw: Level,
    /// Its share of the A-weighted energy of all sources, 0 to 1; none when all are silent.
    pub share: Option<f64>,
}

/// Sources, loudest first, and their sum.
#[derive(Debug, Clone, PartialEq)]
pub struct Ranking {
    /// The sources by falling A-weighted energy; silent ones last, ties in the order given.
    pub places: Vec<Place>,
    /// A-weighted level of the energy sum over the common range.
    pub total_lwa: Level,
    /// Unweighted level of the energy sum over the common range.
    pub total_lw: Level,
}

/// Ranks sources by their A-weighted energy over one common range.
///
/// Energies add: the sources are incoherent by their mechanisms. Parts that move coherently belong into one spectrum.
pub fn rank<S: Borrow<SourceSpectrum>>(spectra: &[S], range_hz: [f64; 2]) -> Ranking {
    let energies = |w| -> Vec<f64> { spectra.iter().map(|s| s.borrow().energy(range_hz, w)).collect() };
    let (a, z) = (energies(Weighting::A), energies(Weighting::Z));
    let (a_total, z_total) = (a.iter().sum::<f64>(), z.iter().sum::<f64>());
    let mut order: Vec<usize> = (0..spectra.len()).collect();
    order.sort_by(|&i, &j| a[j].total_cmp(&a[i]));
    let place = |index: usize| Place {
        index,
        lwa: energy_level(a[index]),
        lw: energy_level(z[index]),
        share: (a_total > 0.0).then(|| a[index] / a_total),
    };
    Ranking {
        places: order.into_iter().map(place).collect(),
        total_lwa: energy_level(a_total),
        total_lw: energy_level(z_total),
    }
}
