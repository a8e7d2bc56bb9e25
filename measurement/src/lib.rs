#![doc = include_str!("../README.md")]

pub mod alignment;
pub mod arrangement;
pub mod error;
pub mod lines;
pub mod manifest;
pub mod markers;
pub mod processing;
pub mod recordings;
pub mod repeats;
pub mod result;
pub mod subtraction;
pub mod wrapping;

pub use error::MeasurementError;
pub use manifest::{Manifest, Microphone, Setup, Trigger};
pub use recordings::Shot;
