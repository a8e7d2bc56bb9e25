//! The assumptions of a result: every value of the design, grouped by provenance.

use std::collections::BTreeMap;

use maud::{Markup, html};

use crate::design::{Design, Entry, Provenance, RangeOrigin, Value};

use super::table;
use super::tables::plain;
use crate::tables::{Cell, Column, Table};
use crate::wording::in_one_unit;

/// The inputs by provenance. Estimates are shown open, because a designer should check them first.
pub(super) fn section(design: &Design) -> Markup {
    let (entries, meanings) = (design.entries(), design.meanings());
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
                    (table::markup(&values(&meanings, &own)))
                }
            }
        }
    }
}

/// Values in readable units with their meanings, ranges and sources.
fn values(meanings: &BTreeMap<String, String>, entries: &[&Entry]) -> Table {
    let rows = entries.iter().map(|entry| {
        let origin = entry.range_origin.filter(|origin| *origin != RangeOrigin::Given);
        let key = Cell {
            spread: meanings.get(&entry.key).cloned().unwrap_or_default(),
            ..entry.key.as_str().into()
        };
        let range = Cell {
            spread: origin.map_or("", |origin| origin.as_str()).to_owned(),
            ..range(entry).into()
        };
        let source = Cell {
            spread: entry.note.to_string(),
            ..entry.source.to_string().into()
        };
        let value = value(entry);
        vec![key, value.into(), range, source]
    });
    let columns = [
        Column::keys("key"),
        Column::number("value"),
        Column::number("range"),
        Column::words("source"),
    ];
    Table::new(columns, rows)
}

/// The value with its unit.
fn value(entry: &Entry) -> String {
    match &entry.value {
        Value::Number(number) => {
            let ([value], unit) = in_one_unit(&entry.unit, [*number]);
            format!("{value} {unit}").trim_end().to_owned()
        }
        other => plain(&serde_json::to_value(other).unwrap_or_default()),
    }
}

/// The range of a value, with its unit once; empty without one.
fn range(entry: &Entry) -> String {
    match entry.range {
        Some([low, high]) if low == high => "exact".to_owned(),
        Some(ends) => {
            let ([low, high], unit) = in_one_unit(&entry.unit, ends);
            format!("{low} .. {high} {unit}").trim_end().to_owned()
        }
        None => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ends_have_the_unit_of_the_larger() {
        for (unit, ends, expected) in [
            ("m", [0.00564, 0.00874], (["5.64", "8.74"], "mm")),
            ("Pa", [9.4e8, 1.3e10], (["0.94", "13"], "GPa")),
            ("m2", [0.0, 4e-5], (["0", "40"], "mm2")),
            ("", [0.28, 0.4], (["0.28", "0.4"], "")),
        ] {
            let (shown, unit) = in_one_unit(unit, ends);
            assert_eq!((shown.each_ref().map(String::as_str), unit), expected);
        }
    }
}
