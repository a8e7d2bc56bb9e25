//! Time-domain response of modal bodies on supports that can lose contact.
//!
//! [`respond`] takes one or two bodies as plain arrays (frequencies, damping ratios, participation of loads and
//! supports), springs and dashpots between them or to the ground, and loads on the time grid of the cycle's record.
//! Each mode responds exactly to forces that are linear over a step (Duhamel's integral in closed form), so only the
//! contact limits the step.
//!
//! * Supports act at points, each along one arbitrary direction, with separate dashpots. The dashpots of sand are never
//!   folded into modal damping.
//! * The support forces at the end of a step depend on the motion there and vice versa: a linear complementarity
//!   problem of the size of the supports, which is solved exactly in every step. Bonded supports are treated in the
//!   same way.
//! * A contact force is linear between samples. For the contact, this is the linear acceleration method: second order
//!   while a contact lasts and for elastic impacts, first order when a dashpot meets a moving surface, because its
//!   force is discontinuous.
//! * Every run checks two balances. The energy balance is: work of the loads = change of kinetic, strain and contact
//!   energy + energy dissipated + energy lost in contact. The momentum balance is that of the rigid modes. Both use
//!   sums that the time integration itself does not use.
//!
//! The result stores forces instead of motions; [`ModalResponse::modal`] reruns the recurrence for the requested modes.
//! Linear corrections of the motion in the frequency domain ([`AddedMotion`]) are included.
//!
//! ```
//! use nailnoise_fem::vibration::{Loads, ModalBody, Motion, Settings, Support, SupportLaw, respond};
//! use nalgebra::DMatrix;
//!
//! // A mass of 4 kg on one spring, at rest under its weight.
//! let mass = ModalBody {
//!     name: "mass".into(),
//!     omega: vec![0.0],
//!     zeta: vec![0.0],
//!     loads: DMatrix::from_element(1, 1, 0.5),
//!     supports: DMatrix::from_element(1, 1, 0.5),
//! };
//! let spring = Support { stiffness: 1e6, damping: 200.0, gap: 0.0, law: SupportLaw::Unilateral };
//! let settings = Settings { duration: 0.01, ..Settings::default() };
//! let response = respond(&[mass], &[spring], &Loads::constant(&[39.24]), &settings)?;
//! assert!((response.contact_forces[(0, 0)] - 39.24).abs() < 1e-9);
//! let acceleration = response.modal(0, 0..1, Motion::Acceleration)?;
//! assert!(acceleration.amax() < 1e-9);
//! # Ok::<(), nailnoise_fem::vibration::TransientError>(())
//! ```

mod added;
mod contact;
mod driven;
mod energy;
mod error;
mod kernels;
mod model;
mod recurrence;
mod response;
mod statics;
pub mod supports;
mod system;
mod time_integration;

pub use added::AddedMotion;
pub use driven::Driven;
pub use energy::EnergyHistory;
pub use error::TransientError;
pub use model::{Loads, ModalBody, ModalState, Motion, Settings, Start, Support, SupportLaw};
pub use response::{Ending, ModalResponse, Work};
pub use time_integration::respond;
