//! Measurements of a tool: conditions, instruments and readings in SI units, independent of their file.

use std::collections::BTreeMap;
use std::path::PathBuf;

use nailnoise_calibration::likelihood::Reading;

use super::level_quantities::LevelQuantity;
use super::quantities::Quantity;
use crate::design::{Assignment, Design};

/// Part of the variance of the model's error that all readings of a family have in common.
pub(super) const COMMON: f64 = 0.5;

/// The user's measurements.
#[derive(Debug, Clone, Default)]
pub(super) struct Measurements {
    /// Keys that were measured directly.
    pub(super) direct: Vec<Direct>,
    /// Names of the instruments.
    pub(super) instruments: Vec<String>,
    /// Conditions under which shots were made.
    pub(super) conditions: Vec<Condition>,
    /// The readings of the cycle.
    pub(super) data: Vec<Measured>,
    /// The readings of sound and vibration.
    pub(super) levels: Vec<MeasuredLevel>,
    /// Correlations of their errors.
    pub(super) correlations: Vec<Correlation>,
    /// Minutes that a further measurement takes, by the name of its quantity, in place of the usual ones.
    pub(super) effort: BTreeMap<String, f64>,
    /// Values and ranges in the design of the measured keys that the cycle does not use.
    pub(super) narrowed: Vec<Assignment>,
    /// Other files that contain readings.
    pub(super) files: Vec<PathBuf>,
    /// Assumptions about readings that the user should know.
    pub(super) notes: Vec<String>,
}

/// A key whose value was measured.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Direct {
    pub(super) key: String,
    /// Its value in SI units.
    pub(super) value: f64,
    /// Standard deviation of the value.
    pub(super) deviation: f64,
}

/// Shots with the same settings.
#[derive(Debug, Clone)]
pub(super) struct Condition {
    pub(super) name: String,
    /// The design with the values that were set.
    pub(super) design: Design,
    /// Keys that were set.
    pub(super) set: Vec<String>,
    /// Settings that were read from an instrument.
    pub(super) shown: Vec<Shown>,
    /// Outcomes that a shot may have had; empty if none was noted.
    pub(super) outcomes: Vec<String>,
}

/// A setting read from an instrument: the true value differs by the instrument's error.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Shown {
    pub(super) key: String,
    /// Index of the instrument.
    pub(super) instrument: usize,
    /// Standard deviation of the value.
    pub(super) deviation: f64,
}

/// A reading.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Measured {
    pub(super) name: String,
    /// Index of the condition.
    pub(super) condition: usize,
    pub(super) quantity: Quantity,
    pub(super) reading: Reading,
    /// Whether it is a point of a recorded history, whose error contains part of the model's.
    pub(super) is_point: bool,
    /// Standard deviation of the independent error of the mean over all shots, including the scatter of shots.
    pub(super) error: f64,
    /// Standard deviation of the model's error.
    pub(super) discrepancy: f64,
    /// Error shared with other readings of the same instrument.
    pub(super) instrument: Option<InstrumentError>,
}

/// A reading of sound or vibration, in decibels: re 1 pW s, (20 uPa)2 s or 1 m/s2.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MeasuredLevel {
    pub(super) name: String,
    /// Index of the condition.
    pub(super) condition: usize,
    pub(super) quantity: LevelQuantity,
    pub(super) reading: Reading,
    /// Standard deviation of the independent error of the mean over all shots, including the scatter of shots \[dB\].
    pub(super) error: f64,
    /// Standard deviation of the model's error \[dB\].
    pub(super) discrepancy: f64,
    /// Error shared with other readings of the same instrument \[dB\].
    pub(super) instrument: Option<InstrumentError>,
}

/// The error of an instrument in a reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct InstrumentError {
    /// Index of the instrument.
    pub(super) instrument: usize,
    /// Standard deviation in the unit of the reading.
    pub(super) deviation: f64,
}

/// Correlated errors of readings.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Correlation {
    /// Indices of the readings.
    pub(super) data: Vec<usize>,
    pub(super) r: f64,
}
