//! Modes of vibration: block Lanczos, refinement, Sturm count, cost estimate and comparison with measured modes.

mod assurance;
mod basis;
mod columns;
mod cost;
mod dense;
mod eigenpairs;
mod lanczos;
mod modes;

pub use assurance::{Correlation, ModePair, Pairing, correlate};
pub use basis::{ModalBasis, ModalSettings, ModalWork, Sturm};
pub use cost::{ModalCost, ShortestWave, modes_below, wall_thicknesses};
pub use modes::{Progress, modes};
