//! Signals and levels: Fourier and chirp transforms, filters, interpolation over frequency, energy spectra, bands,
//! weightings, single-event levels and the ranking of sources.

mod bands;
mod chirp;
pub(crate) mod error;
mod event;
mod filter;
pub mod fourier;
mod history;
pub(crate) mod interpolation;
mod levels;
pub mod loudness;
mod power_signals;
mod ranking;
mod spectrum;
mod weighting;

pub use bands::{Band, THIRD_OCTAVES, band_containing, bands_of, octaves, third_octaves};
pub use chirp::ChirpTransform;
pub use error::LevelsError;
pub use event::{REFERENCE_PRESSURE, exposure_level, peak_level};
pub use filter::BandFilter;
pub use history::{IntervalLevels, PowerHistory};
pub use levels::{Level, REFERENCE_ENERGY, SILENCE, energy_level, level_energy};
pub use power_signals::{PowerSignals, SignalAnalysis};
pub use ranking::{COMMON_RANGE_HZ, RankedSource, Ranking, rank};
pub use spectrum::{BandLevel, Contribution, SourceSpectrum, energy_weights};
pub use weighting::Weighting;
