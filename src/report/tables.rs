//! Tables of a report.

use maud::{Markup, html};
use serde_json::Value;

use super::table;
use crate::result::RunResult;
use crate::tables::{Column, Table, run};
use crate::units::Units;
use crate::wording::rounded;

/// Keys of a ranked source with a dedicated form in the report.
pub(super) const SOURCE: [&str; 13] = [
    "source",
    "lwa_db",
    "lw_db",
    "share",
    "method",
    "range_hz",
    "lwa_own_range_db",
    "bands",
    "components",
    "cross_check",
    "radiation",
    "uncertainty_db",
    "intervals",
];

/// Number of rows shown in a table without a dedicated form; the rest is in `result.json`.
const ROWS: usize = 40;

/// A level with one decimal.
pub(super) fn decibels(level: Option<f64>) -> String {
    level.map_or_else(|| "silent".to_owned(), |level| format!("{level:.1}"))
}

/// The checks, failed ones first.
pub(super) fn checks(result: &RunResult, units: Units) -> Markup {
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
            (table::markup(&run::checks(checks).in_units(units)))
        }
    }
}

/// Content of an object other than the `known` keys; `None` if there is no more.
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

/// Any value: lists of objects as a table, objects by name, others unchanged.
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
            let column = |key: &&String| match rows.iter().any(|row| row[key.as_str()].is_number()) {
                true => Column::number(titled(key)),
                false => Column::words(titled(key)),
            };
            let row = |row: &Value| {
                columns
                    .iter()
                    .map(|key| of_key(key, &row[key.as_str()]).into())
                    .collect()
            };
            let more = rows.len().checked_sub(ROWS).filter(|more| *more > 0);
            let more = more.map(|more| format!("and {more} more in result.json"));
            let shown = Table::new(columns.iter().map(column), rows.iter().take(ROWS).map(row));
            table::markup(&shown.with_legend(more))
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

/// A key as text, with the unit given by its suffix.
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

/// The value of a key: shares in percent, levels with three decimals. A value that rounds to zero is shown as 0.
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

/// A value with as many digits as it needs.
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

/// At most five digits, without an exponent if none is needed.
fn significant(value: f64) -> String {
    rounded(value, 5, 1e7)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    /// Fields that a later version adds to a result are shown without changes to this code.
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
