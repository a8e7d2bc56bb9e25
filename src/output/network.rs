//! Files of a network cycle: histories of all channels, events and log.

use nailnoise_dynamics::network::Record;

use super::table::{coarse, numbers, optional, table};
use super::{Exports, File};
use crate::error::Error;

/// Title of a column, with its unit.
fn title(name: &str, unit: &str) -> String {
    format!("{name} [{unit}]").replace(" []", "")
}

/// `histories.csv`, `openings.csv`, `log.csv` and `events.csv`.
///
/// # Errors
/// [`Error::Table`].
pub fn of_network(record: &Record, exports: Exports) -> Result<Vec<File>, Error> {
    let mut files = Vec::new();
    if let Some(interval) = record.interval {
        let (stride, digits) = if exports.histories {
            (1, 9)
        } else {
            (coarse(interval), 6)
        };
        let time = |index: usize| index as f64 * interval;
        let channels = record.channels.iter().filter(|channel| !channel.column.is_empty());
        let titles = channels.clone().map(|channel| title(&channel.column, &channel.unit));
        let values: Vec<&[f64]> = channels.map(|channel| &channel.values[..]).collect();
        let header = std::iter::once("time [s]".to_owned()).chain(titles);
        files.push(File::new(
            "histories.csv",
            numbers(header, (time, 7), (&values, digits), stride)?,
        ));
        let mut header = vec!["time [s]".to_owned()];
        let mut values: Vec<&[f64]> = Vec::new();
        for opening in &record.openings {
            for (quantity, unit, history) in [
                ("mass_flow", "kg/s", &opening.mass_flow),
                ("pressure", "Pa", &opening.pressure),
                ("back_pressure", "Pa", &opening.back_pressure),
                ("temperature", "K", &opening.temperature),
            ] {
                header.push(format!("{}_{quantity} [{unit}]", opening.name));
                values.push(history);
            }
        }
        if !values.is_empty() {
            files.push(File::new(
                "openings.csv",
                numbers(header, (time, 7), (&values, digits), stride)?,
            ));
        }
    }
    let log = record.log.iter().map(|entry| {
        let block = if entry.restriction.is_empty() {
            entry.block.clone()
        } else {
            format!("{}.{}", entry.block, entry.restriction)
        };
        let state = entry.state.iter().map(|value| format!("{value:.6e}"));
        [format!("{:.9}", entry.time), block, entry.word.to_owned()]
            .into_iter()
            .chain(state)
    });
    let states = record
        .state_columns
        .iter()
        .map(|own| title(&own.name.replace('.', "_"), own.unit));
    let header = ["time [s]", "block", "word"].map(str::to_owned).into_iter();
    files.push(File::new("log.csv", table(header.chain(states), log)?));
    let events = record.events.iter().map(|event| {
        let description = event.description.clone();
        [event.name.clone(), description, optional(event.time, 9)]
    });
    files.push(File::new(
        "events.csv",
        table(["event", "description", "time [s]"], events)?,
    ));
    Ok(files)
}
