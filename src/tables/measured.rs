//! The table of measured and predicted quantities.

use super::{Cell, Column, Table, dash};
use crate::virtual_test::comparison::{ComparedQuantity, MeasuredComparison};

/// Measured and predicted quantities; levels first, numbered as in the chart.
pub(crate) fn quantities(comparison: &MeasuredComparison) -> Table {
    let measured = |own: &ComparedQuantity| match own.measured {
        [None, Some(high)] => format!("<= {high:.2}"),
        [Some(low), None] => format!(">= {low:.2}"),
        [Some(low), Some(high)] => format!("{low:.2} .. {high:.2}"),
        [None, None] => "-".to_owned(),
    };
    let (levels, others): (Vec<_>, Vec<_>) = comparison.rows.iter().partition(|own| own.level);
    let rows = levels.into_iter().chain(others).enumerate().map(|(place, own)| {
        let cells = [
            (place + 1).to_string(),
            own.quantity.clone(),
            own.design.clone(),
            own.unit.clone(),
            measured(own),
            format!("{:.2}", own.predicted),
            dash(own.interval, |[low, high]| format!("{low:.2} .. {high:.2}")),
            format!("{:+.2}", own.distance),
            own.source.clone(),
        ];
        cells.map(Cell::from).to_vec()
    });
    let columns = [
        Column::number("row"),
        Column::words("quantity"),
        Column::words("design"),
        Column::words("unit"),
        Column::number("measured"),
        Column::number("predicted"),
        Column::number("5 .. 95 %"),
        Column::number("distance"),
        Column::words("published in").page_only(),
    ];
    Table::new(columns, rows).with_legend(
        ["distance: between the intervals, in the unit of the row; 0 where they \
                                            overlap, positive where the prediction is higher"
            .to_owned()],
    )
}
