//! A body in motion, as a radiator takes it.

use super::fluid_loading::{FluidLoads, Loading};
use crate::radiation::ModalSpectra;

/// A body in motion.
#[derive(Debug, Clone, Copy)]
pub struct MovingBody<'a> {
    /// Its name.
    pub name: &'static str,
    /// Angular frequencies of its modes, then of its static corrections \[rad/s\].
    pub omega: &'a [f64],
    /// How many of these are modes.
    pub modes: usize,
    /// Damping ratio of its structure \[-\].
    pub zeta: f64,
    /// The effects of the fluid on each, if known.
    pub loads: Option<&'a FluidLoads>,
    /// The part of them that acts on its motion.
    pub acts: Loading,
    /// Fourier transforms of the modal accelerations.
    pub spectra: &'a ModalSpectra,
}
