//! `events.csv`: the events t0 to t18 of the shot.

use nailnoise_dynamics::CycleRecord;

use super::table::{optional, table};
use super::{Exports, Output};
use crate::error::Error;
use crate::stages::cycle::EVENT_NAMES;

/// Times of the events.
pub(super) const EVENTS: Output = Output::of_cycle("events.csv", rows);

/// Symbol, description, time. The time of an event that does not occur is empty.
fn rows(record: &CycleRecord, _: Exports) -> Result<Vec<u8>, Error> {
    let times = record.events.to_array();
    let rows = times.iter().zip(EVENT_NAMES).enumerate();
    let rows = rows.map(|(index, (time, name))| [format!("t{index}"), name.to_owned(), optional(*time, 9)]);
    table(["event", "description", "time [s]"], rows)
}
