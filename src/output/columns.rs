//! Every history of a cycle with its name and unit, for files that list them.

use nailnoise_dynamics::network::Record;

/// One history.
#[derive(Debug, Clone)]
pub struct Column<'a> {
    /// Name: words joined by underscores.
    pub name: &'a str,
    /// SI unit, as written in a header.
    pub unit: &'a str,
    /// Samples on the record's time grid.
    pub values: &'a [f64],
}

/// All histories of a record that have a column.
pub fn columns(record: &Record) -> Vec<Column<'_>> {
    let channels = record.channels.iter().filter(|channel| !channel.column.is_empty());
    let column = channels.map(|channel| Column {
        name: &channel.column,
        unit: &channel.unit,
        values: &channel.values,
    });
    column.collect()
}
