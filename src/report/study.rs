//! The report of a study.

use maud::{Markup, html};

use super::chart::markup;
use super::head::missed;
use super::page::{Page, Section};
use super::table;
use super::typography::{typeset, with_code, with_subscripts};
use crate::figures::Chart;
use crate::study::{Contributions, Estimate, GroupStudy, SourceStudy, StudyResult};
use crate::tables::study as tables;

pub(super) fn page(result: &StudyResult, charts: &[Chart], scatter: &[Chart]) -> Page {
    let chart = |name: &str| charts.iter().find(|chart| chart.name == name).map(markup);
    let sections = vec![
        Section::new(
            "levels",
            "Levels",
            html! { @if let Some(c) = chart("study-levels") { (c) }
                (table::markup(&tables::levels(result)))
                p.quiet { "A-weighted single-event sound power levels, dB re 1 pW s. Perfect knowledge of all inputs \
                    would be worth " (table::content(&tables::level(&result.perfect_information_db))) " dB to the \
                        choice of the source \
                    to silence." }
            },
        ),
        Section::new(
            "order",
            "Order",
            html! { @if let Some(c) = chart("study-orders") { (c) }
            (table::markup(&tables::orders(result))) (table::markup(&tables::pairs(result))) },
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
        Section::new("drawn", "What was drawn", table::markup(&tables::variables(result))),
        Section::new(
            "notes",
            "Notes",
            html! { ul.notes { @for note in &result.notes { li { (with_code(note)) } } } },
        ),
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
        @for (place, line) in answer(result).iter().enumerate() {
            p.verdict[place == 0] { (with_subscripts(line)) }
        }
        p.quiet { (result.draws) " draws, " (structures) ", seed " (result.seed)
            ". Beside each estimate: half of its 90 % interval over resampled draws. "
            a href="#notes" { "Notes" } " lists the uncertainties that the draws do not include." }
    }
}

/// How sure the ranking is, how far the total may be off, and which input decides: a sentence each.
fn answer(result: &StudyResult) -> Vec<String> {
    let percent = |estimate: &Estimate| {
        let cell = tables::probability(estimate);
        let half = estimate.half_width().filter(|_| cell.spread.starts_with("+-"));
        let half = half.map_or_else(String::new, |half| format!(" +-{:.0}", 100.0 * half));
        estimate.value.map(|value| format!("{:.0}{half} %", 100.0 * value))
    };
    let likely = result.sources.iter().max_by(|a, b| {
        let first = |own: &SourceStudy| own.first.value.unwrap_or(0.0);
        first(a).total_cmp(&first(b))
    });
    let first = likely.and_then(|own| {
        let share = percent(&own.first)?;
        Some(format!(
            "The {} is the loudest source in {share} of the draws.",
            own.source
        ))
    });
    let order = result.orders.first().and_then(|own| {
        let share = percent(&own.probability)?;
        Some(format!(
            "The complete order {} holds in {share} of them.",
            own.order.join(" > ")
        ))
    });
    let [low, high] = result.total.ends(result.draws).map(|end| end.value);
    let total = low.zip(high).map(|(low, high)| {
        let own = result.total.nominal_db.zip(result.total.below_nominal);
        let own = own.map_or_else(String::new, |(own, below)| {
            format!(
                "; the design itself has {own:.1} dB, more than {:.0} % of the draws",
                100.0 * below
            )
        });
        format!("The total L_WA,1s lies between {low:.1} and {high:.1} dB in most draws{own}.")
    });
    let decisive = result.contributions.iter().find(|own| own.output == "total");
    let decisive = decisive.and_then(|own| own.inputs.first()).map(|input| {
        format!(
            "`{}` decides most of the total: {:.0} % of its variance.",
            input.variable,
            100.0 * input.first_order
        )
    });
    [first, order, total, decisive]
        .into_iter()
        .flatten()
        .map(|line| line.replace('`', ""))
        .collect()
}

/// The output's variance, and the smallest part of it that is statistically significant.
fn resolved(own: &Contributions) -> String {
    let structures = own.by_chance_of_structures;
    let structures = structures.map_or_else(String::new, |limit| format!(" of shots and {limit:.2} of structures"));
    format!(
        "Variance {:.1} dB2. Parts below {:.2}{structures} may be chance: in one of twenty random pairings an input \
         exceeds them.",
        own.variance_db2, own.by_chance
    )
}

fn contributions(result: &StudyResult) -> Markup {
    html! {
        @if result.contributions.is_empty() { p { "Too few draws to say which inputs decide." } }
        @for own in &result.contributions {
            h3 { (own.output) }
            p.quiet { (typeset(&resolved(own))) }
            @if own.inputs.is_empty() { p { "Not resolved with so many draws." } }
            @else { (table::markup(&tables::contributions(own, usize::MAX))) }
        }
    }
}

/// Surrogates in all inputs, one row per output.
fn surrogates(result: &StudyResult) -> Markup {
    html! {
        @if let Some(degree) = result.surrogates.iter().map(|own| own.degree).max() {
            h3 { "Polynomial in all inputs" }
            p.quiet { "Degree " (degree) ". Q\u{b2}: part of the variance of draws left out that the polynomial \
                predicts; 1 less this is its error. Total index: part of the variance in which an input has a share." }
            (table::markup(&tables::surrogates(&result.surrogates, usize::MAX)))
        }
    }
}

/// Groups of inputs, one table per output.
fn groups(study: &GroupStudy) -> Markup {
    html! {
        h3 { "Groups of inputs" }
        p.quiet { (study.rows) " draws with two partners for each group. First-order index: part of the variance that \
            knowing the group takes off. Total index: part that remains where all else is known."
            @if study.incomplete > 0 { " " (study.incomplete) " draws have no partner and are left out." } }
        @for own in &study.outputs {
            h3 { (own.output) ", variance " (format!("{:.1}", own.variance_db2)) " dB\u{b2}" }
            (table::markup(&tables::groups(study, own)))
        }
        (table::markup(&tables::members(study)))
    }
}

fn candidates(result: &StudyResult) -> Markup {
    let shots: u64 = result.candidates.outcomes.values().sum();
    let incompatible = tables::incompatible(&result.candidates);
    html! {
        p { (result.candidates.drawn) " candidates, " (shots) " shots, " (result.draws) " draws." }
        (table::markup(&tables::outcomes(result)))
        @if let Some(own) = &result.condition {
            h3 { "What decides whether a shot counts" }
            p.quiet { (format!("{:.1}", 100.0 * own.share)) " % of " (own.shots)
                " shots count. Parts of the variance below " (format!("{:.3}", own.by_chance)) " may be chance." }
            @if own.inputs.is_empty() { p { "Not resolved with so many shots." } }
            @else { (table::markup(&tables::condition(own, usize::MAX))) }
        }
        @if !incompatible.rows.is_empty() { (table::markup(&incompatible)) }
    }
}
