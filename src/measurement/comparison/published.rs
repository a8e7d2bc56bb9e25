//! Files of measurements, `nailnoise-measured/1`.

use std::path::Path;

use nailnoise_meshes::read_regular;
use serde::Deserialize;

use crate::measurement::error::MeasurementError;

/// The largest file that is read \[byte\].
const LARGEST: u64 = 16 << 20;

/// Its layout.
const LAYOUT: &str = "nailnoise-measured/1";

/// Published measurements of a tool.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Published {
    /// Layout.
    pub schema: String,
    /// The tool, its nails and wood.
    pub tool: String,
    /// Where they were published.
    pub source: String,
    /// What was measured.
    entries: Vec<Entry>,
    /// What follows from these together.
    implied: Option<Implied>,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
struct Entry {
    id: String,
    quantity: String,
    value: Measured,
    unit: String,
    kind: Kind,
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
enum Kind {
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
pub struct PublishedEntry {
    /// Its name; of an implied quantity its words.
    pub id: String,
    /// What it is.
    pub quantity: String,
    /// Unit.
    pub unit: String,
    /// Where it was published.
    pub source: String,
    /// What stays open.
    pub note: String,
    ends: [Option<f64>; 2],
    bound: bool,
    rounding: f64,
}

impl PublishedEntry {
    /// The interval that the printed value stands for; an open end is `None`.
    pub fn interval(&self) -> [Option<f64>; 2] {
        let [low, high] = self.ends;
        [
            low.map(|low| low - self.rounding),
            high.map(|high| high + self.rounding),
        ]
    }

    /// Half of the last printed digit.
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

impl Published {
    /// Reads a file.
    ///
    /// # Errors
    /// [`MeasurementError::Unreadable`] for a file that cannot be read or holds no measurements, with the reason.
    pub fn read(path: &Path) -> Result<Self, MeasurementError> {
        let unreadable = |cause: String| MeasurementError::Unreadable {
            path: path.to_owned(),
            channel: None,
            cause,
            help: format!(
                "give a JSON file of layout {LAYOUT}, as designs/measured/n80cb.json; docs/validation.md describes it"
            ),
        };
        let bytes = read_regular(path, LARGEST).map_err(|error| unreadable(error.to_string()))?;
        let read: Self = serde_json::from_slice(&bytes).map_err(|error| unreadable(error.to_string()))?;
        if read.schema != LAYOUT {
            return Err(unreadable(format!("its layout is \"{}\"", read.schema)));
        }
        let values = read.all().into_iter().flat_map(|entry| entry.ends);
        if values.flatten().any(|value| !value.is_finite()) {
            return Err(unreadable("a value is not finite".to_owned()));
        }
        Ok(read)
    }

    /// All quantities: those published, then those implied.
    pub fn all(&self) -> Vec<PublishedEntry> {
        let own = self.entries.iter().map(|entry| {
            let ends = match (&entry.value, entry.kind) {
                (Measured::One(value), Kind::UpperBound) => [None, Some(*value)],
                (Measured::One(value), _) => [Some(*value); 2],
                (Measured::Range(ends), _) => *ends,
            };
            PublishedEntry {
                id: entry.id.clone(),
                quantity: entry.quantity.clone(),
                unit: entry.unit.clone(),
                source: entry.source.clone(),
                note: entry.note.clone(),
                ends,
                bound: entry.kind == Kind::UpperBound,
                rounding: entry.rounding,
            }
        });
        let implied = self.implied.iter().flat_map(|implied| {
            implied.entries.iter().map(|entry| PublishedEntry {
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
        own.chain(implied).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shipped() -> Published {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("designs/measured/n80cb.json");
        Published::read(&path).unwrap_or_else(|error| panic!("{error}"))
    }

    #[test]
    fn the_shipped_file_is_read() {
        let all = shipped().all();
        let of = |id: &str| all.iter().find(|entry| entry.id == id).map(PublishedEntry::interval);
        let closure = of("closure_worktable").map(|ends| ends.map(|end| end.unwrap_or(f64::NAN)));
        assert!(closure.is_some_and(|[low, high]| (low - 3.85).abs() < 1e-12 && (high - 3.95).abs() < 1e-12));
        assert_eq!(of("lwa_workpiece_worktable"), Some([None, Some(103.75)]));
        assert_eq!(of("total, worktable"), Some([Some(105.4), Some(106.1)]));
    }

    #[test]
    fn a_file_of_another_layout_is_refused() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
        assert!(matches!(
            Published::read(&path),
            Err(MeasurementError::Unreadable { .. })
        ));
    }
}
