//! The exhaust: jets, fittings, mufflers.
#![allow(clippy::unwrap_used)]

mod fitting;
mod jet_measurements;
mod muffler;
mod noise;
mod receiver;
mod scaling;
mod valve;
