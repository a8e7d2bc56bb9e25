//! The measurement side: a wrapping test of EN 12549 from its recordings to levels of the sources, and virtual ones of a design.
//!
//! [`Manifest`](manifest::Manifest) reads the recordings of a test. [`process`](processing::process) takes its shots
//! ([`Shot`](shot::Shot)), wherever they come from, to a [`MeasurementResult`](result::MeasurementResult).

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
pub mod shot;
pub mod subtraction;
pub mod virtual_test;
pub mod wrapping;
