//! The page of an optimisation.

use maud::{Markup, html};

use super::chart::markup;
use super::page::{Page, Section};
use super::table;
use crate::figures::Chart;
use crate::optimisation::{Domain, Optimisation, Trial, Variable, is_level};
use crate::result::TOTAL;
use crate::tables::{decibels, optimisation as tables};
use crate::units::Units;
use crate::wording;

pub(super) fn page(found: &Optimisation, charts: &[Chart], reports: &[Option<String>], units: Units) -> Page {
    let chart = |name: &str| charts.iter().find(|chart| chart.name == name).map(markup);
    let sections = vec![
        Section::new(
            "best",
            "Best designs",
            html! {
                @if let Some(c) = chart("front") { (c) }
                (table::markup(&tables::best(found, reports).in_units(units)))
                p.quiet { "Levels are A-weighted single-event sound power levels, dB re 1 pW s, of single values. "
                    code { "nailnoise compare --draws" } " states how sure the change is." }
            },
        ),
        Section::new("course", "Course", html! { @if let Some(c) = chart("course") { (c) } }),
        Section::new(
            "variables",
            "What was varied",
            html! {
                ul { @for own in &found.variables { li { (varied(own)) } } }
                @if let Some(c) = chart("variables") { (c) }
            },
        ),
        Section::new(
            "candidates",
            "Candidates",
            html! {
                details {
                    summary { (found.trials.len()) " candidates" }
                    (table::markup(&tables::candidates(found).in_units(units)))
                }
            },
        ),
    ];
    Page {
        title: format!("{}: optimised", found.design.name),
        compared: None,
        heading: format!("{}: the best designs", found.design.name),
        lead: lead(found),
        sections,
    }
}

fn varied(own: &Variable) -> Markup {
    html! {
        code { (own.key) } ": "
        @match &own.domain {
            Domain::Choices(choices) => { (choices.join(", ")) }
            Domain::Range { low, high, unit, whole, log } => {
                (low) " to " (high) @if !unit.is_empty() { " " (unit) }
                @if *whole { ", whole numbers" }
                @if *log { ", equal ratios equally likely" }
            }
        }
    }
}

/// The result in one sentence: the improvement by the best design, or that there is none.
fn lead(found: &Optimisation) -> Markup {
    let level = |own: &Trial| own.shot.as_ref().and_then(|shot| shot.total_db);
    let best = found.best().next();
    let goal = found.objectives.first().map_or(TOTAL, |own| own.figure.as_str());
    html! {
        @match best {
            None => {
                p.verdict.alarm { "No design meets the constraints. Loosen one or widen a range." }
                @for (reason, count) in reasons(found) { p { (count) " of " (found.trials.len()) " candidates: "
                    (reason) "." } }
            }
            Some(best) if is_level(goal) => {
                @let own = best.shot.as_ref().and_then(|shot| shot.figure(goal));
                @let start = found.start.shot.as_ref().and_then(|shot| shot.figure(goal));
                div.totals { div.total {
                    span.number { (decibels(own)) } span.unit { "dB" }
                    span.what { (goal) " of the best design, " (decibels(start)) " dB of the design itself" }
                } }
                @if let Some(change) = own.zip(start).map(|(own, start)| own - start) {
                    p.verdict { (gain(goal, change)) }
                }
            }
            Some(best) => {
                p.verdict { "The best design has " (goal.replace('_', " ")) " "
                    (best.shot.as_ref().and_then(|shot| shot.figure(goal)).map_or_else(String::new, |value|
                        wording::figure(goal, value)))
                    " and " (decibels(level(best))) " dB; the design itself " (decibels(level(&found.start))) " dB." }
            }
        }
        p { (found.with_levels()) " designs with levels of " (found.trials.len()) " candidates; " (found.feasible())
            " meet all constraints"
            @if !found.constraints.is_empty() { ": " (found.constraints.iter().map(|own| own.text.as_str())
                .collect::<Vec<_>>().join("; ")) }
            ". Minimised: " (found.objectives.iter().map(|own| own.words()).collect::<Vec<_>>().join("; "))
            ". Seed " (found.seed) "." }
    }
}

fn gain(goal: &str, change: f64) -> String {
    let what = if goal == TOTAL {
        "The tool".to_owned()
    } else {
        format!("The {goal}")
    };
    match wording::change(change).as_str() {
        "0.0" => format!("{what} does not become quieter within these ranges."),
        text if change < 0.0 => format!("{what} becomes {} dB quieter.", text.trim_start_matches('-')),
        text => format!(
            "{what} becomes {} dB louder: the design itself breaks a constraint.",
            &text[1..]
        ),
    }
}

/// The reasons for excluding candidates, with their numbers.
fn reasons(found: &Optimisation) -> Vec<(String, usize)> {
    let mut counts: Vec<(String, usize)> = Vec::new();
    for trial in &found.trials {
        let reason = tables::excluded(found, trial);
        match counts.iter_mut().find(|(own, _)| *own == reason) {
            Some((_, count)) => *count += 1,
            None => counts.push((reason, 1)),
        }
    }
    counts.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    counts.truncate(3);
    counts
}
