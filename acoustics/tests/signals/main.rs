//! Spectra, transforms and levels.
#![allow(clippy::unwrap_used)]

mod fourier;
mod levels;
