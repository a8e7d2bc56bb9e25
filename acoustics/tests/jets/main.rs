//! The exhaust: jets and fittings.
#![allow(clippy::unwrap_used)]

mod fitting;
mod jet_measurements;
mod noise;
mod receiver;
mod scaling;
mod valve;
