//! The assumptions of a result: every value of the design, grouped by provenance.

use maud::{Markup, html};

use crate::design::{Design, Entry, Provenance, RangeOrigin};

use super::tables::plain;

/// The inputs by provenance; estimates, the first inputs for a designer to check, are open.
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
                    div.scroll { table {
                        thead { tr { th { "key" } th.n { "value" } th { "unit" } th { "range" } th { "source" } } }
                        tbody { @for entry in own { tr {
                            td.key-name { (entry.key) }
                            td.n { (plain(&serde_json::to_value(&entry.value).unwrap_or_default())) }
                            td { (entry.unit) }
                            td { (range(entry)) }
                            td { (entry.source) @if !entry.note.is_empty() { " " span.quiet { (entry.note) } } }
                        } } }
                    } }
                }
            }
        }
    }
}

/// The range of a value and, if no file states it, its origin.
fn range(entry: &Entry) -> Markup {
    html! {
        @match entry.range {
            Some([low, high]) if low == high => { "exact" }
            Some([low, high]) => { (plain(&low.into())) " \u{2026} " (plain(&high.into())) }
            None => {}
        }
        @if let Some(origin) = entry.range_origin.filter(|origin| *origin != RangeOrigin::Given) {
            " " span.quiet { (origin.as_str()) }
        }
    }
}
