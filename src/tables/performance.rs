//! The costs of noise reduction, in the columns of a table: energy reserve, air consumption and rate of a shot.

use super::{Cell, dash};
use crate::result::Performance;

/// Headings of [`cells`].
pub(crate) const HEADINGS: [&str; 4] = ["head mm", "left J", "air L", "shots/s"];

/// The figures of a shot; a dash for those that do not exist.
pub(crate) fn cells(performance: Option<&Performance>) -> [Cell; 4] {
    let figures = performance.map(|own| own.figures().map(|figure| figure.value));
    figures
        .unwrap_or_default()
        .map(|value| dash(value, |value| value).into())
}

/// Columns of [`csv_cells`].
pub(crate) const CSV_HEADINGS: [&str; 4] = [
    "head below the surface [m]",
    "energy left at flush [J]",
    "air a shot [m3]",
    "shots a second at most [Hz]",
];

/// The same for a CSV file in SI units; an entry without a value is empty.
pub(crate) fn csv_cells(performance: Option<&Performance>) -> [String; 4] {
    let all = performance.map_or([None; 4], |own| {
        [own.head_depth_m, own.energy_left_j, own.air_m3, own.shots_per_second]
    });
    all.map(|value| value.map_or_else(String::new, |value| format!("{value:.6e}")))
}
