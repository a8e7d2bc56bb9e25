//! Energies of levels and levels of energies.

/// Energy of a level \[dB\] relative to its reference; zero for a silent source.
pub(crate) fn energy(level: Option<f64>) -> f64 {
    level.map_or(0.0, |level| 10f64.powf(0.1 * level))
}

/// The level of the sum of the energies of levels \[dB\].
pub(crate) fn energy_sum(levels: impl IntoIterator<Item = f64>) -> f64 {
    10.0 * levels.into_iter().map(|level| energy(Some(level))).sum::<f64>().log10()
}
