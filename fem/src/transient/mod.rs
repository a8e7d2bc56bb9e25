//! Time-domain response of modal bodies with supports that can lose contact.

mod contact;
mod energy;
mod error;
mod kernels;
mod march;
mod model;
mod recurrence;
mod response;
mod statics;
mod system;

pub use energy::EnergyHistory;
pub use error::TransientError;
pub use march::respond;
pub use model::{Loads, ModalBody, ModalState, Settings, Start, Support, SupportLaw};
pub use response::{Check, Ending, ModalResponse, Motion, Work};
