//! Radiators other than boundary elements, levels, spectra and sounds.
#![allow(clippy::unwrap_used)]

mod common;

mod air;
mod compact;
mod energy;
mod fourier;
mod intervals;
mod levels;
mod parts;
mod rayleigh;
mod receivers;
mod sampling;
mod sand;
mod skin;
