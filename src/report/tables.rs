//! Tables of a report.

use maud::{Markup, html};
use nailnoise_dynamics::CycleRecord;
use serde_json::Value;

use crate::figures::in_palette;
use crate::output::{EVENT_NAMES, event_name};
use crate::result::{RankedSource, RunResult, loudest};
use crate::study::legend;
use crate::table::Table;
use crate::wording::{band, readable, rounded, unit_of_figure};

/// Keys of a ranked source with a dedicated form in the report.
pub(super) const SOURCE: [&str; 11] = [
    "source",
    "lwa_db",
    "lw_db",
    "share",
    "method",
    "range_hz",
    "lwa_own_range_db",
    "bands",
    "components",
    "uncertainty_db",
    "intervals",
];

/// Rows of a table with a special shape; the rest is in `result.json`.
const ROWS: usize = 40;

/// A level with one decimal.
pub(super) fn decibels(level: Option<f64>) -> String {
    level.map_or_else(|| "silent".to_owned(), |level| format!("{level:.1}"))
}

/// How much lower the total would be without a source that has this share \[dB\].
pub(super) fn without(share: f64) -> f64 {
    -10.0 * (1.0 - share).max(1e-12).log10()
}

/// The sources, loudest first, with the intervals of their levels if a study states them.
pub(super) fn ranking(result: &RunResult) -> Markup {
    let study = result.study.known();
    let headings =
        html! { @if let Some(study) = study { @for heading in legend::headings(study) { th.n { (heading) } } } };
    let cells = |source: &str| {
        html! { @if let Some(study) = study { @for cell in legend::cells(study, source) { td.n { (cell) } } } }
    };
    html! {
        div.scroll { table.ranking {
            thead { tr {
                th { "source" } th.n { "L" sub { "WA,1s" } " dB" } (headings)
                th { "share of A-weighted energy" } th.n { "total without it" } th { "loudest band (A)" }
                th { "loudest after" }
            } }
            tbody {
                @for (place, source) in result.ranking.iter().enumerate() {
                    tr {
                        @let colour = format!("c{}", in_palette(&source.source, place));
                        th scope="row" { span class={ "dot " (colour) } {} (source.source) }
                        td.n { b { (decibels(source.lwa_db)) } }
                        (cells(&source.source))
                        td { div.share {
                            div class={ "bar " (colour) }
                                style={ "width:" (format!("{:.1}%", 100.0 * source.share)) } {}
                            span { (format!("{:.1} %", 100.0 * source.share)) }
                        } }
                        td.n { (format!("\u{2212}{:.1} dB", without(source.share))) }
                        td { @if let Some(band) = loudest(&source.bands, |band| band.lwa_db) { (band.hz) " Hz" } }
                        td { @if let Some(i) = loudest(&source.intervals, |i| i.lwa_db) { (event_name(&i.from)) } }
                    }
                }
                tr.sum {
                    th scope="row" { "total" } td.n { b { (decibels(result.total.lwa_db)) } } (cells("total"))
                    td {} td {} td {} td {}
                }
            }
        } }
        @for line in legend::legend(result) { p.quiet { (with_code(&line)) } }
    }
}

/// A table with its legend; the last row is a sum.
pub(super) fn with_legend(shown: &Table) -> Markup {
    let last = shown.rows.len().saturating_sub(1);
    html! {
        div.scroll { table.pinned {
            thead { tr { @for (place, heading) in shown.headings.iter().enumerate() { th.n[place > 0] { (heading) } } }
                }
            tbody { @for (place, row) in shown.rows.iter().enumerate() { tr.sum[place == last] {
                @for (column, cell) in row.iter().enumerate() {
                    @if column == 0 { th scope="row" { (cell) } } @else { td.n { (cell) } }
                }
            } } }
        } }
        @for line in &shown.legend { p.quiet { (with_code(line)) } }
    }
}

/// A line of plain text whose words between backticks are code.
pub(super) fn with_code(line: &str) -> Markup {
    let parts = line.split('`').enumerate();
    html! { @for (place, part) in parts { @if place % 2 == 1 { code { (part) } } @else { (part) } } }
}

/// Parts of a source, and how it was computed.
pub(super) fn source(source: &RankedSource) -> Markup {
    let parts = source.parts();
    html! {
        p.quiet {
            (source.method) ", computed over " (format!("{:.0} to {:.0} Hz", source.range_hz[0], source.range_hz[1]))
            ". Without A-weighting " (decibels(source.lw_db)) " dB. Error of the method alone "
            (band(source.uncertainty_db.bounds()).replace('-', "\u{2212}")) " dB: " (source.uncertainty_db.basis) "."
        }
        @if !parts.is_empty() {
            div.scroll { table {
                thead { tr { th { "part" } th.n { "L" sub { "WA,1s" } " dB" } th.n { "L" sub { "W,1s" } " dB" }
                    th { "loudest band (A)" } } }
                tbody { @for part in parts { tr {
                    td { (part.name) } td.n { (decibels(part.lwa_db)) } td.n { (decibels(part.lw_db)) }
                    td { @if let Some(band) = loudest(&part.bands, |band| band.lwa_db) { (band.hz) " Hz" } }
                } } }
            } }
        }
    }
}

/// Event times.
pub(super) fn events(record: &CycleRecord) -> Markup {
    html! {
        div.scroll { table {
            thead { tr { th { "event" } th { "what" } th.n { "ms" } } }
            tbody { @for (index, (time, name)) in record.events.to_array().iter().zip(EVENT_NAMES).enumerate() { tr {
                td { "t" sub { (index) } } td { (name) }
                td.n { (time.map_or_else(|| "\u{2013}".to_owned(), |time| format!("{:.3}", 1e3 * time))) }
            } } }
        } }
    }
}

/// Names and values of an object.
pub(super) fn figures(object: &Value) -> Markup {
    html! {
        div.scroll { table {
            thead { tr { th { "figure of the shot" } th.n { "value" } th { "unit" } } }
            tbody { @for (name, value) in object.as_object().into_iter().flatten() {
                @let (unit, factor) = readable(unit_of_figure(name));
                tr { td { (words(name)) } td.n { (plain(&scaled(value, factor))) } td { (unit) } }
            } }
        } }
    }
}

/// A number in another unit; other values unchanged.
pub(super) fn scaled(value: &Value, factor: f64) -> Value {
    value
        .as_f64()
        .map_or_else(|| value.clone(), |number| (factor * number).into())
}

/// The checks, failed ones first.
pub(super) fn checks(result: &RunResult) -> Markup {
    let failed = result.checks.iter().filter(|check| !check.ok).count();
    let mut checks: Vec<_> = result.checks.iter().collect();
    checks.sort_by_key(|check| check.ok);
    html! {
        p {
            @if failed == 0 { "All " (checks.len()) " checks of this run hold." }
            @else { b.alarm { (failed) " of " (checks.len()) " checks FAILED." } }
        }
        details open[failed > 0] {
            summary { "every check" }
            div.scroll { table {
                thead { tr { th { "check" } th.n { "value" } th.n { "limit" } th {} } }
                tbody { @for check in checks { tr.failed[!check.ok] {
                    td { (check.name) } td.n { (format!("{:.2e}", check.value)) }
                    td.n { (format!("{:.0e}", check.limit)) }
                    td { (if check.ok { "ok" } else { "FAILED" }) }
                } } }
            } }
        }
    }
}

/// Content of an object other than the `known` keys; nothing if there is no more.
pub(super) fn further(object: &Value, known: &[&str]) -> Option<Markup> {
    let rest: Vec<_> = object
        .as_object()?
        .iter()
        .filter(|(key, value)| !known.contains(&key.as_str()) && !is_empty(value))
        .collect();
    (!rest.is_empty()).then(|| {
        html! { @for (key, value) in rest {
            h3 { (words(key)) }
            (generic(value))
        } }
    })
}

fn is_empty(value: &Value) -> bool {
    match value {
        Value::Null => true,
        Value::Array(items) => items.is_empty(),
        Value::Object(items) => items.is_empty(),
        _ => false,
    }
}

/// Any value: lists of objects as a table, objects by name, the rest unchanged.
pub(super) fn generic(value: &Value) -> Markup {
    let nested = |value: &Value| match value {
        Value::Array(items) => items.iter().any(|item| item.is_object() || item.is_array()) || items.len() > 8,
        Value::Object(_) => true,
        _ => false,
    };
    match value {
        Value::Array(rows) if rows.iter().any(Value::is_object) => {
            let mut columns: Vec<&String> = Vec::new();
            for (key, value) in rows.iter().filter_map(Value::as_object).flatten() {
                if !nested(value) && !columns.contains(&key) {
                    columns.push(key);
                }
            }
            html! {
                div.scroll { table {
                    thead { tr { @for column in &columns {
                        th.n[rows.iter().any(|row| row[column.as_str()].is_number())] { (titled(column)) } } } }
                    tbody { @for row in rows.iter().take(ROWS) { tr {
                        @for column in &columns {
                            @let cell = &row[column.as_str()];
                            td.n[cell.is_number()] { (of_key(column, cell)) }
                        }
                    } } }
                } }
                @if rows.len() > ROWS { p.quiet { "and " (rows.len() - ROWS) " more in result.json" } }
            }
        }
        Value::Object(fields) => html! {
            table.facts { @for (key, value) in fields.iter().filter(|(_, value)| !nested(value)) {
                tr { th { (titled(key)) } td { (of_key(key, value)) } }
            } }
            @for (key, value) in fields.iter().filter(|(_, value)| nested(value) && !is_empty(value)) {
                h4 { (words(key)) }
                (generic(value))
            }
        },
        other => html! { p { (plain(other)) } },
    }
}

fn words(key: &str) -> String {
    key.replace('_', " ")
}

/// A key in words, with the unit of its ending.
fn titled(key: &str) -> String {
    const UNITS: [(&str, &str); 8] = [
        ("_db", "dB"),
        ("_hz", "Hz"),
        ("_pa", "Pa"),
        ("_m2", "m\u{b2}"),
        ("_m", "m"),
        ("_s", "s"),
        ("_g", "g"),
        ("_j", "J"),
    ];
    let unit = |(ending, unit): &(&str, &'static str)| Some((key.strip_suffix(*ending)?, *unit));
    match key {
        "hz" => "frequency (Hz)".to_owned(),
        "share" => "share (%)".to_owned(),
        _ => UNITS
            .iter()
            .find_map(unit)
            .map_or_else(|| words(key), |(name, unit)| format!("{} ({unit})", words(name))),
    }
}

/// The value of a key: a share in percent, levels to a thousandth of a decibel. A value that rounds to nothing is 0.
fn of_key(key: &str, value: &Value) -> String {
    match value {
        Value::Array(items) => items
            .iter()
            .map(|item| of_key(key, item))
            .collect::<Vec<_>>()
            .join(", "),
        Value::Number(number) if key == "share" => {
            let percent = (1e4 * number.as_f64().unwrap_or(0.0)).round() / 1e2;
            format!("{:.2}", percent + 0.0)
        }
        Value::Number(number) if key.ends_with("_db") => {
            plain(&((1e3 * number.as_f64().unwrap_or(0.0)).round() / 1e3 + 0.0).into())
        }
        _ => plain(value),
    }
}

/// A value with the digits that it needs.
pub(super) fn plain(value: &Value) -> String {
    match value {
        Value::Null => "\u{2013}".to_owned(),
        Value::String(text) => text.clone(),
        Value::Bool(yes) => (if *yes { "yes" } else { "no" }).to_owned(),
        Value::Number(number) => number.as_f64().map_or_else(|| number.to_string(), significant),
        Value::Array(items) => items.iter().map(plain).collect::<Vec<_>>().join(", "),
        Value::Object(_) => value.to_string(),
    }
}

/// Five digits at most, without an exponent where a reader needs none.
fn significant(value: f64) -> String {
    rounded(value, 5, 1e7)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    /// Additions of a later version to a result are shown without changes to this code.
    #[test]
    fn anything_has_a_table() {
        let value = json!({
            "known": 1,
            "microphones": [{ "name": "operator", "lpa_db": 91.234_56, "bands": [{ "hz": 50 }] }, { "name": "front" }],
            "radiation": { "method": "bem", "limit_error_db": [-0.1, 0.2], "modes": [{ "hz": 5.0 }] },
            "nothing": [],
        });
        let text = further(&value, &["known"]).map(Markup::into_string).unwrap_or_default();
        for part in [
            "microphones",
            "operator",
            "91.235",
            "front",
            "bem",
            "-0.1, 0.2",
            "<h4>modes</h4>",
        ] {
            assert!(text.contains(part), "{part} is not in {text}");
        }
        assert!(!text.contains("known") && !text.contains("nothing"));
        assert!(further(&json!({ "known": 1 }), &["known"]).is_none());
    }

    #[test]
    fn what_rounds_to_nothing_has_no_digits() {
        assert_eq!(of_key("share", &json!(-2.6e-45)), "0.00");
        assert_eq!(
            of_key("surface_difference_db", &json!([-1.2e-7, 91.234_56])),
            "0, 91.235"
        );
        assert_eq!(titled("limit_error_db"), "limit error (dB)");
        assert_eq!(titled("share"), "share (%)");
    }

    #[test]
    fn numbers_are_as_long_as_needed() {
        assert_eq!(significant(0.000_012_345_678), "1.2346e-5");
        assert_eq!(significant(101_327.0), "101330");
        assert_eq!(significant(-3.5), "-3.5");
    }
}
