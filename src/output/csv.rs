//! Comma-separated files: `levels.csv`, `events.csv`, `histories.csv`. Units stand in the header.

use std::fmt::Write;

use nailnoise_dynamics::{CycleRecord, Events};

use super::columns::columns;
use crate::result::RunResult;

/// What each event is, in the order t0..t18.
pub const EVENT_NAMES: [&str; 19] = [
    "trigger pulled",
    "head valve lifts",
    "volume above the head valve vented",
    "intake opens",
    "piston starts",
    "rod meets the nail",
    "nail meets the wood",
    "piston at 50.51 mm down",
    "check-ring holes uncovered",
    "piston stops on the workpiece",
    "piston on the bumper",
    "piston at rest on the bumper",
    "trigger valve released",
    "exhaust opens",
    "return stroke begins",
    "piston at 50.51 mm up",
    "piston on the stopper",
    "exhaust ended",
    "piston at rest on the stopper",
];

/// `levels.csv`: one-third-octave bands by sources, unweighted; then the A-weighted total of each. The header tells how
/// each source was computed. Silence is empty.
pub(super) fn levels(result: &RunResult) -> String {
    let mut text = String::from("band [Hz]");
    for source in &result.ranking {
        let _ = write!(
            text,
            ",{} L_W [dB] ({})",
            source.source,
            source.method.replace(',', " with")
        );
    }
    text.push('\n');
    let bands = result.ranking.first().map_or(0, |source| source.bands.len());
    for band in 0..bands {
        let _ = write!(text, "{}", result.ranking[0].bands[band].hz);
        for source in &result.ranking {
            text.push(',');
            text.push_str(&optional(source.bands[band].lw_db, 3));
        }
        text.push('\n');
    }
    text.push_str("A-weighted total");
    for source in &result.ranking {
        text.push(',');
        text.push_str(&optional(source.lwa_db, 3));
    }
    text.push('\n');
    text
}

/// `events.csv`: symbol, what it is, time. An event that does not occur has no time.
pub(super) fn events(events: &Events) -> String {
    let mut text = String::from("event,description,time_s\n");
    for (index, (time, name)) in events.to_array().iter().zip(EVENT_NAMES).enumerate() {
        let _ = writeln!(text, "t{index},{name},{}", optional(*time, 9));
    }
    text
}

/// `histories.csv`: time and every history of the cycle.
pub(super) fn histories(record: &CycleRecord) -> String {
    let columns = columns(record);
    let mut text = String::from("time [s]");
    for column in &columns {
        let _ = write!(text, ",{} [{}]", column.name, column.unit);
    }
    text.push('\n');
    for index in 0..record.len() {
        let _ = write!(text, "{:.7}", record.time(index));
        for column in &columns {
            let _ = write!(text, ",{:.9e}", column.values[index]);
        }
        text.push('\n');
    }
    text
}

fn optional(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(String::new, |value| format!("{value:.decimals$}"))
}
