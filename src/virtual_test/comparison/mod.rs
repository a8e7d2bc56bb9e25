//! Comparison of measured quantities with predictions of the same quantities.
//!
//! A wrapping test does not measure the sound power of a source but the result of its microphones, wraps and
//! subtraction. The prediction follows the same steps with energies ([`exact`](super::exact)), over draws of the
//! design's ranges and of the wraps; the result is the distance between the two intervals.

mod measurements;
mod predicted;

use schemars::JsonSchema;
use serde::Serialize;

pub use measurements::{MeasuredQuantity, Measurements};
pub use predicted::{Predicted, Quantity, predict};

use crate::measurement::manifest::Setup;

/// Layout of a comparison.
pub const SCHEMA: &str = "nailnoise-measured-comparison/1";

/// Measured quantities with their predictions.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct MeasuredComparison {
    /// Layout: `nailnoise-measured-comparison/1`.
    pub schema: String,
    /// The measured tool.
    pub tool: String,
    /// Publication of the measurements, or the manifest of their recordings.
    pub source: String,
    /// Designs for the predictions, by the support of the workpiece.
    pub designs: Vec<PredictedDesign>,
    /// One row per comparison.
    pub rows: Vec<ComparedQuantity>,
    /// Measured quantities without a prediction, with the reason.
    pub open: Vec<String>,
}

/// A design used for predictions.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PredictedDesign {
    /// Its name.
    pub name: String,
    /// Support of the workpiece.
    pub setup: Setup,
    /// Number of draws for the intervals.
    pub draws: usize,
    /// Number of structures (block, table, tool body) drawn; 0 if they are those of the design.
    pub structures: usize,
}

/// A measured quantity with its prediction.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ComparedQuantity {
    /// Name in the file of measurements.
    pub id: String,
    /// The quantity compared.
    pub quantity: String,
    /// The design or designs used for the prediction.
    pub design: String,
    /// Unit.
    pub unit: String,
    /// Whether it is a level, as opposed to a difference of levels or another quantity.
    pub level: bool,
    /// Interval of the measurement; null for an open end.
    pub measured: [Option<f64>; 2],
    /// Prediction for the design itself.
    pub predicted: f64,
    /// 5th and 95th percentile of the draws; null if nothing was drawn.
    pub interval: Option<[f64; 2]>,
    /// Distance between the intervals, 0 if they overlap, positive if the prediction is higher: in dB for levels,
    /// otherwise in the unit of the quantity.
    pub distance: f64,
    /// Publication of the measurement, or the manifest of its recordings.
    pub source: String,
    /// Open questions.
    pub note: String,
}

/// Compares a file of measurements with predictions.
pub fn compare(measured: &Measurements, predicted: &[Predicted]) -> MeasuredComparison {
    let (mut rows, mut open) = (Vec::new(), Vec::new());
    for entry in &measured.quantities {
        let quantities = Quantity::of(entry);
        if quantities.is_empty() {
            open.push(format!("{}: {}", entry.id, entry.quantity));
        }
        for quantity in quantities {
            let found = quantity.predicted(predicted);
            if found.is_empty() {
                open.push(format!(
                    "{}: {}; give a design whose workpiece stands as in the test",
                    entry.id, entry.quantity
                ));
            }
            rows.extend(found.iter().map(|found| row(entry, &quantity, found)));
        }
    }
    MeasuredComparison {
        schema: SCHEMA.to_owned(),
        tool: measured.tool.clone(),
        source: measured.source.clone(),
        designs: predicted
            .iter()
            .map(|own| PredictedDesign {
                name: own.name.clone(),
                setup: own.setup,
                draws: own.draws(),
                structures: own.structures(),
            })
            .collect(),
        rows,
        open,
    }
}

fn row(
    entry: &MeasuredQuantity,
    quantity: &Quantity,
    (design, found): &(String, predicted::Found),
) -> ComparedQuantity {
    // A bound on the true source can only be exceeded; the bound from the test's own steps is compared as a value.
    let mut measured = entry.interval();
    if quantity.is_bounded_above() {
        measured[0] = None;
    } else if let (None, Some(high)) = (measured[0], measured[1])
        && entry.is_upper_bound()
        && quantity.is_test_outcome()
    {
        measured[0] = Some(high - 2.0 * entry.rounding());
    }
    let [low, high] = found.interval.unwrap_or([found.own; 2]);
    let distance = match measured {
        [_, Some(most)] if low > most => low - most,
        [Some(least), _] if high < least => high - least,
        _ => 0.0,
    };
    ComparedQuantity {
        id: entry.id.clone(),
        quantity: quantity.in_words(entry),
        design: design.clone(),
        unit: entry.unit.clone(),
        level: quantity.is_level(),
        measured,
        predicted: found.own,
        interval: found.interval,
        distance,
        source: entry.source.clone(),
        note: entry.note.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(id: &str, low: Option<f64>, high: Option<f64>) -> MeasuredQuantity {
        MeasuredQuantity::interval_of(id, [low, high])
    }

    fn distance(measured: [Option<f64>; 2], own: f64, interval: Option<[f64; 2]>) -> f64 {
        let entry = entry("closure_worktable", measured[0], measured[1]);
        let quantity = Quantity::of(&entry).remove(0);
        row(&entry, &quantity, &(String::new(), predicted::Found { own, interval })).distance
    }

    #[test]
    fn intervals_that_overlap_have_no_distance() {
        assert_eq!(distance([Some(3.85), Some(3.95)], 2.5, Some([1.0, 4.0])), 0.0);
    }

    #[test]
    fn the_distance_of_intervals_has_the_sign_of_the_prediction() {
        assert!((distance([Some(3.85), Some(3.95)], 2.5, Some([1.0, 3.0])) + 0.85).abs() < 1e-12);
        assert!((distance([Some(3.85), Some(3.95)], 5.0, None) - 1.05).abs() < 1e-12);
    }

    #[test]
    fn an_open_end_is_never_exceeded() {
        assert_eq!(distance([None, Some(95.0)], 80.0, None), 0.0);
        assert!((distance([None, Some(95.0)], 96.0, None) - 1.0).abs() < 1e-12);
    }
}
