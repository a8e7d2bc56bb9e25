//! The report of a comparison.

use maud::{Markup, html};

use super::chart::markup;
use super::head::capitalised;
use super::page::{Page, Section};
use super::sound::{self, Recording};
use super::table::{self, typeset, with_code};
use super::tables::decibels;
use crate::comparison::{Comparison, Labelled, Levels, SourceRow};
use crate::figures::{Axis, Chart, Panel, Series, Shape, from_event, of_design};
use crate::study::PairedStudy;
use crate::tables::{dash, study::changes};
use crate::wording;

/// Range of levels shown below the highest \[dB\].
const SHOWN: f64 = 50.0;

pub(super) fn page(c: &Comparison, paired: &[PairedStudy], identity: &str, recordings: &[Recording]) -> Page {
    let mut sections = vec![
        Section::new("levels", "Levels", html! { (markup(&overview(c))) (levels(c, paired)) }),
        Section::new("differences", "Differences", inputs(c)),
    ];
    if !recordings.is_empty() {
        sections.push(Section::new("listen", "Listen", sound::players(recordings)));
    }
    let charts = |f: &dyn Fn(&SourceRow) -> Option<Chart>| {
        let charts = c.sources.iter().filter_map(f);
        html! { @for chart in charts { (markup(&chart)) } }
    };
    sections.push(Section::new(
        "bands",
        "Bands",
        charts(&|row| labelled(c, row, "bands", &row.bands)),
    ));
    sections.push(Section::new(
        "intervals",
        "Between events",
        charts(&|row| labelled(c, row, "intervals", &row.intervals)),
    ));
    sections.push(Section::new("shot", "The shot", shot(c)));
    Page {
        title: format!("{}: compared", c.designs.join(", ")),
        compared: Some(identity.to_owned()),
        heading: match c.designs.as_slice() {
            [first, others @ ..] if others.len() > 3 => format!("{first} \u{2194} {} others", others.len()),
            designs => designs.join(" \u{2194} "),
        },
        lead: lead(c),
        sections,
    }
}

fn change(db: Option<f64>) -> String {
    typeset(&dash(db, wording::change))
}

fn lead(c: &Comparison) -> Markup {
    html! {
        @let alarms = c.alarms();
        @if !alarms.is_empty() {
            div.missed role="alert" {
                @for (place, line) in alarms.iter().enumerate() {
                    p.alarm[place == 0] { (with_code(&if place == 0 { capitalised(line) } else { line.clone() })) "." }
                }
            }
        }
        div.totals.many[c.designs.len() > 4] { @for (place, name) in c.designs.iter().enumerate() {
            div.total {
                span.number { (decibels(c.total.level_db[place])) }
                span.unit { "dB" }
                span.what {
                    span class={ "dot c" (of_design(place)) } {} (name)
                    @if place > 0 { ", " (change(c.total.change_db[place])) " dB" } @else { ", reference" }
                }
            }
        } }
        @for (place, name) in c.designs.iter().enumerate().skip(1) {
            @let ranking = &c.rankings[place];
            @if *ranking != c.rankings[0] {
                p.verdict { "The ranking changes: in " b { (name) } " it is " (ranking.join(", ")) "; in "
                    (c.designs[0]) " " (c.rankings[0].join(", ")) "." }
            }
        }
        p.quiet { "L" sub { "WA,1s" } " re 1 pW s: A-weighted sound energy of one shot; changes are from the first \
            design." }
        p.quiet {
            "Absolute levels are predictions; those of one tool stand beside published tests on the page Validation \
             of the \
             documentation. Differences between designs of one tool are more reliable than levels."
        }
    }
}

/// Levels of all sources and of the total for each design.
fn overview(c: &Comparison) -> Chart {
    let rows = c.sources.iter().map(|row| (row.source.as_str(), &row.levels));
    let panel = bars(
        c,
        "Source",
        "",
        "L_{WA,1s}",
        rows.chain([("total", &c.total)]).collect(),
    );
    let caption = "A-weighted levels of each source and of all together, dB re 1 pW s. The bars stand on the lower \
        edge of \
                   the axis: a level has no zero of its own.";
    chart(c, "overview".to_owned(), caption.to_owned(), panel)
}

fn chart(c: &Comparison, name: String, caption: String, panel: Panel) -> Chart {
    Chart {
        name,
        title: "Compared",
        subject: c.designs.join(", "),
        caption,
        panels: vec![panel],
        events: Vec::new(),
    }
}

/// One series of bars per design over the labels.
fn bars(c: &Comparison, x: &str, unit: &'static str, y: &str, rows: Vec<(&str, &Levels)>) -> Panel {
    let series = |(place, name): (usize, &String)| {
        let note = |(_, row): &(&str, &Levels)| {
            format!(
                "{} dB, change {}",
                decibels(row.level_db[place]),
                change(row.change_db[place])
            )
        };
        let levels = rows.iter().map(|(_, row)| row.level_db[place]);
        Series {
            notes: rows.iter().map(note).collect(),
            ..Series::over(name, of_design(place), Shape::Bars(Vec::new()), levels)
        }
    };
    let series: Vec<Series> = c.designs.iter().enumerate().map(series).collect();
    Panel {
        x: Axis::categories(x, unit, rows.iter().map(|(label, _)| (*label).to_owned()).collect()),
        y: Axis::levels(y, "dB", SHOWN, &series),
        height: 70,
        series,
    }
}

/// Levels of a source in its bands or intervals; `None` if it is silent in all of them.
fn labelled(c: &Comparison, row: &SourceRow, kind: &str, own: &[Labelled]) -> Option<Chart> {
    own.iter()
        .flat_map(|l| &l.levels.level_db)
        .find(|level| level.is_some())?;
    let y = format!("{}, L_{{WA,1s}}", row.source);
    let panel = if kind == "bands" {
        bars(
            c,
            "Mid-band frequency",
            "Hz",
            &y,
            own.iter().map(|l| (l.label.as_str(), &l.levels)).collect(),
        )
    } else {
        // Each interval is named by the event at its start.
        let names = own
            .iter()
            .map(|l| from_event(l.label.split('-').next().unwrap_or_default()));
        let names: Vec<String> = names.collect();
        let rows = names.iter().zip(own).map(|(name, l)| (name.as_str(), &l.levels));
        let upright = bars(
            c,
            &format!("{}: from this event to the next", row.source),
            "",
            "L_{WA,1s}",
            rows.collect(),
        );
        Panel {
            x: upright.y,
            y: upright.x,
            height: 6 * names.len() as u32,
            series: upright.series.into_iter().map(Series::sideways).collect(),
        }
    };
    let caption = format!("{}: A-weighted levels, dB re 1 pW s.", row.source);
    Some(chart(
        c,
        format!("{kind}-{}", row.source.replace(' ', "-")),
        caption,
        panel,
    ))
}

fn levels(c: &Comparison, paired: &[PairedStudy]) -> Markup {
    html! {
        (table::markup(&c.level_table()))
        @if paired.is_empty() {
            p.quiet { "How sure a level is depends on the values of its design first: "
                code { "nailnoise compare --draws" } " states the interval of each change." }
        }
        @for own in paired {
            h3 { "How sure the changes are: " (own.design) " against " (own.reference) }
            (table::markup(&changes(own)))
            p.quiet { (capitalised(&own.basis())) "." }
        }
        @if let Some(intervals) = c.interval_table() { h3 { "Intervals of the levels" } (table::markup(&intervals)) }
        @for line in c.unlike_methods() { p.alarm { (line) "." } }
        h3 { "Ranking" }
        (table::markup(&c.ranking_table()))
        details {
            summary { "Errors of the methods alone" }
            (table::markup(&c.method_table()))
            p.quiet { "Open means no bound. The uncertainty of the design's values is not in these bands." }
            @for (place, name) in c.designs.iter().enumerate() {
                p.quiet { (name) ": by these bands the ranking is " (wording::order(&c.placed(place))) "." }
            }
        }
    }
}

fn inputs(c: &Comparison) -> Markup {
    html! {
        @if c.inputs.is_empty() { p { "None: the designs have the same values." } }
        @else { (table::markup(&c.input_table())) }
    }
}

fn shot(c: &Comparison) -> Markup {
    html! {
        (table::markup(&c.shot_table()))
        p.quiet { "Figures and events that are equal in all designs are not listed." }
    }
}
