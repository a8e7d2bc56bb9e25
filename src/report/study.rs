//! The report of a study.

use maud::{Markup, html};

use super::chart::markup;
use super::head::missed;
use super::page::{Page, Section};
use super::tables::{decibels, with_code};
use crate::figures::Chart;
use crate::study::{Estimate, GroupStudy, LevelStudy, StudyResult, common_reason, names_of_ends};

pub(super) fn page(result: &StudyResult, charts: &[Chart], scatter: &[Chart]) -> Page {
    let chart = |name: &str| charts.iter().find(|chart| chart.name == name).map(markup);
    let sections = vec![
        Section::new(
            "levels",
            "Levels",
            html! { @if let Some(c) = chart("study-levels") { (c) } (levels(result)) },
        ),
        Section::new(
            "order",
            "Order",
            html! { @if let Some(c) = chart("study-orders") { (c) } (louder(result)) },
        ),
        Section::new(
            "inputs",
            "What decides",
            html! { (contributions(result)) (surrogates(result)) @if let Some(own) = &result.groups { (groups(own)) }
            @if let Some(c) = chart("study-one-at-a-time") { h3 { "One input at a time" } (c) }
                @for c in scatter { (markup(c)) } },
        ),
        Section::new(
            "bands",
            "Bands",
            html! { @if let Some(c) = chart("study-bands") { (c) } },
        ),
        Section::new(
            "convergence",
            "Convergence",
            html! { @if let Some(c) = chart("study-convergence") { (c) } (candidates(result)) },
        ),
        Section::new("drawn", "What was drawn", variables(result)),
    ];
    Page {
        title: format!("{}: study", result.design.name),
        compared: None,
        heading: format!("{}: how sure is the ranking", result.design.name),
        lead: lead(result),
        sections,
    }
}

fn lead(result: &StudyResult) -> Markup {
    let structures = match result.structures {
        0 => "structures as in the design".to_owned(),
        count => format!("{count} structures"),
    };
    html! {
        (missed(result.headline.as_ref()))
        p { (result.draws) " draws, " (structures) ", seed " (result.seed)
            ". Beside each estimate: half of its 90 % interval over resampled draws." }
        ul { @for note in &result.notes { li { (with_code(note)) } } }
    }
}

/// A level with half of its interval.
fn level(estimate: &Estimate) -> Markup {
    html! { b { (decibels(estimate.value)) } @if let Some(half) = estimate.half_width() { " "
    span.quiet { "\u{b1}" (format!("{half:.1}")) } } }
}

fn probability(estimate: &Estimate) -> Markup {
    html! {
        b { (estimate.value.map_or_else(|| "\u{2013}".to_owned(), |value| format!("{value:.2}"))) }
        " " span.quiet { (match (estimate.value, estimate.interval, estimate.half_width()) {
            (Some(1.0), [Some(low), _], _) => format!("> {low:.2}"),
            (Some(0.0), [_, Some(high)], _) => format!("< {high:.2}"),
            (_, _, Some(half)) => format!("\u{b1}{half:.2}"),
            _ => String::new(),
        }) }
    }
}

fn levels(result: &StudyResult) -> Markup {
    let cells = |own: &LevelStudy| {
        html! {
            td.n { (decibels(own.nominal_db)) }
            td.n { @if let Some(share) = own.below_nominal { (format!("{:.0} %", 100.0 * share)) } }
            @let [low, high] = own.ends(result.draws);
            td.n { (level(&low)) } td.n { (level(&own.level_db.p50)) } td.n { (level(&high)) }
        }
    };
    let [low, high] = names_of_ends(result.draws);
    html! {
        div.scroll { table {
            thead { tr { th { "source" } th.n { "design" } th.n { "draws below" } th.n { (low) } th.n { "P50" }
                th.n { (high) }
                th.n { "P(first)" } th.n { "loss" } th.n { "silenced" } } }
            tbody {
                @for own in &result.sources { tr {
                    td { (own.source) } (cells(&own.level))
                    td.n { (probability(&own.first)) } td.n { (level(&own.loss_db)) }
                    td.n { (level(&own.silencing_db)) }
                } }
                tr.sum { td { "total" } (cells(&result.total)) td {} td {} td {} }
            }
        } }
        p.quiet { "A-weighted single-event sound power levels, dB re 1 pW s. Loss: expected distance to the loudest \
            source; silenced: \
                   expected fall of the total without the source, dB. Perfect knowledge of all inputs would be worth "
                  (level(&result.perfect_information_db)) " dB to the choice of the source to silence." }
    }
}

fn louder(result: &StudyResult) -> Markup {
    html! {
        div.scroll { table {
            thead { tr { th { "order" } th.n { "probability" } } }
            tbody { @for own in &result.orders { tr { td { (own.order.join(" > ")) }
                td.n { (probability(&own.probability)) } } } }
        } }
        div.scroll { table {
            thead { tr { th { "pair" } th.n { "probability" } } }
            tbody { @for own in &result.louder { tr {
                td { (own.source) " louder than " (own.than) } td.n { (probability(&own.probability)) }
            } } }
        } }
    }
}

fn contributions(result: &StudyResult) -> Markup {
    html! {
        @if result.contributions.is_empty() { p { "Too few draws to say which inputs decide." } }
        @for own in &result.contributions {
            h3 { (own.output) }
            p.quiet { "Variance " (format!("{:.1}", own.variance_db2)) " dB\u{b2}. Parts below "
                (format!("{:.2}", own.by_chance))
                      @if let Some(limit) = own.by_chance_of_structures { " of shots and " (format!("{limit:.2}"))
                          " of structures" }
                      " may be chance: in one of twenty random pairings an input exceeds them." }
            @if own.inputs.is_empty() { p { "Not resolved with so many draws." } }
            @else { div.scroll { table {
                thead { tr { th { "input" } th.n { "part of the variance" } th { }
                    th.n { "upper less lower third, dB" } } }
                tbody { @for input in &own.inputs { tr {
                    td.key-name { (input.variable) } td.n { (probability(&input.part())) }
                    td { div.c0 style={ "height:0.8em;background:var(--c);width:"
                        (format!("{:.1}", 12.0 * input.first_order.clamp(0.0, 1.0))) "em" } {} }
                    td.n { @if input.effect_db > 0.0 { b { "+" } } (level(&input.effect())) }
                } } }
            } } }
        }
    }
}

/// Surrogates in all inputs, an output a row.
fn surrogates(result: &StudyResult) -> Markup {
    html! {
        @if let Some(degree) = result.surrogates.iter().map(|own| own.degree).max() {
            h3 { "Polynomial in all inputs" }
            p.quiet { "Degree " (degree) ". Q\u{b2}: part of the variance of draws left out that the polynomial \
                predicts; 1 less this is its error. \
                       Total index: part of the variance in which an input has a share." }
            @let common = common_reason(&result.surrogates);
            div.scroll { table {
                thead { tr { th { "output" } th.n { "Q\u{b2}" } th.n { "terms" }
                    @if common.is_none() { th { "total indices" } } } }
                tbody { @for own in &result.surrogates { tr {
                    td { (own.output) } td.n { (format!("{:.2}", own.q2)) } td.n { (own.terms) }
                    @if common.is_none() { td { @match &own.not_resolved {
                        Some(reason) => { "not stated: " (reason) }
                        None => { @for (place, input) in own.inputs.iter().enumerate() {
                            @if place > 0 { ", " } span.key-name { (input.variable) } " " (probability(&input.total))
                        } }
                    } } }
                } } }
            } }
            @if let Some(reason) = common { p { "Indices of single inputs are not stated: " (reason) "." } }
        }
    }
}

/// Groups of inputs, each output a table.
fn groups(study: &GroupStudy) -> Markup {
    html! {
        h3 { "Groups of inputs" }
        p.quiet { (study.rows) " draws with two partners for each group. First-order index: part of the variance that \
            knowing the group takes off. \
                   Total index: part that remains where all else is known."
            @if study.incomplete > 0 { " " (study.incomplete) " draws lack a partner and are left out." } }
        @for own in &study.outputs {
            h3 { (own.output) ", variance " (format!("{:.1}", own.variance_db2)) " dB\u{b2}" }
            div.scroll { table {
                thead { tr { th { "group" } th.n { "first-order index" } th.n { "total index" } th { } } }
                tbody { @for group in &own.groups { tr {
                    td.key-name { (group.group) } td.n { (probability(&group.first_order)) }
                    td.n { (probability(&group.total)) }
                    td { div.c0 style={ "height:0.8em;background:var(--c);width:"
                        (format!("{:.1}", 12.0 * group.total.value.unwrap_or(0.0).clamp(0.0, 1.0))) "em" } {} }
                } } }
            } }
        }
        div.scroll { table {
            thead { tr { th { "group" } th { "quantities" } } }
            tbody { @for own in &study.groups { tr { td.key-name { (own.name) } td { (own.variables.join(", ")) } } } }
        } }
    }
}

fn candidates(result: &StudyResult) -> Markup {
    let shots: u64 = result.candidates.outcomes.values().sum();
    html! {
        p { (result.candidates.drawn) " candidates, " (shots) " shots, " (result.draws) " draws." }
        div.scroll { table {
            thead { tr { th { "the shot" } th.n { "candidates" } th.n { "%" } } }
            tbody { @for (name, count) in &result.candidates.outcomes { tr {
                td { (name.replace('_', " ")) } td.n { (count) }
                td.n { (format!("{:.1}", 100.0 * *count as f64 / shots.max(1) as f64)) }
            } } }
        } }
        @if let Some(own) = &result.condition {
            h3 { "What decides whether a shot counts" }
            p.quiet { (format!("{:.1}", 100.0 * own.share)) " % of " (own.shots)
                " shots count. Parts of the variance below "
                      (format!("{:.3}", own.by_chance)) " may be chance." }
            @if own.inputs.is_empty() { p { "Not resolved with so many shots." } }
            @else { div.scroll { table {
                thead { tr { th { "input" } th.n { "part of the variance" } th.n { "count in its lower half, %" }
                    th.n { "in its upper half, %" } } }
                tbody { @for input in &own.inputs { tr {
                    td.key-name { (input.variable) } td.n { (probability(&input.first_order)) }
                    @for share in input.halves { td.n { (format!("{:.1}", 100.0 * share)) } }
                } } }
            } } }
        }
        @if !result.candidates.rejections.is_empty() { div.scroll { table {
            thead { tr { th { "incompatible values" } th.n { "drawn anew" } } }
            tbody { @for (keys, count) in &result.candidates.rejections { tr { td.key-name { (keys) }
                td.n { (count) } } } }
        } } }
    }
}

fn variables(result: &StudyResult) -> Markup {
    let place = |place: Option<f64>| place.map_or_else(|| "\u{2013}".to_owned(), |place| format!("{place:.2}"));
    html! {
        div.scroll { table {
            thead { tr { th { "quantity" } th { "changes" } th { "range (SI)" } th { "distribution" }
                th.n { "quantile of the design" }
                th.n { "mean quantile of draws" } } }
            tbody { @for own in &result.variables { tr {
                td.key-name { (own.name) } td { (own.scope) @if !own.drawn { ", held" } }
                td { @if let Some([low, high]) = own.range { (format!("{low:.4e} .. {high:.4e} {}",
                    own.unit)) } @else { "own" } }
                td { (own.distribution) } td.n { (place(own.nominal_place)) } td.n { (place(own.mean_place)) }
            } } }
        } }
    }
}
