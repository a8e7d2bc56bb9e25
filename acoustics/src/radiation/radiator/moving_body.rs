//! A body in motion, as input of a radiator.

use super::fluid_loading::{FluidLoads, Loading};
use crate::radiation::ModalSpectra;

/// A body in motion.
#[derive(Debug, Clone, Copy)]
pub struct MovingBody<'a> {
    /// Its name.
    pub name: &'static str,
    /// Angular frequencies of its modes, then of its static corrections \[rad/s\].
    pub omega: &'a [f64],
    /// Number of these that are modes.
    pub modes: usize,
    /// Damping ratio of its structure \[-\].
    pub zeta: f64,
    /// Effects of the fluid on each of them, if known.
    pub loads: Option<&'a FluidLoads>,
    /// The part of these effects that acts on the motion.
    pub acts: Loading,
    /// Fourier transforms of the modal accelerations.
    pub spectra: &'a ModalSpectra,
}
