//! Reads the levels of a wrapping test from the result of `nailnoise measure`.
//!
//! All are A-weighted sound power levels from the microphones of the array. Their uncertainty is that of the result
//! with k = 2: the scatter of the shots and the reproducibility of the method. Half of the variance of the method is
//! common to the levels of a test.

use std::path::Path;

use nailnoise_calibration::likelihood::Reading;
use nailnoise_documents::{Document, KeyError, Keys, read_regular};
use serde::Deserialize;
use toml::de::DeValue;

use super::fields::{condition_of, place};
use super::level_bands::{band, range, within};
use super::level_quantities::{LevelQuantity, Position};
use super::level_reader::decibels;
use super::measurements::{Condition, InstrumentError, MeasuredLevel};
use crate::measurement::repeats::{METHOD_DB, RepeatedLevel};
use crate::measurement::result::{MeasuredBand, MeasurementResult, SCHEMA};
use crate::measurement::wrapping::{Configuration, Role};
use crate::model::supports;

/// Keys of such a measurement.
const MEASURED: [&str; 6] = ["condition", "quantity", "file", "source", "band", "discrepancy"];

/// Largest file accepted \[byte\].
const LARGEST: u64 = 64 << 20;

/// Name of all sources together.
const TOTAL: &str = crate::result::TOTAL;

/// If a level is this far above that of a silent source, more than half of its energy is from the source \[dB\].
const ABOVE_FLOOR: f64 = 3.0;

/// Largest difference of equal ends of ranges \[Hz\].
const SAME: f64 = 1e-6;

/// The table of a measurement that names a file.
pub(super) struct OfFile<'a, 't, 'i> {
    pub(super) table: &'a Keys<'t, 'i>,
    pub(super) document: &'a Document,
    pub(super) conditions: &'a [Condition],
    /// Index of the error that the levels of the file share.
    pub(super) instrument: usize,
}

/// A level of a file: its reading, and the standard deviation of the mean of the shots \[dB\].
struct Level {
    reading: Reading,
    scatter: f64,
}

#[derive(Deserialize)]
struct Layout {
    schema: String,
}

impl OfFile<'_, '_, '_> {
    /// Whether a table names a file of levels.
    pub(super) fn is_file(table: &Keys<'_, '_>) -> bool {
        let quantity = table.get("quantity").and_then(|own| own.get_ref().as_str());
        table.get("file").is_some() && matches!(quantity, None | Some("level"))
    }

    /// Reads the levels.
    ///
    /// # Errors
    /// The first invalid key, with its place and remedy; or if the file is not a test that the design predicts.
    pub(super) fn measured(&self, name: &str, notes: &mut Vec<String>) -> Result<Vec<MeasuredLevel>, KeyError> {
        let table = self.table;
        table.only(&MEASURED)?;
        let condition = condition_of(table, self.conditions)?;
        let test = self.test(&self.conditions[condition])?;
        let bands = self.bands(&self.conditions[condition], &test)?;
        let sources = Role::ALL.map(Role::name);
        let known = || [TOTAL].into_iter().chain(sources);
        let wanted = match table.text("source", "\"exhaust\"")? {
            Some(source) => vec![
                known()
                    .nth(place(table, "source", source, known(), "source")?)
                    .unwrap_or(TOTAL),
            ],
            None => known().collect(),
        };
        let discrepancy = match table.get("discrepancy") {
            Some(_) => Some(decibels(table, "discrepancy")?),
            None => None,
        };
        let mut found = Vec::new();
        for (&source, &band) in wanted
            .iter()
            .flat_map(|source| bands.iter().map(move |band| (source, band)))
        {
            let Some(level) = level(&test, source, band) else {
                continue;
            };
            let quantity = LevelQuantity::Sound {
                source: (source != TOTAL).then(|| source.to_owned()),
                position: Position::Array,
                band,
            };
            let half = std::f64::consts::FRAC_1_SQRT_2 * band.map_or(METHOD_DB, method);
            found.push(MeasuredLevel {
                name: match band {
                    Some(hz) => format!("{name}-{source}-{hz}"),
                    None => format!("{name}-{source}"),
                },
                condition,
                discrepancy: discrepancy.unwrap_or_else(|| quantity.discrepancy()),
                quantity,
                reading: level.reading,
                error: level.scatter.hypot(half),
                instrument: Some(InstrumentError {
                    instrument: self.instrument,
                    deviation: half,
                }),
            });
        }
        if found.is_empty() {
            let key = if table.get("source").is_some() {
                "source"
            } else {
                "file"
            };
            let there: Vec<&str> = known()
                .filter(|source| bands.iter().any(|band| level(&test, source, *band).is_some()))
                .collect();
            let help = match there.is_empty() {
                true => "name the result of a test whose levels are above the residual".to_owned(),
                false => format!("choose from {}", there.join(", ")),
            };
            return Err(table.error(key, "has no level in this test", help));
        }
        if all_of(&test).any(|own| own.standard_db.is_none()) {
            notes.push(format!(
                "`{name}` contains levels of one shot: a scatter of {} dB is assumed",
                default_scatter()
            ));
        }
        Ok(found)
    }

    /// The test, which must be one that the design of a condition predicts.
    fn test(&self, condition: &Condition) -> Result<MeasurementResult, KeyError> {
        let table = self.table;
        const EXAMPLE: &str = "\"out/my-test/measurement.json\"";
        let path = self.document.sibling(table.text("file", EXAMPLE)?.unwrap_or_default());
        let test = read(&path).map_err(|problem| {
            let help = "give measurement.json of `nailnoise measure`, relative to the folder of this file";
            table.error("file", format!("cannot be used: {}: {problem}", path.display()), help)
        })?;
        let setup = supports::of(&condition.design).test_setup();
        if setup != Some(test.setup) {
            let problem = format!(
                "is a test with the setup `{}`, which is not the support under \"{}\"",
                test.setup.as_str(),
                condition.name
            );
            return Err(table.error("file", problem, "calibrate a design with the support of the test"));
        }
        Ok(test)
    }

    /// The bands; one entry without a band for the whole range.
    fn bands(&self, condition: &Condition, test: &MeasurementResult) -> Result<Vec<Option<f64>>, KeyError> {
        let (table, own) = (self.table, range(&condition.design));
        let Some(value) = table.get("band") else {
            let is_same = own.iter().zip(&test.range_hz).all(|(a, b)| (a - b).abs() < SAME);
            if !is_same {
                let [low, high] = test.range_hz;
                let problem = format!(
                    "has levels over {low} to {high} Hz, the design over {} to {} Hz",
                    own[0], own[1]
                );
                let help = format!(
                    "set \"analysis.range_low\" = \"{low} Hz\" and \"analysis.range_high\" = \"{high} Hz\" under the \
                     condition, or give `band`"
                );
                return Err(table.error("file", problem, help));
            }
            return Ok(vec![None]);
        };
        let values = match value.get_ref() {
            DeValue::Array(list) => list.iter().collect(),
            _ => vec![value],
        };
        let measured = within(test.range_hz);
        let read = |value| {
            let hz = band(table, value, &condition.design)?;
            if !measured.contains(&hz) {
                let [low, high] = test.range_hz;
                let problem = format!("is {hz} Hz, which is not wholly within the {low} to {high} Hz of the test");
                let names: Vec<String> = measured.iter().map(f64::to_string).collect();
                let help = format!("choose from {} Hz", names.join(", "));
                return Err(table.wrong("band", value.span(), problem, help));
            }
            Ok(Some(hz))
        };
        values.into_iter().map(read).collect()
    }
}

/// The result of a test in a file.
fn read(path: &Path) -> Result<MeasurementResult, String> {
    let bytes = read_regular(path, LARGEST).map_err(|error| error.to_string())?;
    let layout: Layout = serde_json::from_slice(&bytes).map_err(|error| error.to_string())?;
    if layout.schema != SCHEMA {
        return Err(format!("its layout is \"{}\", not \"{SCHEMA}\"", layout.schema));
    }
    serde_json::from_slice(&bytes).map_err(|error| error.to_string())
}

/// Standard deviation of reproducibility of the method in a one-third octave \[dB\], engineering grade (ISO 3744:2010,
/// clause 9, which begins at 100 Hz and ends at 10 kHz; the nearest value elsewhere).
fn method(hz: f64) -> f64 {
    match hz {
        ..180.0 => 3.0,
        180.0..355.0 => 2.0,
        355.0..5600.0 => METHOD_DB,
        _ => 2.5,
    }
}

/// Standard deviation between shots, if a test has only one shot \[dB\].
fn default_scatter() -> f64 {
    let level = LevelQuantity::Sound {
        source: None,
        position: Position::Array,
        band: None,
    };
    level.scatter()
}

/// Levels of a test over the whole range.
fn all_of(test: &MeasurementResult) -> impl Iterator<Item = &RepeatedLevel> {
    let configurations = test.configurations.iter().filter_map(|own| own.level.as_ref());
    configurations.chain(test.sources.iter().filter_map(|own| own.level.as_ref()))
}

fn in_band(bands: &[MeasuredBand], hz: f64) -> Option<f64> {
    bands.iter().find(|own| own.hz == hz).and_then(|own| own.lwa_db)
}

/// The level of a source or of all of them in a test.
///
/// The level of the workpiece lies between two readings. The wrap of the body masks its own reading. The total less
/// exhaust and body also contains the sound that passes all wraps. Levels in bands are calculated from energies, which
/// have no bias.
fn level(test: &MeasurementResult, source: &str, band: Option<f64>) -> Option<Level> {
    let scatter = |level: &RepeatedLevel| level.standard_db.unwrap_or_else(default_scatter);
    if source == TOTAL {
        let total = test
            .configurations
            .iter()
            .find(|own| own.configuration == Configuration::Total)?;
        let level = total.level.as_ref()?;
        let db = band.map_or(Some(level.db), |hz| in_band(&total.bands, hz))?;
        return Some(Level {
            reading: Reading::Value(db),
            scatter: scatter(level),
        });
    }
    let own = test.sources.iter().find(|own| own.source == source);
    let direct = own.and_then(|own| {
        let level = own.level.as_ref()?;
        let db = band.map_or(Some(level.db), |hz| in_band(&own.bands_by_energy, hz))?;
        let is_floor = band.is_none() && own.floor_db.is_some_and(|floor| db < floor + ABOVE_FLOOR);
        Some((db, is_floor, scatter(level)))
    });
    if source != Role::Workpiece.name() {
        let (db, is_floor, scatter) = direct?;
        let reading = if is_floor {
            Reading::AtMost(db)
        } else {
            Reading::Value(db)
        };
        return Some(Level { reading, scatter });
    }
    let bound = test.bound.as_ref().and_then(|own| {
        let level = own.level.as_ref()?;
        let db = band.map_or(Some(level.db), |hz| in_band(&own.bands, hz))?;
        Some((db, scatter(level)))
    });
    let direct = direct.filter(|(_, is_floor, _)| !is_floor);
    let (reading, scatter) = match (direct, bound) {
        (Some((low, _, of_low)), Some((high, of_high))) if low < high => {
            (Reading::Within([low, high]), of_low.max(of_high))
        }
        // Their errors exceed the masking of the one and the sound through the wraps of the other.
        (Some((low, _, of_low)), Some((high, of_high))) => (Reading::Value(0.5 * (low + high)), of_low.max(of_high)),
        (Some((low, _, of_low)), None) => (Reading::AtLeast(low), of_low),
        (None, Some((high, of_high))) => (Reading::AtMost(high), of_high),
        (None, None) => return None,
    };
    Some(Level { reading, scatter })
}
