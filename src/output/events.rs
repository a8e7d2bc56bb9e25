//! `events.csv`: the events t0 to t18 of the shot.

use nailnoise_dynamics::CycleRecord;

use super::table::{optional, table};
use super::{Exports, Output};
use crate::error::Error;

/// Times of the events.
pub(super) const EVENTS: Output = Output::of_cycle("events.csv", rows);

/// Description of each event, in the order t0..t18.
pub const EVENT_NAMES: [&str; 19] = [
    "trigger pulled",
    "head valve lifts",
    "volume above valve vented",
    "intake opens",
    "piston starts",
    "rod meets the nail",
    "nail meets the wood",
    "piston at 50.51 mm down",
    "check-ring holes uncovered",
    "piston stops relative to the workpiece",
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

/// An event, given as "t12", with its description.
pub fn event_name(number: &str) -> String {
    let index = number.strip_prefix('t').and_then(|index| index.parse::<usize>().ok());
    let name = index.and_then(|index| EVENT_NAMES.get(index));
    name.map_or_else(|| number.to_owned(), |name| format!("{number} {name}"))
}

/// Symbol, description, time. The time of an event that does not occur is empty.
fn rows(record: &CycleRecord, _: Exports) -> Result<Vec<u8>, Error> {
    let times = record.events.to_array();
    let rows = times.iter().zip(EVENT_NAMES).enumerate();
    let rows = rows.map(|(index, (time, name))| [format!("t{index}"), name.to_owned(), optional(*time, 9)]);
    table(["event", "description", "time [s]"], rows)
}
