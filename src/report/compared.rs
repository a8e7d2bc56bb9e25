//! The report of a comparison.

use maud::{Markup, html};

use super::chart::markup;
use super::head::capitalised;
use super::page::{Page, Section};
use super::sound::{self, Recording};
use super::tables::{decibels, plain, with_code, with_legend};
use crate::comparison::{Comparison, Labelled, Levels, SourceRow, ValueRow};
use crate::figures::{Axis, Chart, Panel, Series, Shape, from_event, of_design};
use crate::output::event_name;
use crate::wording::{self, readable};

/// Levels shown below the highest \[dB\].
const SHOWN: f64 = 50.0;

pub(super) fn page(c: &Comparison, identity: &str, recordings: &[Recording]) -> Page {
    let mut sections = vec![
        Section::new("levels", "Levels", html! { (markup(&overview(c))) (levels(c)) }),
        Section::new("differences", "Differences", inputs(c)),
    ];
    if !recordings.is_empty() {
        sections.push(Section::new("listen", "Listen", sound::players(recordings)));
    }
    let charts = |f: &dyn Fn(&SourceRow) -> Option<Chart>| html! { @for row in &c.sources { @if let Some(chart) = f(row) { (markup(&chart)) } } };
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
    db.map_or_else(
        || "\u{2013}".to_owned(),
        |db| wording::change(db).replace('-', "\u{2212}"),
    )
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

/// Levels of all sources and the total by design.
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

/// One series of bars a design over the labels.
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

/// Levels of a source in its bands or intervals; none if it is silent in all of them.
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
        // Each interval by the event at its start.
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

fn levels(c: &Comparison) -> Markup {
    let rows: Vec<(&str, &Levels, bool)> = c
        .sources
        .iter()
        .map(|row| (row.source.as_str(), &row.levels, false))
        .chain([("total", &c.total, true)])
        .collect();
    html! {
        div.scroll { table.pinned {
            thead { tr { th { "source" } @for name in &c.designs { th.n { (name) } }
                @for name in c.designs.iter().skip(1) { th.n { "change, " (name) } } } }
            tbody { @for (name, levels, sum) in rows { tr.sum[sum] {
                th scope="row" { (name) }
                @for level in &levels.level_db { td.n { b { (decibels(*level)) } } }
                @for db in levels.change_db.iter().skip(1) { td.n { (change(*db)) } }
            } } }
        } }
        @if let Some(intervals) = c.intervals() { h3 { "Intervals of the levels" } (with_legend(&intervals)) }
        @else {
            p.quiet { "How sure a level is depends on the values of its design first: "
                code { "nailnoise compare --draws" } " states the interval of each change." }
        }
        @for row in &c.sources {
            @let methods: Vec<&str> = row.methods.iter().flatten().map(String::as_str).collect();
            @if methods.windows(2).any(|pair| pair[0] != pair[1]) {
                p.alarm { (row.source) ": computed by different methods (" (methods.join("; "))
                    "), whose errors do not cancel in the change." }
            }
        }
        h3 { "Ranking" }
        div.scroll { table.pinned {
            thead { tr { th { "place" } @for name in &c.designs { th { (name) } } } }
            tbody { @for place in 0..c.rankings.iter().map(Vec::len).max().unwrap_or(0) { tr {
                td { (place + 1) } @for ranking in
                &c.rankings { td { (ranking.get(place).map_or("", String::as_str)) } }
            } } }
        } }
        details {
            summary { "Errors of the methods alone" }
            div.scroll { table.pinned {
                thead { tr { th { "source" } @for name in &c.designs { th.n { (name) ", dB" } } } }
                tbody { @for row in &c.sources { tr {
                    th scope="row" { (row.source) }
                    @for bounds in &row.uncertainty_db { td.n { (wording::band(*bounds).replace('-', "\u{2212}")) } }
                } } }
            } }
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
        @else { div.scroll { table.pinned {
            thead { tr { th { "key" } th { "unit" } @for name in &c.designs { th { (name) } } } }
            tbody { @for row in &c.inputs { tr {
                td.key-name { (row.key) } td { (row.unit) } @for value in &row.values { td { (plain(value)) } }
            } } }
        } } }
    }
}

fn shot(c: &Comparison) -> Markup {
    let differs = |row: &&ValueRow| {
        row.values.iter().any(|value| match (value, row.values[0]) {
            (Some(a), Some(b)) => (a - b).abs() > 1e-6 * a.abs().max(b.abs()),
            (a, b) => a.is_some() != b.is_some(),
        })
    };
    let cell = |value: Option<f64>| value.map_or_else(|| "\u{2013}".to_owned(), |value| plain(&value.into()));
    html! {
        div.scroll { table.pinned {
            thead { tr { th { "figure" } @for name in &c.designs { th.n { (name) } } } }
            tbody {
                tr { th scope="row" { "outcome" } @for outcome in &c.outcomes { td.n { (outcome.replace('_', " ")) } } }
                @for row in c.cycle.iter().filter(differs) { tr {
                    @let (unit, factor) = readable(row.unit);
                    th scope="row" { (row.name.replace('_', " ")) @if !unit.is_empty() { ", " (unit) } }
                    @for value in &row.values { td.n { (cell(value.map(|value| factor * value))) } }
                } }
                @for row in c.events.iter().filter(differs) { tr {
                    th scope="row" { (event_name(&row.name)) ", ms" }
                    @for value in &row.values { td.n { (cell(value.map(|t| 1e3 * t))) } }
                } }
            }
        } }
        p.quiet { "Figures and events that are equal in all designs are not listed." }
    }
}
