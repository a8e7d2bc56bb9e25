//! The page of a calibration.

use maud::{Markup, html};
use nailnoise_quantities::rounded;

use super::chart::markup;
use super::page::{Page, Section};
use super::typography::with_code;
use crate::calibration::{CalibrationResult, MeasurementRow};
use crate::figures::Chart;

/// Further measurements that are shown.
const NEXT_SHOWN: usize = 16;

pub(super) fn page(result: &CalibrationResult, charts: &[Chart]) -> Page {
    let chart = |name: &str| charts.iter().find(|chart| chart.name == name).map(markup);
    let mut sections = Vec::new();
    if !result.measurements.is_empty() {
        sections.push(Section::new(
            "measurements",
            "Measurements",
            html! { @if let Some(c) = chart("calibration-measurements") { (c) } (measurements(result)) },
        ));
    }
    if !result.conflicts.is_empty() {
        sections.push(Section::new("conflicts", "Conflicts", conflicts(result)));
    }
    if !result.measurements.is_empty() {
        sections.push(Section::new(
            "inputs",
            "Inputs",
            html! { @if let Some(c) = chart("calibration-inputs") { (c) } (inputs(result)) },
        ));
    }
    sections.push(Section::new("shot", "The shot of the design", figures(result)));
    if !result.levels.is_empty() {
        sections.push(Section::new("levels", "Levels", levels(result)));
    }
    if !result.next.is_empty() {
        sections.push(Section::new("next", "What to measure next", next(result)));
    }
    if !result.steps.is_empty() {
        sections.push(Section::new("sampler", "The sampler", sampler(result)));
    }
    Page {
        title: format!("{}: calibration", result.design.name),
        compared: None,
        heading: format!("{}: calibrated with {}", result.design.name, result.measured),
        lead: lead(result),
        sections,
    }
}

fn lead(result: &CalibrationResult) -> Markup {
    html! {
        @if !result.converged { p { b { "The sampler has not converged: do not rely on these intervals." } }
            ul { @for fault in &result.faults { li { (fault) } } } }
        p { (result.draws) " draws from the ranges" @if !result.measurements.is_empty() { ", given the measurements" }
            "; seed " (result.seed) "." }
        ul { @for note in &result.notes { li { (with_code(note)) } } }
    }
}

fn number(value: f64) -> String {
    if value.is_finite() {
        rounded(value, 3, 1e5)
    } else {
        "\u{2013}".to_owned()
    }
}

fn interval([low, high]: [f64; 2]) -> String {
    format!("{} .. {}", number(low), number(high))
}

fn reading(own: &MeasurementRow) -> String {
    match own.reading {
        [Some(low), Some(high)] if low == high => number(low),
        [low, high] => format!(
            "{} .. {}",
            low.map_or_else(String::new, number),
            high.map_or_else(String::new, number)
        ),
    }
}

fn measurements(result: &CalibrationResult) -> Markup {
    html! {
        div.scroll { table {
            thead { tr { th { "measurement" } th { "condition" } th.n { "value" } th { "unit" } th.n { "before, 90 %" }
                th.n { "now, 90 %" } th.n { "left over, sd" } th.n { "probability" } th { "verdict" } } }
            tbody { @for own in &result.measurements { tr {
                td { (own.name) } td { (own.condition) } td.n { (reading(own)) } td { (own.unit) }
                td.n { (interval(own.before)) } td.n { (interval(own.now)) } td.n { (format!("{:+.1}", own.left_over)) }
                td.n { (format!("{:.2}", own.probability)) }
                td { (own.verdict.as_str()) @if !own.counts { ", not used" } }
            } } }
        } }
        p.quiet { "Before: candidates from the ranges with the observed outcomes. Probability: of a value at least as \
            extreme, by the other measurements." }
    }
}

fn conflicts(result: &CalibrationResult) -> Markup {
    html! {
        @for own in &result.conflicts {
            h3 { (own.measurement) @if let Some(partner) = &own.partner { " and " (partner) } }
            p {
                @match (own.nearest, own.distance) {
                    (Some(nearest), Some(distance)) => {
                        "No candidate comes near it: the nearest has " (number(nearest)) " " (own.unit) ", "
                        (format!("{distance:.1}")) " standard deviations away. "
                    }
                    _ => {
                        @match &own.partner {
                            Some(partner) => { (own.measurement) " and " (partner) " contradict each other" }
                            None => { "It contradicts the other measurements" }
                        }
                        ": its probability by the others is " (format!("{:.1e}", own.probability)) ". "
                    }
                }
                @match own.widened {
                    Some(factor) => { "The errors were widened by a factor " (format!("{factor:.1}")) "." }
                    None => { "All intervals of this page are without it." }
                }
            }
            ul { @for remedy in &own.remedies { li { (with_code(remedy)) } } }
        }
    }
}

fn inputs(result: &CalibrationResult) -> Markup {
    html! {
        div.scroll { table {
            thead { tr { th { "input" } th { "unit" } th.n { "before, 90 %" } th.n { "now, 90 %" } th.n { "ratio" }
                th.n { "middle draw" } } }
            tbody { @for own in result.inputs.iter().filter(|own| own.ratio < result.moved_below) { tr {
                td.key-name { (own.name) } td { (own.unit) } td.n { (interval(own.before)) }
                td.n { (interval(own.now)) } td.n { (format!("{:.2}", own.ratio)) } td.n { (number(own.medoid)) }
            } } }
        } }
        p { (result.unidentified) " inputs are not identified by these measurements." }
        @if !result.pairs.is_empty() { div.scroll { table {
            thead { tr { th { "pair" } th.n { "rank correlation" } } }
            tbody { @for own in &result.pairs { tr {
                td.key-name { (own.inputs.join(", ")) } td.n { (format!("{:+.2}", own.rank_correlation)) }
            } } }
        } } }
    }
}

fn figures(result: &CalibrationResult) -> Markup {
    html! {
        div.scroll { table {
            thead { tr { th { "figure" } th { "unit" } th.n { "before, P50" } th.n { "90 %" } th.n { "now, P50" }
                th.n { "90 %" } } }
            tbody { @for own in &result.figures { tr {
                td { (own.name) } td { (own.unit) }
                @for [low, middle, high] in [own.before, own.now] {
                    td.n { b { (number(middle)) } } td.n { (interval([low, high])) }
                }
            } } }
        } }
    }
}

fn levels(result: &CalibrationResult) -> Markup {
    let words = |[low, middle, high]: [f64; 3]| format!("{middle:.1} ({low:.1} .. {high:.1})");
    let first = |own: Option<[f64; 2]>, place: usize| own.map_or_else(String::new, |own| format!("{:.2}", own[place]));
    html! {
        div.scroll { table {
            thead { tr { th { "source" } th.n { "study of the ranges, dB" } th.n { "without levels, dB" }
                th.n { "P(first)" } th.n { "now, dB" } th.n { "P(first)" } } }
            tbody { @for own in &result.levels { tr {
                td { (own.output) } td.n { (own.ranges.map_or_else(|| "\u{2013}".to_owned(), words)) }
                td.n { (words(own.before)) } td.n { (first(own.first, 0)) }
                td.n { b { (words(own.now)) } } td.n { (first(own.first, 1)) }
            } } }
        } }
        p.quiet { "L_WA,1s of a shot of the design, re 1 pW s: P50 and 90 %."
            @if let Some(work) = result.level_work { " " (work.shots) " shots with " (work.errors)
                " errors of the methods each; weighted by the levels, they count as "
                (format!("{:.0}", work.effective)) " shots." } }
    }
}

fn next(result: &CalibrationResult) -> Markup {
    html! {
        @if let Some(own) = result.next.first() { p {
            "Now the 90 % interval of the total is " (format!("{:.1}", own.width[0]))
            " dB wide, and the loudest source is first with a probability of " (format!("{:.2}", own.first[0])) "."
        } }
        div.scroll { table {
            thead { tr { th { "measurement" } th { "pressure" } th.n { "error" } th { "unit" } th.n { "minutes" }
                th.n { "total, 90 %, dB" } th.n { "P(first)" } th.n { "narrower, dB/h" } th.n { "surer, 1/h" } } }
            tbody { @for own in result.next.iter().take(NEXT_SHOWN) { tr {
                td { (with_code(&own.measurement)) } td { (own.condition) } td.n { (number(own.error)) }
                td { (own.unit) } td.n { (format!("{:.0}", own.minutes)) } td.n { (format!("{:.1}", own.width[1])) }
                td.n { (format!("{:.2}", own.first[1])) }
                td.n { @if own.is_bound { "\u{2265} " } (format!("{:.2}", own.narrower_an_hour)) }
                td.n { (format!("{:+.3}", own.surer_an_hour)) }
            } } }
        } }
        p.quiet { "Mean over the draws of what remains once the measurement is made with this error, which \
            includes the model's. \u{2265}: the draws are too few for so sharp a measurement." }
    }
}

fn sampler(result: &CalibrationResult) -> Markup {
    html! {
        p { (result.candidates) " candidates, " (result.work.likelihoods) " points and " (result.work.cycles)
            " nailing cycles in " (result.work.runs) " runs; the draws descend from " (result.ancestors)
            " candidates. Log evidence " (format!("{:.2}", result.log_evidence)) ", halves "
            (format!("{:.2}", result.halves_apart)) " apart." }
        div.scroll { table {
            thead { tr { th.n { "\u{3c4}" } th.n { "moves" } th.n { "acceptance" } th.n { "size" } th.n { "directions" }
                th.n { "ancestors" } th.n { "correlation, informed" } th.n { "all" } } }
            tbody { @for own in &result.steps { tr {
                td.n { (format!("{:.2e}", own.temperature)) } td.n { (own.moves) }
                td.n { (format!("{:.2}", own.acceptance)) } td.n { (format!("{:.2}", own.size)) }
                td.n { (own.directions) } td.n { (own.ancestors) }
                @for own in own.correlations { td.n { (format!("{own:.2}")) } }
            } } }
        } }
    }
}
