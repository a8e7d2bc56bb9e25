//! The page of a wrapping test.

use maud::{Markup, html};

use super::chart::markup;
use super::page::{Page, Section};
use super::table;
use super::typography::with_code;
use crate::figures::Chart;
use crate::measurement::repeats::RepeatedLevel;
use crate::measurement::result::MeasurementResult;
use crate::measurement::wrapping::Configuration;
use crate::tables::measurement as tables;

pub(super) fn page(result: &MeasurementResult, charts: &[Chart]) -> Page {
    let chart = |name: &str| charts.iter().find(|chart| chart.name == name).map(markup);
    let mut sections = vec![
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
    ];
    if let Some(chart) = chart("measured-intervals") {
        sections.push(Section::new("intervals", "Intervals", chart));
    }
    sections.extend([
        Section::new(
            "signals",
            "Signals and markers",
            html! { @if let Some(c) = chart("measured-signals") { (c) } (markers(result)) (accelerations(result)) },
        ),
        Section::new("processing", "Processing", processing(result)),
    ]);
    let name = name(&result.manifest);
    Page {
        title: format!("{name}: measurement"),
        compared: None,
        heading: format!("{name}: what the test measured"),
        lead: lead(result),
        sections,
    }
}

/// The manifest by its folder and file, however it was given.
fn name(manifest: &str) -> String {
    let parts: Vec<&str> = manifest.split(['/', '\\']).filter(|part| !part.is_empty()).collect();
    parts[parts.len().saturating_sub(2)..].join("/")
}

/// The level with nothing wrapped, the sources from the loudest, and the notes.
fn lead(result: &MeasurementResult) -> Markup {
    let total = result
        .configurations
        .iter()
        .find(|own| own.configuration == Configuration::Total)
        .and_then(|own| own.level.as_ref());
    let mut sources: Vec<(&str, &RepeatedLevel)> = result
        .sources
        .iter()
        .filter_map(|own| Some((own.source.as_str(), own.level.as_ref()?)))
        .collect();
    sources.sort_by(|a, b| b.1.db.total_cmp(&a.1.db));
    html! {
        @if let Some(level) = total {
            div.total {
                span.number { (format!("{:.1}", level.db)) }
                span.unit { "dB" }
                span.what {
                    "A-weighted sound energy of one shot with nothing wrapped, L" sub { "WA,1s" } " re 1 pW s; "
                    (format!("\u{b1}{:.1} dB (k = 2) over {} shots", level.expanded_db, level.repeats))
                }
            }
        }
        @if let [(first, level), others @ ..] = sources.as_slice() {
            p.verdict {
                "The " b { (first) } " is loudest: " (level_of(level))
                @for (name, level) in others { "; " (name) " " (level_of(level)) }
                "."
            }
        }
        @if !result.notes.is_empty() { ul.notes { @for note in &result.notes { li { (with_code(note)) } } } }
    }
}

fn level_of(level: &RepeatedLevel) -> String {
    format!("{:.1} \u{b1} {:.1} dB", level.db, level.expanded_db)
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
