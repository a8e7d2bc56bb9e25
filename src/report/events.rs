//! The events of a shot on a page: the loudest first, all others behind them.

use maud::{Markup, html};
use nailnoise_dynamics::network::EventTime;

use super::{chart, table};
use crate::figures::{Chart, Event, Panel, Series, Shape};
use crate::result::{IntervalLevel, RunResult};
use crate::stages::cycle::EventWords;
use crate::tables::cycle;

/// Events that are shown at once.
const SHOWN: usize = 8;

/// Names of the events after which all sources together radiate most, as `t12`: at most eight.
pub(super) fn loudest(result: &RunResult) -> Vec<String> {
    let first = result.ranking.first().map_or(&[][..], |source| &source.intervals);
    let energy = |place: usize| -> f64 {
        let own = result.ranking.iter().filter_map(|source| source.intervals.get(place));
        own.map(IntervalLevel::energy).sum()
    };
    let mut all: Vec<(f64, &str)> = first
        .iter()
        .enumerate()
        .map(|(place, own)| (energy(place), own.from.as_str()))
        .collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    all.into_iter().take(SHOWN).map(|(_, name)| name.to_owned()).collect()
}

/// The symbols of events with their names and times.
pub(super) fn key(events: &[Event], loud: &[String]) -> Markup {
    let is_loud = |event: &&Event| loud.iter().any(|name| crate::figures::symbol(name) == event.symbol);
    let (shown, others): (Vec<&Event>, Vec<&Event>) = events.iter().partition(is_loud);
    let list = |events: &[&Event]| {
        html! {
            ul.key-of-events {
                @for event in events {
                    li {
                        @if event.symbol.replace('_', " ") != event.name { b { (event.symbol) } " " }
                        (event.name) " " span.quiet { (format!("{:.2} ms", event.at)) }
                    }
                }
            }
        }
    };
    html! {
        (list(&shown))
        @if !others.is_empty() { details { summary { "the other " (others.len()) " events" } (list(&others)) } }
    }
}

/// Times of the loudest events, and behind them those of all.
pub(super) fn times(events: &[EventTime], loud: &[String]) -> Markup {
    let loudest: Vec<EventTime> = events
        .iter()
        .filter(|event| loud.contains(&event.name))
        .cloned()
        .collect();
    let (shown, all) = (cycle::events(&loudest), cycle::events(events));
    html! {
        div {
            (table::markup(&shown))
            details { summary { "all " (all.rows.len()) " events" } (table::markup(&all)) }
        }
    }
}

/// Levels between events: the loudest intervals, and behind them the others.
pub(super) fn intervals(chart: &Chart, loud: &[String], words: &EventWords) -> Markup {
    let loud: Vec<String> = loud
        .iter()
        .map(|name| crate::figures::from_event(name, words))
        .collect();
    let part = |name: &str, caption: &str, wanted: bool| Chart {
        name: name.to_owned(),
        caption: caption.to_owned(),
        panels: chart
            .panels
            .iter()
            .map(|panel| rows_of(panel, &|row| loud.contains(row) == wanted))
            .collect(),
        ..chart.clone()
    };
    let shown = part("intervals", &chart.caption, true);
    let others = part("intervals-more", "The intervals that radiate less.", false);
    let count = others
        .panels
        .iter()
        .map(|panel| panel.y.categories.len())
        .sum::<usize>();
    html! {
        (chart::markup(&shown))
        @if count > 0 { details { summary { "the other " (count) " intervals" } (chart::markup(&others)) } }
    }
}

/// A panel of horizontal bars with the rows whose names meet a condition.
fn rows_of(panel: &Panel, wanted: &dyn Fn(&String) -> bool) -> Panel {
    let kept: Vec<usize> = (0..panel.y.categories.len())
        .filter(|row| wanted(&panel.y.categories[*row]))
        .collect();
    let names = kept.iter().map(|row| panel.y.categories[*row].clone()).collect();
    let series = panel.series.iter().map(|own| {
        let of: Vec<(usize, usize)> = (0..own.y.len())
            .filter_map(|index| Some((index, kept.iter().position(|row| *row as f64 == own.y[index])?)))
            .collect();
        let picked = |values: &[f64]| of.iter().filter_map(|(index, _)| values.get(*index).copied()).collect();
        Series {
            x: picked(&own.x),
            y: of.iter().map(|(_, row)| *row as f64).collect(),
            notes: of
                .iter()
                .filter_map(|(index, _)| own.notes.get(*index).cloned())
                .collect(),
            shape: match &own.shape {
                Shape::Bars(marks) => Shape::Bars(picked(marks)),
                other => other.clone(),
            },
            ..own.clone()
        }
    });
    Panel {
        height: 6 * kept.len() as u32,
        y: crate::figures::Axis::categories(panel.y.label.clone(), panel.y.unit, names),
        series: series.collect(),
        x: panel.x.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figures::Axis;

    #[test]
    fn rows_keep_their_bars_marks_and_notes() {
        let bars = Series {
            notes: ["a", "b", "c"].map(str::to_owned).to_vec(),
            ..Series::over("", 0, Shape::Bars(vec![1.0, 2.0, 3.0]), [10.0, 20.0, 30.0].map(Some))
        };
        let panel = Panel {
            x: Axis::new("", "dB", [0.0, 40.0]),
            y: Axis::categories("", "", ["p", "q", "r"].map(str::to_owned).to_vec()),
            height: 18,
            series: vec![bars.sideways()],
        };
        let kept = rows_of(&panel, &|row| row != "q");
        assert_eq!(kept.y.categories, ["p", "r"]);
        let own = &kept.series[0];
        assert_eq!((&own.x[..], &own.y[..]), (&[10.0, 30.0][..], &[0.0, 1.0][..]));
        assert_eq!(own.shape, Shape::Bars(vec![1.0, 3.0]));
        assert_eq!(own.notes, ["a", "c"]);
    }
}
