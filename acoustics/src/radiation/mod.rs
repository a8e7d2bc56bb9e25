//! Sound power of moving surfaces.
//!
//! Modal accelerations A(f) and a modal radiation resistance R(f) give the energy spectrum.
//!
//! ```text
//! E(f) = 2 V^H R V,   V = A / (j omega)      =>      E(f) = 2 A^H (R / omega^2) A
//! ```
//!
//! R / omega² is sampled and interpolated, because it remains finite at f = 0.

mod averaged;
pub mod boundary_elements;
mod compact;
mod covariance;
mod energy;
mod erp;
pub(crate) mod error;
pub mod fluid_loading;
pub mod flush_with_sand;
mod hermitian_root;
mod operator;
mod oscillating_pipe;
mod packed;
mod part;
mod products;
pub mod radiator;
mod resistance;
mod sampled;
pub mod sound;
pub mod sound_fields;
mod spectra;
mod sphere;
mod surface;

pub(crate) use averaged::AveragedResistance;
pub use compact::{CompactErp, sphere_efficiency};
pub use covariance::{LowRank, quadratic_forms};
pub use energy::{mode_energies, radiated_energy, radiated_signals};
pub use erp::Erp;
pub use error::RadiationError;
pub use operator::ModalRadiation;
pub use oscillating_pipe::{OscillatingPipe, PipeWall};
pub(crate) use packed::PackedHermitian;
pub use part::PartOfSurface;
pub use resistance::Resistance;
pub use sampled::{SampledRadiation, Sampling};
pub use spectra::ModalSpectra;
pub use sphere::{rigid_body_energy, rigid_body_signals};
pub(crate) use surface::FACE_POINTS;
pub use surface::RadiatingSurface;
