//! Tables of a nailing cycle, the same for the terminal and the page.

use nailnoise_dynamics::CycleRecord;

use super::{Column, Table, fixed};
use crate::output::EVENT_NAMES;

/// Times of the events.
pub(crate) fn events(record: &CycleRecord) -> Table {
    let times = record.events.to_array();
    let times = times.iter().zip(EVENT_NAMES).enumerate();
    let rows = times.map(|(number, (time, name))| {
        vec![
            format!("t{number:<2} {name}").into(),
            fixed(time.map(|time| 1e3 * time), 3).into(),
        ]
    });
    Table::new(
        [Column::words("event"), Column::number("time ms")],
        rows.collect::<Vec<_>>(),
    )
}
