//! Exhaust noise from the flow of one cycle.
//!
//! Per sample the opening's jet is expanded to ambient pressure ([`Jet`]); its mixing and shock noise power is spread
//! over frequency by the shape of its own instant and integrated over the record. The unsteady outflow is a monopole.
//! Flow inward radiates nothing here. What a microphone receives beside a jet and above a floor is [`ExhaustNoise::at`],
//! and [`ExhaustNoise::sound_at`] as a signal.

mod cross_check;
mod directivity;
pub(crate) mod error;
mod histogram;
mod history;
mod jet;
mod mixing;
mod monopole;
mod noise;
mod opening;
mod receiver;
mod screech;
mod shock;
mod similarity;
mod sound;

pub use cross_check::{ValveNoise, valve_noise_energy};
pub use directivity::MixingDirectivity;
pub use error::ExhaustError;
pub use history::ExhaustHistory;
pub use jet::Jet;
pub use mixing::{MIXING_RANGE, mixing_power};
pub use monopole::PlenumResonance;
pub use noise::{ExhaustNoise, ExhaustSettings, exhaust_noise};
pub use opening::{FlowHistory, Opening};
pub use receiver::{Floor, Outlet, Received};
pub use screech::{screech_frequency, screech_track};
pub use shock::{shock_peak_frequency, shock_power};
pub use similarity::fine_scale_shape;
pub use sound::Recording;
