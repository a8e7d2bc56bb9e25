//! The measurement side: wrapping tests of EN 12549, their recordings and levels, and virtual ones of a design.
//!
//! A [`Manifest`] names the recordings of a test. [`process`](processing::process) takes its shots ([`Shot`]), wherever they come
//! from, to a [`MeasurementResult`](result::MeasurementResult).

pub mod alignment;
pub mod arrangement;
pub mod comparison;
pub mod error;
pub mod lines;
pub mod manifest;
pub mod markers;
pub mod processing;
pub mod recordings;
pub mod repeats;
pub mod result;
pub mod subtraction;
pub mod virtual_test;
pub mod wrapping;

pub use error::MeasurementError;
pub use manifest::{Manifest, Microphone, Setup, Trigger};
pub use recordings::Shot;
