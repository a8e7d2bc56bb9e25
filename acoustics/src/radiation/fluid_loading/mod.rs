//! Fluid loading: modes of a structure that interact with the surrounding fluid.
//!
//! The modes of the structure in vacuum are mass-normalised; Omega are their angular frequencies and zeta their damping
//! ratios. With the time factor e^{+j omega t}, the modal velocities q' follow from the modal forces f by
//!
//! ```text
//! [-omega² I + j omega (C + Z(omega)) + Omega²] q = f        C = diag(2 zeta Omega), Z = R + jX symmetric
//! Z_ij = int (phi_i . n) p_j dS                              p_j: pressure on the surface per unit modal velocity
//! ```
//!
//! (Junger & Feit 1986, chapter 9). R causes damping, and X / omega is the added mass of the fluid. [`velocities`]
//! solves the equation at one frequency, and [`resonances`] finds the complex frequencies of free vibration. For
//! time-domain motion with contact that opens, [`WetModes`] freeze Z at each mode's own resonance. If the motion
//! remains linear, [`impedance_correction`] adds the effect of the full Z(omega).

mod damped_transform;
mod error;
mod gmres;
mod impedance;
mod linear;
mod modes;
mod resonances;
mod response;
mod table;
mod wet_modes;

pub use damped_transform::DampedTransform;
pub use error::FluidLoadingError;
pub use impedance::Impedance;
pub use linear::{FrozenModes, ImpedanceCorrection, impedance_correction};
pub use modes::DryModes;
pub use resonances::{Resonance, resonances};
pub use response::{PowerBalance, velocities};
pub use table::ImpedanceTable;
pub use wet_modes::WetModes;
