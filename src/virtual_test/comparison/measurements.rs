//! Measured quantities: published ones, `nailnoise-measured/1`, and those of the user's own test,
//! `nailnoise-measurement/1`.

use std::path::Path;

use nailnoise_documents::read_regular;
use serde::Deserialize;

use crate::measurement::arrangement::Part;
use crate::measurement::error::MeasurementError;
use crate::measurement::repeats::RepeatedLevel;
use crate::measurement::result::{MeasurementResult, SCHEMA};
use crate::measurement::wrapping::{Configuration, Role};
use crate::shipped;

/// Maximum size of a file \[byte\].
const LARGEST: u64 = 64 << 20;

/// Maximum magnitude of a measured value, in its unit.
const LIMIT: f64 = 1e9;

/// Layout of published measurements.
const LAYOUT: &str = "nailnoise-measured/1";

/// Measurements of a tool.
#[derive(Debug, Clone, PartialEq)]
pub struct Measurements {
    /// The tool, its nails and wood.
    pub tool: String,
    /// Their publication, or the manifest of their recordings.
    pub source: String,
    /// Range of the levels \[Hz\]; `None` if it is not stated.
    pub range_hz: Option<[f64; 2]>,
    /// The measured quantities, and those implied by several of them.
    pub quantities: Vec<MeasuredQuantity>,
}

/// Content common to all files of measurements.
#[derive(Deserialize)]
struct Layout {
    schema: String,
}

/// A file of published measurements.
#[derive(Debug, Clone, PartialEq, Deserialize)]
struct Published {
    tool: String,
    source: String,
    entries: Vec<Entry>,
    /// Quantities implied by several of these.
    implied: Option<Implied>,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
struct Entry {
    id: String,
    quantity: String,
    value: Measured,
    unit: String,
    kind: MeasurementKind,
    source: String,
    #[serde(default)]
    rounding: f64,
    #[serde(default)]
    note: String,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(untagged)]
enum Measured {
    One(f64),
    Range([Option<f64>; 2]),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum MeasurementKind {
    Point,
    UpperBound,
    Interval,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
struct Implied {
    assumes: String,
    entries: Vec<ImpliedEntry>,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
struct ImpliedEntry {
    quantity: String,
    low: Option<f64>,
    high: Option<f64>,
    unit: String,
    #[serde(default)]
    note: String,
}

/// A measured quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredQuantity {
    /// Its name; for an implied quantity, its description.
    pub id: String,
    /// Description.
    pub quantity: String,
    /// Unit.
    pub unit: String,
    /// Its publication.
    pub source: String,
    /// Open questions.
    pub note: String,
    ends: [Option<f64>; 2],
    bound: bool,
    rounding: f64,
}

impl MeasuredQuantity {
    /// The interval that the printed value represents; an open end is `None`.
    pub fn interval(&self) -> [Option<f64>; 2] {
        let [low, high] = self.ends;
        [
            low.map(|low| low - self.rounding),
            high.map(|high| high + self.rounding),
        ]
    }

    /// Half a unit of the last printed digit.
    pub fn rounding(&self) -> f64 {
        self.rounding
    }

    /// Whether only the upper end was published.
    pub fn is_upper_bound(&self) -> bool {
        self.bound
    }

    #[cfg(test)]
    pub(super) fn interval_of(id: &str, ends: [Option<f64>; 2]) -> Self {
        Self {
            id: id.to_owned(),
            quantity: id.to_owned(),
            unit: "dB".to_owned(),
            source: String::new(),
            note: String::new(),
            ends,
            bound: false,
            rounding: 0.0,
        }
    }
}

impl Measurements {
    /// Reads a file of published measurements, or the result of `nailnoise measure`. If no such file exists, a name may
    /// be that of [measurements](shipped::measured) that come with the program.
    ///
    /// # Errors
    /// [`MeasurementError::Unreadable`] with the reason for a file that cannot be read or contains no measurements.
    pub fn read(path: &Path) -> Result<Self, MeasurementError> {
        let unreadable = |cause: String| MeasurementError::Unreadable {
            path: path.to_owned(),
            channel: None,
            cause,
            help: format!(
                "give measurement.json of `nailnoise measure`, or a JSON file of layout {LAYOUT}, as \
                 designs/measured/n80cb.json; \
                 docs/measurement.md describes both"
            ),
        };
        let wrong = |error: serde_json::Error| unreadable(error.to_string());
        let shipped = path.to_str().and_then(shipped::measured).filter(|_| !path.exists());
        let bytes = match shipped {
            Some((_, text)) => text.as_bytes().to_vec(),
            None => read_regular(path, LARGEST).map_err(|error| unreadable(error.to_string()))?,
        };
        let layout: Layout = serde_json::from_slice(&bytes).map_err(wrong)?;
        let read = match layout.schema.as_str() {
            LAYOUT => Self::published(&serde_json::from_slice(&bytes).map_err(wrong)?),
            SCHEMA => Self::own(&serde_json::from_slice(&bytes).map_err(wrong)?),
            other => return Err(unreadable(format!("its layout is \"{other}\""))),
        };
        for own in &read.quantities {
            let mut values = own.ends.into_iter().flatten().chain([own.rounding]);
            if let Some(value) = values.find(|value| !(-LIMIT..=LIMIT).contains(value)) {
                return Err(unreadable(format!(
                    "\"{}\" has the value {value:?}; at most {LIMIT:e} in its unit is expected",
                    own.id
                )));
            }
        }
        Ok(read)
    }

    /// Published quantities, then implied ones.
    fn published(file: &Published) -> Self {
        let own = file.entries.iter().map(|entry| {
            let ends = match (&entry.value, entry.kind) {
                (Measured::One(value), MeasurementKind::UpperBound) => [None, Some(*value)],
                (Measured::One(value), _) => [Some(*value); 2],
                (Measured::Range(ends), _) => *ends,
            };
            MeasuredQuantity {
                id: entry.id.clone(),
                quantity: entry.quantity.clone(),
                unit: entry.unit.clone(),
                source: entry.source.clone(),
                note: entry.note.clone(),
                ends,
                bound: entry.kind == MeasurementKind::UpperBound,
                rounding: entry.rounding,
            }
        });
        let implied = file.implied.iter().flat_map(|implied| {
            implied.entries.iter().map(|entry| MeasuredQuantity {
                id: entry.quantity.clone(),
                quantity: entry.quantity.clone(),
                unit: entry.unit.clone(),
                source: format!("implied by the published levels together: {}", implied.assumes),
                note: entry.note.clone(),
                ends: [entry.low, entry.high],
                bound: false,
                rounding: 0.0,
            })
        });
        Self {
            tool: file.tool.clone(),
            source: file.source.clone(),
            range_hz: None,
            quantities: own.chain(implied).collect(),
        }
    }

    /// Quantities of the user's own test: levels with their expanded uncertainty, the closure without uncertainty, and
    /// the block's RMS acceleration with its scatter.
    fn own(result: &MeasurementResult) -> Self {
        let setup = result.setup.as_str();
        let quantity = |id: String, words: &str, unit: &str, ends: [f64; 2], note: String| MeasuredQuantity {
            id,
            quantity: words.to_owned(),
            unit: unit.to_owned(),
            source: result.manifest.clone(),
            note,
            ends: ends.map(Some),
            bound: false,
            rounding: 0.0,
        };
        let level = |id: String, words: &str, level: Option<RepeatedLevel>| {
            let level = level?;
            let ends = [level.db - level.expanded_db, level.db + level.expanded_db];
            let note = format!(
                "{} shots, expanded uncertainty with the method's (k = 2)",
                level.repeats
            );
            Some(quantity(id, words, "dB(A)", ends, note))
        };
        let total = result
            .configurations
            .iter()
            .find(|own| own.configuration == Configuration::Total);
        let source = |role: Role| {
            result
                .sources
                .iter()
                .find(|own| own.source == role.name())
                .and_then(|own| own.level)
        };
        // The block moves in the same way in all configurations, so their means show the scatter.
        let block = Part::Block.names().into_iter().find_map(|name| {
            let sensors = result.configurations.iter().flat_map(|own| &own.accelerations);
            let levels = sensors.filter(|own| own.name == name).map(|own| [own.rms_g; 2]);
            let ends = levels.reduce(|[low, high], [rms, _]| [low.min(rms), high.max(rms)])?;
            Some((name, ends))
        });
        let all = [
            level(
                format!("total, {setup}"),
                "total as recorded",
                total.and_then(|own| own.level),
            ),
            level(
                format!("lwa_workpiece_{setup}"),
                "upper bound of the workpiece",
                result.bound.as_ref().and_then(|own| own.level),
            ),
            level(
                format!("exhaust, corrected, {setup}"),
                "exhaust less residual",
                source(Role::Exhaust),
            ),
            level(
                format!("body, corrected, {setup}"),
                "body less residual",
                source(Role::Body),
            ),
            level(
                format!("workpiece as measured directly (X5), {setup}"),
                "workpiece less residual",
                source(Role::Workpiece),
            ),
            result.closure_db.map(|closure| {
                let words = "closure: total less the sum of the three sources";
                quantity(format!("closure_{setup}"), words, "dB(A)", [closure; 2], String::new())
            }),
            block.map(|(name, ends)| {
                let words = format!("RMS acceleration of accelerometer {name} over 1 s");
                let note = "lowest and highest mean of a configuration".to_owned();
                quantity(format!("rms_w_{setup}"), &words, "g", ends, note)
            }),
        ];
        Self {
            tool: format!("wrapping test on the {setup}"),
            source: result.manifest.clone(),
            range_hz: Some(result.range_hz),
            quantities: all.into_iter().flatten().collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shipped() -> Measurements {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("designs/measured/n80cb.json");
        Measurements::read(&path).unwrap_or_else(|error| panic!("{error}"))
    }

    #[test]
    fn the_shipped_file_is_read() {
        let all = shipped().quantities;
        let of = |id: &str| all.iter().find(|entry| entry.id == id).map(MeasuredQuantity::interval);
        let closure = of("closure_worktable").map(|ends| ends.map(|end| end.unwrap_or(f64::NAN)));
        assert!(closure.is_some_and(|[low, high]| (low - 3.85).abs() < 1e-12 && (high - 3.95).abs() < 1e-12));
        assert_eq!(of("lwa_workpiece_worktable"), Some([None, Some(103.75)]));
        assert_eq!(of("total, worktable"), Some([Some(105.4), Some(106.1)]));
    }

    #[test]
    fn levels_of_an_own_test_have_their_expanded_uncertainty() {
        let path = std::env::temp_dir().join(format!("nailnoise-measurement-{}.json", std::process::id()));
        let result = r#"{"schema": "nailnoise-measurement/1", "manifest": "m.toml", "setup": "sandbox", "area_m2": 13.4,
            "k2_db": 0,
            "range_hz": [50, 10000], "processing": {"reading": "margin", "paired": false, "total_less_residual": false},
            "configurations": [], "sources": [], "closure_db": 1.5, "notes": [],
            "bound": {"by_energy_db": null, "bands": [], "negative_bands": 0, "level": {"db": 100, "repeats": 5,
            "standard_db": 0.1, "half_width_db": 0.3, "expanded_db": 3}}}"#;
        std::fs::write(&path, result).unwrap();
        let own = Measurements::read(&path).unwrap_or_else(|error| panic!("{error}"));
        std::fs::remove_file(&path).unwrap();
        let found: Vec<_> = own
            .quantities
            .iter()
            .map(|own| (own.id.as_str(), own.interval()))
            .collect();
        let bound = ("lwa_workpiece_sandbox", [Some(97.0), Some(103.0)]);
        assert_eq!(found, [bound, ("closure_sandbox", [Some(1.5); 2])]);
    }

    #[test]
    fn a_file_of_another_layout_is_refused() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
        assert!(matches!(
            Measurements::read(&path),
            Err(MeasurementError::Unreadable { .. })
        ));
    }
}
