//! `log.csv`: contacts, openings, choking, reversals and events of the shot.

use nailnoise_dynamics::LogEntry;
use nailnoise_dynamics::network::Record;

use super::histories::title;
use super::table::table;
use super::{CycleView, Exports, Output};
use crate::error::Error;

/// The log of the shot.
pub(super) const LOG: Output = Output::of_cycle("log.csv", rows);

/// All entries, with the state at that instant: those of the nailer in its terms, otherwise those of the blocks.
fn rows(of: CycleView<'_>, _: Exports) -> Result<Option<Vec<u8>>, Error> {
    match of.nailer {
        Some(nailer) => of_nailer(&nailer.log),
        None => of_blocks(of.record),
    }
    .map(Some)
}

fn of_blocks(record: &Record) -> Result<Vec<u8>, Error> {
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
    table(header.chain(states), log)
}

fn of_nailer(log: &[LogEntry]) -> Result<Vec<u8>, Error> {
    let header = [
        "time [s]",
        "entry",
        "description",
        "piston_travel [m]",
        "piston_velocity [m/s]",
        "valve_lift [m]",
        "valve_velocity [m/s]",
        "tool_rise [m]",
        "tool_velocity [m/s]",
        "tip_depth [m]",
        "above_piston_pressure [Pa]",
        "below_piston_pressure [Pa]",
        "return_volume_pressure [Pa]",
        "above_valve_pressure [Pa]",
        "supply_pressure [Pa]",
    ];
    let rows = log.iter().map(|entry| {
        let word = |value: serde_json::Result<serde_json::Value>| {
            let value = value.unwrap_or_default();
            value.as_str().unwrap_or_default().to_owned()
        };
        let crossing = word(serde_json::to_value(entry.crossing));
        let direction = word(serde_json::to_value(entry.direction));
        let description = entry.crossing.describe(entry.direction).to_owned();
        let s = &entry.state;
        let motion = [
            s.piston_travel,
            s.piston_velocity,
            s.valve_lift,
            s.valve_velocity,
            s.tool_rise,
            s.tool_velocity,
            s.tip_depth,
        ];
        let state = motion
            .into_iter()
            .chain(s.pressures)
            .map(|value| format!("{value:.6e}"));
        let entry = [
            format!("{:.9}", entry.time),
            format!("{crossing} {direction}"),
            description,
        ];
        entry.into_iter().chain(state)
    });
    table(header, rows)
}
