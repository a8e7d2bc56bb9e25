//! Levels, radiation of moving surfaces, and exhaust noise.
//!
//! Each source yields a [`signals::SourceSpectrum`]: the energy radiated during one shot, per hertz. Surfaces need
//! quadrature points with modal displacements ([`radiation`]) or a closed mesh ([`bem`]); the exhaust needs its flow
//! ([`jets`]). [`radiation::sound`] gives the pressures at microphones. Time factor e^{+j omega t}; spectra are
//! one-sided; SI units throughout.
//!
//! The equivalent radiated power of a piston that oscillates at 1 kHz with an acceleration of 1 m/s²:
//!
//! ```
//! use nailnoise_acoustics::Air;
//! use nailnoise_acoustics::radiation::{Erp, ModalRadiation, RadiatingSurface};
//! use nalgebra::{Complex, DMatrix, Point3, Vector3};
//!
//! let (point, normal, area) = (Point3::origin(), Vector3::z(), 0.01);
//! let (patches, shape) = (vec!["piston".to_owned()], DMatrix::from_element(1, 1, 1.0));
//! let surface = RadiatingSurface::new(vec![point], vec![normal], vec![area], vec![0], patches, shape)?;
//! let air = Air::default();
//! let erp = Erp::new(&surface, &air);
//! let power = erp.energy_forms(&[1000.0], &DMatrix::from_element(1, 1, Complex::from(1.0)))[(0, 0)];
//! let omega = 2.0 * std::f64::consts::PI * 1000.0;
//! assert!((power / (air.impedance() * area / omega.powi(2)) - 1.0).abs() < 1e-6);
//! # Ok::<(), nailnoise_acoustics::AcousticsError>(())
//! ```

mod air;
pub mod bem;
mod blocks;
mod checks;
mod error;
pub mod jets;
mod matrix;
pub mod muffler;
mod porous;
pub mod radiation;
pub mod random;
pub mod signals;
mod trig;

pub use air::{Air, GAS_CONSTANT, HEAT_RATIO};
pub use checks::{InputError, ReceiverError};
pub use error::AcousticsError;
pub use porous::{Frame, LayerTransfer, PorousLayer};
pub use signals::interpolation::SamplingError;
