//! The assumptions of a result: every value of the design, grouped by provenance.

use maud::{Markup, html};

use crate::design::{Design, Entry, Provenance, RangeOrigin};

use super::table;
use super::tables::plain;
use crate::tables::{Cell, Column, Table};

/// The inputs by provenance. Estimates are shown open, because a designer should check them first.
pub(super) fn section(design: &Design) -> Markup {
    let entries = design.entries();
    let of = |provenance: Provenance| -> Vec<&Entry> {
        entries.iter().filter(|entry| entry.provenance == provenance).collect()
    };
    let order = [
        (Provenance::Estimated, "an engineer\u{2019}s estimate"),
        (
            Provenance::Scaled,
            "scaled from the value of another design by a stated rule",
        ),
        (Provenance::Design, "set by this design without a source"),
        (
            Provenance::Decided,
            "decided where sources contradict each other or leave a choice",
        ),
        (Provenance::Published, "printed in a publication"),
        (Provenance::Computed, "computed from published values"),
        (Provenance::Numerical, "a property of the numerical method"),
        (
            Provenance::Constant,
            "a constant of nature or of the reference atmosphere",
        ),
    ];
    html! {
        p {
            @for (index, (provenance, _)) in order.iter().enumerate() {
                @let count = of(*provenance).len();
                @if count > 0 { @if index > 0 { ", " } b { (count) } " " (provenance.as_str()) }
            }
            "; " (entries.len()) " values in all."
        }
        @for (provenance, meaning) in order {
            @let own = of(provenance);
            @if !own.is_empty() {
                details open[provenance == Provenance::Estimated && own.len() <= 12] {
                    summary { (own.len()) " " (provenance.as_str()) ": " (meaning) }
                    (table::markup(&values(&own)))
                }
            }
        }
    }
}

/// Values with their ranges and sources.
fn values(entries: &[&Entry]) -> Table {
    let rows = entries.iter().map(|entry| {
        let origin = entry.range_origin.filter(|origin| *origin != RangeOrigin::Given);
        let range = Cell {
            spread: origin.map_or("", |origin| origin.as_str()).to_owned(),
            ..range(entry).into()
        };
        let source = Cell {
            spread: entry.note.to_string(),
            ..entry.source.to_string().into()
        };
        let value = plain(&serde_json::to_value(&entry.value).unwrap_or_default());
        vec![
            entry.key.as_str().into(),
            value.into(),
            entry.unit.to_string().into(),
            range,
            source,
        ]
    });
    let columns = [
        Column::keys("key"),
        Column::number("value"),
        Column::words("unit"),
        Column::words("range"),
        Column::words("source"),
    ];
    Table::new(columns, rows)
}

/// The range of a value; empty if it has none.
fn range(entry: &Entry) -> String {
    match entry.range {
        Some([low, high]) if low == high => "exact".to_owned(),
        Some([low, high]) => format!("{} \u{2026} {}", plain(&low.into()), plain(&high.into())),
        None => String::new(),
    }
}
