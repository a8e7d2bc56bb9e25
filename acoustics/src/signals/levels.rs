//! Energy spectra, bands, frequency weightings, single-event levels and the ranking of sources.
//!
//! A source is described by its one-sided energy spectral density E(f) \[J/Hz\]; all levels follow from integrals of E.

/// Reference sound energy: 1 pW over 1 s \[J\].
pub const REFERENCE_ENERGY: f64 = 1e-12;

/// Energy below which a source counts as silent \[J\]: k_B T at 20 °C, the thermal energy of a single degree of freedom
/// of the air, 84 dB below the reference. Rounding errors of a computed zero are far smaller, and any audible sound is
/// far larger.
pub const SILENCE: f64 = 1.380_649e-23 * 293.15;

/// A level in decibels; none for a source that radiates nothing.
pub type Level = Option<f64>;

/// Single-event sound power level of a sound energy \[J\]; `None` for [silence](SILENCE).
///
/// ```text
/// L_W,1s = 10 lg(E / (1 pW x 1 s))
/// ```
pub fn energy_level(energy: f64) -> Level {
    (energy > SILENCE).then(|| 10.0 * (energy / REFERENCE_ENERGY).log10())
}

/// Sound energy \[J\] of a single-event level; the inverse of [`energy_level`].
pub fn level_energy(level: Level) -> f64 {
    level.map_or(0.0, |db| REFERENCE_ENERGY * 10f64.powf(db / 10.0))
}
