//! Modes and transient response of solid bodies by finite elements.
//!
//! A mesh with a [`Material`] for each part and [`Constraints`] assembles to a [`System`] K, M; [`modes`] solves
//! K phi = lambda M phi for all modes below a frequency and proves by a Sturm count that none is missing.
#![forbid(unsafe_code)]

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

mod assembly;
mod assurance;
mod attachments;
mod columns;
mod constraints;
mod cost;
mod dense;
mod eigenpairs;
mod element;
mod error;
mod factor;
mod lanczos;
mod layout;
mod load_vector;
mod material;
mod modal;
mod numeric;
mod order;
mod panels;
mod random;
mod reduction;
mod rows;
mod solve;
mod sparse;
mod stress;
mod subtrees;
pub mod supports;
mod symmetry;
pub mod transient;

pub use assembly::{Equations, System, assemble, assemble_in_order, assemble_with, elimination_order};
pub use assurance::{Correlation, ModePair, Pairing, correlate};
pub use attachments::{Attachments, Coupling, GroundSpring, LumpedMass, Place, Tie};
pub use constraints::Constraints;
pub use cost::{ModalCost, ShortestWave, modes_below, wall_thicknesses};
pub use error::FemError;
pub use load_vector::{LoadVector, Rectangle};
pub use material::{Material, Orthotropic};
pub use modal::{ModalBasis, ModalSettings, ModalWork, Sturm};
pub use solve::{Progress, modes};
pub use stress::stress_at;
pub use symmetry::mirror_planes;
