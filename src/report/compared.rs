//! The report of a comparison.

use maud::{Markup, html};

use super::chart::markup;
use super::page::{Page, Section};
use super::sound::{self, Recording};
use super::table;
use super::tables::decibels;
use super::typography::{capitalised, typeset, with_code};
use crate::comparison::{Comparison, Labelled, Levels, SourceRow};
use crate::figures::{Axis, BLACK, Chart, Panel, Series, Shape, from_event, of_design};
use crate::study::PairedStudy;
use crate::tables::{dash, study::changes};
use crate::units::Units;
use crate::wording;

/// Range of levels shown below the highest \[dB\].
const SHOWN: f64 = 50.0;

/// `identity` identifies the compared files.
pub(super) fn page(
    c: &Comparison,
    paired: &[PairedStudy],
    (identity, units): (&str, Units),
    recordings: &[Recording],
) -> Page {
    let mut sections = vec![
        Section::new(
            "levels",
            "Levels",
            html! { (markup(&overview(c, paired))) (levels(c, paired, units)) },
        ),
        Section::new("differences", "Differences", inputs(c, units)),
    ];
    if !recordings.is_empty() {
        sections.push(Section::new("listen", "Listen", sound::players(recordings)));
    }
    let charts = |f: &dyn Fn(&SourceRow) -> Option<Chart>| {
        let mut charts: Vec<Chart> = c.sources.iter().filter_map(f).collect();
        share_axes(&mut charts);
        html! { @for chart in &charts { (markup(chart)) } }
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
    sections.push(Section::new("shot", "The shot", shot(c, units)));
    Page {
        title: format!("{}: compared", c.designs.join(", ")),
        compared: Some(identity.to_owned()),
        heading: match c.designs.as_slice() {
            [first, others @ ..] if others.len() > 3 => format!("{first} \u{2194} {} others", others.len()),
            designs => designs.join(" \u{2194} "),
        },
        lead: lead(c, paired),
        sections,
    }
}

fn change(db: Option<f64>) -> String {
    typeset(&dash(db, wording::change))
}

/// Gives all charts the axis of levels of the one with the highest, so that neighbours can be compared.
fn share_axes(charts: &mut [Chart]) {
    let panels = |chart: &mut Chart| std::mem::take(&mut chart.panels);
    let mut all: Vec<Vec<Panel>> = charts.iter_mut().map(panels).collect();
    let axis = |panel: &Panel| {
        if panel.y.categories.is_empty() {
            panel.y.range
        } else {
            panel.x.range
        }
    };
    let highest = all
        .iter()
        .flatten()
        .map(axis)
        .reduce(|a, b| if b[1] > a[1] { b } else { a });
    for panel in all.iter_mut().flatten() {
        let own = if panel.y.categories.is_empty() {
            &mut panel.y
        } else {
            &mut panel.x
        };
        own.range = highest.unwrap_or(own.range);
    }
    for (chart, panels) in charts.iter_mut().zip(all) {
        chart.panels = panels;
    }
}

/// The change of the total from the reference to another design in a sentence, with its interval if draws give it.
fn verdict(c: &Comparison, place: usize, paired: &[PairedStudy]) -> Option<String> {
    let change = c.total.change_db[place]?;
    let (size, side) = (change.abs(), if change < 0.0 { "quieter" } else { "louder" });
    let said = match format!("{size:.1}").as_str() {
        "0.0" => format!("{} is as loud as {}", c.designs[place], c.designs[0]),
        size => format!("{} is {size} dB {side} than {}", c.designs[place], c.designs[0]),
    };
    let drawn = paired
        .get(place - 1)
        .and_then(|own| own.changes.last())
        .and_then(|own| {
            let quantiles =
                [own.change_db.p05, own.change_db.p50, own.change_db.p95].map(|own| dash(own.value, wording::change));
            let quieter = 100.0 * own.quieter.value?;
            let [low, middle, high] = quantiles;
            Some(format!(
                "; over the draws {middle} dB, 90 % of them {low} .. {high} dB, quieter in {quieter:.0} % of them"
            ))
        });
    Some(format!("{said}{}.", drawn.unwrap_or_default()))
}

fn lead(c: &Comparison, paired: &[PairedStudy]) -> Markup {
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
            @if let Some(verdict) = verdict(c, place, paired) { p.verdict { (typeset(&verdict)) } }
            @let ranking = &c.rankings[place];
            @if *ranking != c.rankings[0] {
                p.verdict { "The ranking changes: in " b { (name) } " it is " (ranking.join(", ")) "; in "
                    (c.designs[0]) " " (c.rankings[0].join(", ")) "." }
            }
        }
        p.quiet { "L" sub { "WA,1s" } " re 1 pW s: A-weighted sound energy of one shot; changes are from the first \
            design. 3 dB less is half of the sound energy; 10 dB less is a tenth of it, and sounds about half as \
            loud." }
        p.quiet {
            "Absolute levels are predictions; the page Validation of the documentation compares those of one tool with \
             published tests. Differences between designs of one tool are more reliable than levels."
        }
    }
}

/// Error bars of each design over the rows of the first chart, and their meaning: of its change over common draws, or
/// else of its level over the draws of its study.
fn errors(c: &Comparison, place: usize, paired: &[PairedStudy]) -> Option<Vec<[f64; 2]>> {
    let names: Vec<&str> = c
        .sources
        .iter()
        .map(|row| row.source.as_str())
        .chain(["total"])
        .collect();
    let unknown = [f64::NAN; 2];
    if !paired.is_empty() {
        let own = paired.get(place.checked_sub(1)?)?;
        let rows = c.sources.iter().map(|row| &row.levels).chain([&c.total]);
        let ends = |(name, levels): (&&str, &Levels)| {
            let change = own.changes.iter().find(|own| own.source == **name)?;
            let reference = levels.level_db[0]?;
            Some([
                reference + change.change_db.p05.value?,
                reference + change.change_db.p95.value?,
            ])
        };
        return Some(names.iter().zip(rows).map(|own| ends(own).unwrap_or(unknown)).collect());
    }
    let study = c.studies[place].as_ref()?;
    let ends = |name: &&str| {
        let spread = study.spread(name);
        Some([spread.low_db?, spread.high_db?])
    };
    Some(names.iter().map(|name| ends(name).unwrap_or(unknown)).collect())
}

/// Levels of all sources and of the total for each design.
fn overview(c: &Comparison, paired: &[PairedStudy]) -> Chart {
    let rows = c.sources.iter().map(|row| (row.source.as_str(), &row.levels));
    let mut panel = bars(
        c,
        "Source",
        "",
        "L_{WA,1s}",
        rows.chain([("total", &c.total)]).collect(),
    );
    let bars = std::mem::take(&mut panel.series);
    for (place, bar) in bars.into_iter().enumerate() {
        panel.series.push(bar);
        panel.series.extend(errors(c, place, paired).map(|ends| {
            let none = std::iter::repeat_n(None, ends.len());
            Series::over("", BLACK, Shape::Errors(ends), none)
        }));
    }
    let highest = panel.series.iter().filter_map(|own| match &own.shape {
        Shape::Errors(ends) => ends
            .iter()
            .map(|[_, high]| *high)
            .filter(|high| high.is_finite())
            .reduce(f64::max),
        _ => None,
    });
    if let Some(highest) = highest.reduce(f64::max).filter(|highest| *highest > panel.y.range[1]) {
        let raised = 5.0 * ((highest - panel.y.range[1]) / 5.0).ceil();
        panel.y.range = panel.y.range.map(|end| end + raised);
    }
    let intervals = match (paired.is_empty(), c.studies.iter().any(Option::is_some)) {
        (false, _) => " Lines: P5 to P95 of the change over common draws, from the level of the first design.",
        (true, true) => " Lines: interval of the level over the draws of the design\u{2019}s study.",
        (true, false) => "",
    };
    let caption = format!(
        "A-weighted levels of each source and of all together, dB re 1 pW s. The bars begin at the lower edge of the \
         axis: a level has no zero of its own.{intervals}"
    );
    chart(c, "overview".to_owned(), caption, panel)
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
            .map(|l| from_event(l.label.split('-').next().unwrap_or_default(), &c.event_words));
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

fn levels(c: &Comparison, paired: &[PairedStudy], units: Units) -> Markup {
    html! {
        (table::markup(&c.level_table()))
        @if let Some(performance) = c.performance_table() {
            h3 { "What it costs" }
            (table::markup(&performance.in_units(units)))
        }
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

fn inputs(c: &Comparison, units: Units) -> Markup {
    html! {
        @if c.inputs.is_empty() { p { (c.no_difference()) } }
        @else { (table::markup(&c.input_table().in_units(units))) }
    }
}

fn shot(c: &Comparison, units: Units) -> Markup {
    html! {
        (table::markup(&c.shot_table().in_units(units)))
        p.quiet { "Figures and events that are equal in all designs are not listed." }
    }
}
