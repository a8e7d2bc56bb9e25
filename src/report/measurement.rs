//! The page of a wrapping test.

use maud::{Markup, html};

use super::chart::markup;
use super::page::{Page, Section};
use super::table::{self, with_code};
use crate::figures::Chart;
use crate::measurement::result::MeasurementResult;
use crate::tables::measurement as tables;

pub(super) fn page(result: &MeasurementResult, charts: &[Chart]) -> Page {
    let chart = |name: &str| charts.iter().find(|chart| chart.name == name).map(markup);
    let sections = vec![
        Section::new(
            "levels",
            "Levels",
            html! { @if let Some(c) = chart("measured-levels") { (c) } (sources(result))
            (table::markup(&tables::configurations(result))) },
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

fn sources(result: &MeasurementResult) -> Markup {
    html! {
        (table::markup(&tables::sources(result)))
        p.quiet {
            "A-weighted single-event sound power levels, dB re 1 pW s. By energy: energies subtracted without a limit, \
             free of bias, with more scatter. Floor: what a silent source would read. "
            @if let Some(closure) = result.closure_db {
                "Closure: the total lies " (format!("{closure:.1} dB")) " above the sum of the three sources."
            }
        }
    }
}

fn markers(result: &MeasurementResult) -> Markup {
    html! {
        @for own in result.configurations.iter().filter(|own| !own.markers.is_empty()) {
            details { summary { (own.name) ": markers" } (table::markup(&tables::markers(own))) }
        }
    }
}

fn accelerations(result: &MeasurementResult) -> Markup {
    let accelerations = tables::accelerations(result);
    html! { @if !accelerations.rows.is_empty() { (table::markup(&accelerations)) } }
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
