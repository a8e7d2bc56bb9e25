//! Tables of a nailing cycle, the same for the terminal and the page.

use nailnoise_dynamics::network::EventTime;

use super::{Column, Table, fixed};
use crate::output::event_name;

/// Times of the events.
pub(crate) fn events(events: &[EventTime]) -> Table {
    let rows = events.iter().map(|event| {
        let words = event_name(&event.name);
        let words = match words.split_once(' ') {
            Some((symbol, name)) => format!("{symbol:<3} {name}"),
            None => words.replace('_', " "),
        };
        vec![words.into(), fixed(event.time.map(|time| 1e3 * time), 3).into()]
    });
    Table::new(
        [Column::words("event"), Column::number("time ms")],
        rows.collect::<Vec<_>>(),
    )
}
