//! Time-domain response of modal bodies with supports that can lose contact.
//!
//! [`respond`] takes one or two bodies as plain arrays (frequencies, damping ratios, participation of loads and
//! supports), springs and dashpots between them or to the ground, and loads on the grid of the cycle's record. Each
//! mode follows forces that are linear over a step exactly (Duhamel's integral in closed form), so nothing but the
//! contact limits the step:
//!
//! * Supports act at points, each along any one direction, with separate dashpots. Those of sand are never folded into
//!   modal damping.
//! * The support forces at the end of a step depend on the motion there, which depends on them: a linear
//!   complementarity problem of the size of the supports, solved exactly in every step. Bonded supports take the same
//!   path.
//! * Between samples a contact force is linear. This is the linear acceleration method for the contact only: of order
//!   two while a contact lasts and for elastic impacts, of order one where a dashpot meets a moving surface, whose
//!   force jumps.
//! * Every run closes two balances. The energy balance is work of the loads = change of kinetic, strain and contact
//!   energy + dissipated + lost in contact. The momentum balance is that of the rigid modes. Both use sums that the
//!   march itself does not use.
//!
//! The result stores forces, not motions: [`ModalResponse::modal`] runs the recurrence again for the requested modes. A
//! correction in the frequency domain of a linear motion ([`AddedMotion`]) is included.
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
