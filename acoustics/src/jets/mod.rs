//! Exhaust noise from the air flow of one cycle.
//!
//! For each sample, the jet of the opening is expanded to ambient pressure ([`Jet`]). The power of its mixing and shock
//! noise is distributed over frequency by the spectral shape at that instant, and integrated over the record. The
//! unsteady outflow is a monopole. Inflow radiates no sound in this model. [`ExhaustNoise::at`] gives the sound
//! exposure at a microphone near a jet and above a floor, and [`ExhaustNoise::sound_at`] the signal there.

mod directivity;
pub(crate) mod error;
mod fitting;
mod histogram;
mod history;
mod jet;
mod mixing;
mod monopole;
mod noise;
mod open_end;
mod opening;
mod receiver;
mod screech;
mod shock;
mod similarity;
mod sound;
mod valve;

pub use directivity::MixingDirectivity;
pub use error::ExhaustError;
pub use fitting::{FilledFitting, PipeFitting};
pub use history::ExhaustHistory;
pub use jet::Jet;
pub use mixing::{MIXING_RANGE, mixing_power};
pub use monopole::PlenumResonance;
pub use noise::{ExhaustNoise, ExhaustSettings, UNSTEADY_FLOW, exhaust_noise};
pub use open_end::OpenEnd;
pub use opening::{FlowHistory, Opening};
pub use receiver::{Floor, Outlet, ReceivedNoise};
pub use screech::{screech_frequency, screech_track};
pub use shock::{shock_peak_frequency, shock_power};
pub use similarity::fine_scale_shape;
pub use sound::Recording;
pub use valve::{FlowRegime, ValveFlow, ValveNoise, ValveSound};
