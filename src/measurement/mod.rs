//! Measurements of a tool by EN 12549: the manifest of a test and its recordings.

pub mod error;
pub mod manifest;
pub mod recordings;

pub use error::MeasurementError;
pub use manifest::{Configuration, Manifest, Microphone, Setup, Trigger};
pub use recordings::Shot;
