//! `histories.csv`: time and every history of the cycle.

use nailnoise_dynamics::CycleRecord;

use super::columns::columns;
use super::table::{coarse, numbers};
use super::{Exports, Output};
use crate::error::Error;

/// Histories of the cycle.
pub(super) const HISTORIES: Output = Output::of_cycle("histories.csv", rows);

/// Time and every history of the cycle: all samples and digits, or samples at a coarser interval with seven digits.
fn rows(record: &CycleRecord, exports: Exports) -> Result<Vec<u8>, Error> {
    let columns = columns(record);
    let titles = columns
        .iter()
        .map(|column| format!("{} [{}]", column.name, column.unit));
    let (stride, digits) = if exports.histories {
        (1, 9)
    } else {
        (coarse(record.sample_interval), 6)
    };
    let values: Vec<&[f64]> = columns.iter().map(|column| column.values).collect();
    numbers(
        ["time [s]".to_owned()].into_iter().chain(titles),
        (|index| record.time(index), 7),
        (&values, digits),
        stride,
    )
}
