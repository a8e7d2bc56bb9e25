//! Tables of a report.

use maud::{Markup, html};
use nailnoise_dynamics::CycleRecord;
use serde_json::Value;

use super::chart::colour;
use crate::figures::in_palette;
use crate::output::EVENT_NAMES;
use crate::result::{RankedSource, RunResult};
use crate::wording::{band, order};

/// Keys of a ranked source that the report shows in a form of their own.
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

/// Rows of a table of its own shape; the rest is in `result.json`.
const ROWS: usize = 40;

/// A level with one decimal.
pub(super) fn decibels(level: Option<f64>) -> String {
    level.map_or_else(|| "silent".to_owned(), |level| format!("{level:.1}"))
}

fn loudest<T>(items: &[T], level: impl Fn(&T) -> Option<f64>) -> Option<&T> {
    let heard = items.iter().filter_map(|item| Some((item, level(item)?)));
    heard.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(item, _)| item)
}

/// The sources, loudest first.
pub(super) fn ranking(result: &RunResult) -> Markup {
    html! {
        div.scroll { table.ranking {
            thead { tr {
                th { "source" } th.n { "L" sub { "WA,1s" } } th.n { "uncertainty of the method" } th.n { "L" sub { "W,1s" } }
                th { "share of A-weighted energy" } th.n { "total without it" } th { "loudest band (A)" }
                th { "loudest interval" } th { "method" }
            } }
            tbody {
                @for (place, source) in result.ranking.iter().enumerate() {
                    tr {
                        td { span.dot style={ "background:" (colour(in_palette(&source.source, place))) } {} (source.source) }
                        td.n { b { (decibels(source.lwa_db)) } }
                        td.n { (band(source.uncertainty_db.bounds()).replace('-', "\u{2212}")) }
                        td.n { (decibels(source.lw_db)) }
                        td { div.share {
                            div.bar style={
                                "width:" (format!("{:.1}%", 100.0 * source.share)) ";background:"
                                (colour(in_palette(&source.source, place)))
                            } {}
                            span { (format!("{:.1} %", 100.0 * source.share)) }
                        } }
                        td.n { (format!("\u{2212}{:.1}", super::without(source.share))) }
                        td { @if let Some(band) = loudest(&source.bands, |band| band.lwa_db) { (band.hz) " Hz" } }
                        td { @if let Some(i) = loudest(&source.intervals, |i| i.lwa_db) { (i.from) "\u{2013}" (i.to) } }
                        td { (source.method) }
                    }
                }
                tr.sum {
                    td { "total" } td.n { b { (decibels(result.total.lwa_db)) } } td {} td.n { (decibels(result.total.lw_db)) }
                    td {} td {} td {} td {} td {}
                }
            }
        } }
        p.quiet { "Ranking: " (order(&result.ranking.iter().map(RankedSource::placed).collect::<Vec<_>>())) "." }
    }
}

/// Parts of a source, and how it was computed.
pub(super) fn source(source: &RankedSource) -> Markup {
    let mut parts: Vec<_> = source.components.iter().collect();
    let heard = |level: Option<f64>| level.unwrap_or(f64::NEG_INFINITY);
    parts.sort_by(|a, b| heard(b.lwa_db).total_cmp(&heard(a.lwa_db)));
    html! {
        p.quiet {
            (source.method) ", computed over " (format!("{:.0} to {:.0} Hz", source.range_hz[0], source.range_hz[1]))
            ". Band: " (source.uncertainty_db.basis) "."
        }
        @if !parts.is_empty() {
            div.scroll { table {
                thead { tr { th { "part" } th.n { "L" sub { "WA,1s" } " dB" } th.n { "L" sub { "W,1s" } " dB" } th { "loudest band (A)" } } }
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
            thead { tr { th { "figure of the shot" } th.n { "SI" } } }
            tbody { @for (name, value) in object.as_object().into_iter().flatten() {
                tr { td { (words(name)) } td.n { (plain(value)) } }
            } }
        } }
    }
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
                    td { (check.name) } td.n { (format!("{:.2e}", check.value)) } td.n { (format!("{:.0e}", check.limit)) }
                    td { (if check.ok { "ok" } else { "FAILED" }) }
                } } }
            } }
        }
    }
}

/// What an object holds beside the `known` keys; nothing where there is nothing.
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

/// Any value: lists of objects as a table, objects by name, the rest as it stands.
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
                    thead { tr { @for column in &columns { th { (words(column)) } } } }
                    tbody { @for row in rows.iter().take(ROWS) { tr {
                        @for column in &columns {
                            @let cell = &row[column.as_str()];
                            td.n[cell.is_number()] { (plain(cell)) }
                        }
                    } } }
                } }
                @if rows.len() > ROWS { p.quiet { "and " (rows.len() - ROWS) " more in result.json" } }
            }
        }
        Value::Object(fields) => html! {
            table.facts { @for (key, value) in fields.iter().filter(|(_, value)| !nested(value)) {
                tr { th { (words(key)) } td { (plain(value)) } }
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
    let rounded: f64 = format!("{value:.4e}").parse().unwrap_or(value);
    if rounded == 0.0 || (1e-3..1e7).contains(&rounded.abs()) {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    /// What a later version adds to a result is shown without this code knowing it.
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
    fn numbers_are_as_long_as_needed() {
        assert_eq!(significant(0.000_012_345_678), "1.2346e-5");
        assert_eq!(significant(101_327.0), "101330");
        assert_eq!(significant(-3.5), "-3.5");
    }
}
