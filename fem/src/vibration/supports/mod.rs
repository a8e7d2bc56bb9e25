//! Supports of bodies: contact grids, contact with a table, sand.

mod grid;
mod sand;

pub use grid::{ContactGrid, GridRule};
pub use sand::{
    FoundationStiffness, RectangularBase, Sand, SandError, sand_shear_modulus_angular, sand_shear_modulus_round,
};

/// Dashpot per area [Pa s/m] of a contact layer of stiffness k'' [Pa/m] with loss factor eta at the frequency f:
///
///   c'' = eta k''/(2 pi f)
pub fn contact_dashpot(stiffness: f64, loss_ratio: f64, frequency: f64) -> f64 {
    loss_ratio * stiffness / (std::f64::consts::TAU * frequency)
}
