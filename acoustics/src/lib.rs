//! Levels, radiation of moving surfaces and exhaust noise.
//!
//! Everything ends in a [`levels::SourceSpectrum`]: the energy a source radiates during one shot, per hertz. Surfaces
//! bring quadrature points with modal displacements ([`radiation`]), the exhaust brings its flow ([`exhaust`]). What a
//! microphone hears of each is in [`sound`]; what is drawn at random comes from [`random`].
//! Time factor e^{+j omega t}; spectra are one-sided; SI units throughout.

mod air;
pub mod bem;
mod blocks;
mod error;
pub mod exhaust;
pub mod fourier;
mod interpolation;
pub mod levels;
mod matrix;
pub mod muffler;
mod quadrature;
pub mod radiation;
pub mod random;
pub mod sound;
mod trig;

pub use air::{Air, GAS_CONSTANT, HEAT_RATIO};
pub use error::AcousticsError;
