//! Charts of a calibration: predictions and inputs before and after.

use super::chart::{Axis, Chart, Panel, Series, Shape};
use super::palette::{BLACK, GREY};
use crate::calibration::{CalibrationResult, InputRow, MeasurementRow};

/// Number of inputs drawn.
const DRAWN: usize = 20;

/// Ends of the axis of relative predictions.
const RELATIVE: [f64; 2] = [-1.0, 2.0];

/// Charts of a result.
pub fn calibration(result: &CalibrationResult) -> Vec<Chart> {
    let chart = |name: &str, title, caption: &str, panel| Chart {
        name: name.to_owned(),
        title,
        subject: format!("{}: {} draws", result.design.name, result.draws),
        caption: caption.to_owned(),
        panels: vec![panel],
        events: Vec::new(),
    };
    vec![
        chart(
            "calibration-measurements",
            "Predictions before and now",
            "90 % of the predictions of each measurement, as places in its interval before: 0 is P5, 1 is P95. The \
             line across the black bar is the measurement.",
            measurements(result),
        ),
        chart(
            "calibration-inputs",
            "Inputs before and now",
            "90 % of the draws of the inputs that moved most, as places in their intervals before: 0 is P5, 1 is P95.",
            inputs(result),
        ),
    ]
}

/// Position of a value between two ends.
fn place(value: f64, [low, high]: [f64; 2]) -> f64 {
    ((value - low) / (high - low)).clamp(RELATIVE[0], RELATIVE[1])
}

fn strips(names: Vec<String>, before: &[[f64; 2]], now: &[[f64; 2]], marks: &[f64], what: &str) -> Panel {
    let series = |name: &str, colour: usize, ends: &[[f64; 2]], marks: Vec<f64>| Series {
        notes: vec![String::new(); ends.len()],
        ..Series {
            name: name.to_owned(),
            colour,
            shape: Shape::Whiskers(ends.to_vec()),
            x: (0..ends.len()).map(|place| place as f64).collect(),
            y: marks,
            notes: Vec::new(),
        }
    };
    let middle = |ends: &[[f64; 2]]| ends.iter().map(|[low, high]| 0.5 * (low + high)).collect();
    Panel {
        x: Axis::categories(what, "", names),
        y: Axis::new("Place in the interval before", "", RELATIVE),
        height: 60,
        series: vec![
            series("before", GREY, before, middle(before)),
            series("now", BLACK, now, marks.to_vec()),
        ],
    }
}

fn measurements(result: &CalibrationResult) -> Panel {
    let relative = |own: &MeasurementRow| own.now.map(|end| place(end, own.before));
    let mark = |own: &MeasurementRow| {
        own.reading[0]
            .or(own.reading[1])
            .map_or(f64::NAN, |value| place(value, own.before))
    };
    let rows = &result.measurements;
    strips(
        rows.iter().map(|own| own.name.clone()).collect(),
        &vec![[0.0, 1.0]; rows.len()],
        &rows.iter().map(relative).collect::<Vec<_>>(),
        &rows.iter().map(mark).collect::<Vec<_>>(),
        "Measurement",
    )
}

fn inputs(result: &CalibrationResult) -> Panel {
    let rows: Vec<&InputRow> = result.inputs.iter().take(DRAWN).collect();
    strips(
        (1..=rows.len()).map(|number| number.to_string()).collect(),
        &vec![[0.0, 1.0]; rows.len()],
        &rows
            .iter()
            .map(|own| own.now.map(|end| place(end, own.before)))
            .collect::<Vec<_>>(),
        &rows.iter().map(|own| place(own.medoid, own.before)).collect::<Vec<_>>(),
        "Input, in the order of the table below",
    )
}
