//! Modes and transient response of solid bodies by finite elements.
//!
//! A mesh with a [`Material`] for each part and [`Constraints`] is assembled to a [`System`] of K and M. [`modes`]
//! solves K phi = lambda M phi for all modes below a frequency and proves by a Sturm count that none is missing.
#![forbid(unsafe_code)]

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

mod assembly;
mod eigen;
mod error;
mod factor;
mod material;
mod random;
mod reduction;
mod symmetry;
pub mod vibration;

pub use assembly::{
    Equations, LoadVector, Rectangle, System, assemble, assemble_in_order, assemble_with, elimination_order,
    mirror_planes, stress_at,
};
pub use eigen::{
    Correlation, ModalBasis, ModalCost, ModalSettings, ModalWork, ModePair, Pairing, Progress, ShortestWave, Sturm,
    correlate, modes, modes_below, wall_thicknesses,
};
pub use error::FemError;
pub use material::{Material, Orthotropic};
pub use reduction::{Attachments, Constraints, Coupling, GroundSpring, LumpedMass, Place, Tie};
