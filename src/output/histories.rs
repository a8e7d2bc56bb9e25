//! `histories.csv` and `openings.csv`: time and every history of the cycle.

use nailnoise_dynamics::network::Record;

use super::columns::columns;
use super::table::{numbers, stride};
use super::{CycleView, Exports, Output};
use crate::error::Error;

/// Histories of the cycle.
pub(super) const HISTORIES: Output = Output::of_cycle("histories.csv", rows);

/// Flows through the openings that make noise.
pub(super) const OPENINGS: Output = Output::of_cycle("openings.csv", openings);

fn rows(of: CycleView<'_>, exports: Exports) -> Result<Option<Vec<u8>>, Error> {
    let columns = columns(of.record).into_iter();
    written(
        of.record,
        columns.map(|own| (title(own.name, own.unit), own.values)),
        exports,
    )
}

fn openings(of: CycleView<'_>, exports: Exports) -> Result<Option<Vec<u8>>, Error> {
    let columns = of.record.openings.iter().flat_map(|opening| {
        let quantities = [
            ("mass_flow", "kg/s", &opening.mass_flow),
            ("pressure", "Pa", &opening.pressure),
            ("back_pressure", "Pa", &opening.back_pressure),
            ("temperature", "K", &opening.temperature),
        ];
        quantities.map(|(quantity, unit, values)| (title(&format!("{}_{quantity}", opening.name), unit), &values[..]))
    });
    written(of.record, columns, exports)
}

/// Title of a column, with its unit.
pub(super) fn title(name: &str, unit: &str) -> String {
    format!("{name} [{unit}]").replace(" []", "")
}

/// Time and histories: all samples and digits, or samples at a coarser interval with seven digits; `None` without
/// histories.
fn written<'a>(
    record: &Record,
    columns: impl Iterator<Item = (String, &'a [f64])>,
    exports: Exports,
) -> Result<Option<Vec<u8>>, Error> {
    let (titles, values): (Vec<String>, Vec<&[f64]>) = columns.unzip();
    let Some(interval) = record.interval.filter(|_| !values.is_empty()) else {
        return Ok(None);
    };
    let digits = if exports.histories { 9 } else { 6 };
    let header = std::iter::once("time [s]".to_owned()).chain(titles);
    let time = |index| record.time(index);
    numbers(header, (time, 7), (&values, digits), stride(interval, exports)).map(Some)
}
