//! The page of a wrapping test.

use maud::{Markup, html};

use super::chart::markup;
use super::page::{Page, Section};
use super::tables::{decibels, with_code};
use crate::figures::Chart;
use crate::measurement::repeats::RepeatedLevel;
use crate::measurement::result::{MeasuredConfiguration, MeasurementResult};

pub(super) fn page(result: &MeasurementResult, charts: &[Chart]) -> Page {
    let chart = |name: &str| charts.iter().find(|chart| chart.name == name).map(markup);
    let sections = vec![
        Section::new(
            "levels",
            "Levels",
            html! { @if let Some(c) = chart("measured-levels") { (c) } (sources(result)) (configurations(result)) },
        ),
        Section::new(
            "bands",
            "Bands",
            html! { @if let Some(c) = chart("measured-bands") { (c) } },
        ),
        Section::new(
            "intervals",
            "Intervals",
            html! { @if let Some(c) = chart("measured-intervals") { (c) } },
        ),
        Section::new(
            "signals",
            "Signals and markers",
            html! { @if let Some(c) = chart("measured-signals") { (c) } (markers(result)) (accelerations(result)) },
        ),
        Section::new("processing", "Processing", processing(result)),
    ];
    Page {
        title: format!("{}: measurement", result.manifest),
        compared: None,
        heading: format!("{}: what the test measured", result.manifest),
        lead: html! { @if !result.notes.is_empty() { ul { @for note in &result.notes { li { (with_code(note)) } } } } },
        sections,
    }
}

fn cells(level: Option<&RepeatedLevel>) -> Markup {
    let plus_minus = |value: Option<f64>| value.map_or_else(String::new, |value| format!("\u{b1}{value:.1}"));
    html! {
        td.n { b { (decibels(level.map(|own| own.db))) } }
        td.n { (plus_minus(level.and_then(|own| own.half_width_db))) }
        td.n { (plus_minus(level.map(|own| own.expanded_db))) }
    }
}

fn sources(result: &MeasurementResult) -> Markup {
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    html! {
        div.scroll { table {
            thead { tr { th { "source" } th { "measured by" } th.n { "level" } th.n { "repeats, 95 %" }
                th.n { "with method, k = 2" }
                th.n { "by energy" } th.n { "floor" } th.n { "set to zero" } th.n { "before the trigger" } } }
            tbody {
                @for own in &result.sources { tr {
                    td { (own.source) } td { (own.configuration) " less residual" } (cells(own.level.as_ref()))
                    td.n { (decibels(own.by_energy_db)) } td.n { (decibels(own.floor_db)) }
                    td.n { (percent(own.zeroed_share)) } td.n { (percent(own.before_trigger_share)) }
                } }
                @if let Some(bound) = &result.bound { tr.sum {
                    td { "workpiece, upper bound" } td { "total less exhaust and body" } (cells(bound.level.as_ref()))
                    td.n { (decibels(bound.by_energy_db)) } td {} td {} td {}
                } }
            }
        } }
        p.quiet {
            "A-weighted single-event sound power levels, dB re 1 pW s. By energy: energies subtracted without a \
             limit, free of bias, \
             with more scatter. Floor: what a silent source would read. "
            @if let Some(closure) = result.closure_db {
                "Closure: the total lies " (format!("{closure:.1} dB")) " above the sum of the three sources."
            }
        }
    }
}

fn configurations(result: &MeasurementResult) -> Markup {
    let row = |own: &MeasuredConfiguration| {
        html! { tr {
            td { (own.name) } td.n { (own.level.map_or(0, |level| level.repeats)) } (cells(own.level.as_ref()))
            td.n { (own.above_residual_db.map_or_else(String::new, |above| format!("{above:.1}"))) }
        } }
    };
    html! {
        div.scroll { table {
            thead { tr { th { "configuration" } th.n { "shots" } th.n { "level" } th.n { "repeats, 95 %" }
                th.n { "with method, k = 2" }
                th.n { "above residual, dB" } } }
            tbody { @for own in &result.configurations { (row(own)) } }
        } }
    }
}

fn markers(result: &MeasurementResult) -> Markup {
    html! {
        @for own in result.configurations.iter().filter(|own| !own.markers.is_empty()) {
            details { summary { (own.name) ": markers" }
                div.scroll { table {
                    thead { tr { th { "marker" } th { "event of the cycle" } th { "what happens" } th.n { "shots" }
                        th.n { "mean, ms" } th.n { "deviation, ms" } } }
                    tbody { @for marker in &own.markers { tr {
                        td { (marker.name) } td { (marker.event.as_deref().unwrap_or("\u{2013}")) }
                        td { (marker.meaning) } td.n { (marker.repeats) }
                        td.n { (format!("{:.2}", 1e3 * marker.seconds)) }
                        td.n { (marker.deviation_s.map_or_else(String::new, |own| format!("{:.2}", 1e3 * own))) }
                    } } }
                } }
            }
        }
    }
}

fn accelerations(result: &MeasurementResult) -> Markup {
    html! {
        @if result.configurations.iter().any(|own| !own.accelerations.is_empty()) { div.scroll { table {
            thead { tr { th { "configuration" } th { "accelerometer" } th.n { "RMS over 1 s, g" } th.n { "peak, g" } } }
            tbody { @for own in &result.configurations { @for sensor in &own.accelerations { tr {
                td { (own.name) } td { (sensor.name) } td.n { (format!("{:.2}", sensor.rms_g)) }
                td.n { (format!("{:.0}", sensor.peak_g)) }
            } } } }
        } } }
    }
}

fn processing(result: &MeasurementResult) -> Markup {
    let processing = &result.processing;
    html! {
        table.facts {
            tr { th { "workpiece" } td { (format!("{:?}", result.setup).to_lowercase()) } }
            tr { th { "measurement surface" } td { (format!("{:.2} m\u{b2}", result.area_m2)) } }
            tr { th { "correction for the room, K2" } td { (format!("{:.2} dB", result.k2_db)) } }
            tr { th { "range" } td { (format!("{:.0} to {:.0} Hz", result.range_hz[0], result.range_hz[1])) } }
            tr { th { "subtraction" } td { (format!("{:?}", processing.reading).to_lowercase()) ", residual "
                (if processing.paired { "of the same repeat" } else { "mean of the repeats" }) } }
        }
    }
}
