//! Time-domain response of modal bodies with supports that can lose contact.

mod energy;
mod error;
mod march;
mod model;
mod response;

pub use energy::EnergyHistory;
pub use error::TransientError;
pub use march::respond;
pub use model::{Loads, ModalBody, ModalState, Settings, Start, Support, SupportLaw};
pub use response::{Check, Ending, ModalResponse, Motion, Work};
