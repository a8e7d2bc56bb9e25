//! `events.csv`: the named events of the shot.

use super::table::{optional, table};
use super::{CycleView, Exports, Output};
use crate::error::Error;

/// Times of the events.
pub(super) const EVENTS: Output = Output::of_cycle("events.csv", rows);

/// Name, description, time. The time of an event that does not occur is empty.
fn rows(of: CycleView<'_>, _: Exports) -> Result<Option<Vec<u8>>, Error> {
    let rows = of.record.events.iter().map(|event| {
        let description = event.description.clone();
        [event.name.clone(), description, optional(event.time, 9)]
    });
    table(["event", "description", "time [s]"], rows).map(Some)
}
