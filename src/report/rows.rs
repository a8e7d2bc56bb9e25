//! Charts with a row for each category: horizontal bars next to their names, or below them in a narrow window.

use maud::{Markup, html};

use super::axis::{across, labels, percent};
use super::legend::{legend, marked};
use crate::figures::{Panel, Series, Shape};

/// Height of a bar among others, and of one that has its row for itself \[px\].
const THIN: usize = 7;
const THICK: usize = 15;

/// A bar of a row.
struct Bar<'a> {
    place: usize,
    colour: usize,
    /// Its ends as parts of the axis.
    ends: [f64; 2],
    mark: Option<f64>,
    note: Option<&'a str>,
}

pub(super) fn markup(panel: &Panel) -> Markup {
    let ticks = across(&panel.x);
    // Spans take turns in their rows; series of bars and swings share them.
    let shared = panel
        .series
        .iter()
        .filter(|own| matches!(own.shape, Shape::Bars(_) | Shape::Swings(_)))
        .count();
    let height = if shared > 1 { THIN * shared + 5 } else { THICK + 5 };
    html! {
        div.panel.of-rows {
            @if panel.series.len() > 1 { (legend(panel)) }
            p.axis { (marked(&panel.y.title())) }
            div.rows {
                @for (row, name) in panel.y.categories.iter().enumerate() {
                    @let bars = bars(panel, row);
                    @let in_words = words(panel, row, &bars);
                    div.row title=[in_words.as_deref()] {
                        span.name { (marked(name)) @if let Some(words) = &in_words { span.unseen { ": " (words) } } }
                        div.track style={ "height:" (height) "px" } {
                            @for tick in &ticks { i.grid style={ "left:" (percent(tick.at)) } {} }
                            @for bar in &bars { (one(bar, shared)) }
                        }
                    }
                }
                div.row.foot aria-hidden="true" { span.name {} div.xs { (labels(&ticks, "left")) } }
            }
            p.axis.below { (marked(&panel.x.title())) }
        }
    }
}

fn one(bar: &Bar<'_>, shared: usize) -> Markup {
    let [from, to] = bar.ends;
    let (top, height) = if shared > 1 {
        (2 + THIN * bar.place, THIN - 1)
    } else {
        (2, THICK)
    };
    let place = format!("top:{top}px;height:{height}px");
    html! {
        i class={ "bar c" (bar.colour) } data-series=(bar.place)
            style={ "left:" (percent(from)) ";width:" (percent(to - from)) ";" (place) } {}
        @if let Some(mark) = bar.mark { i.mark data-series=(bar.place)
            style={ "left:" (percent(mark)) ";" (place) } {} }
        @if let Some(note) = bar.note { span.note style={ "left:" (percent(to)) } { (note) } }
    }
}

/// The bars of a row.
fn bars(panel: &Panel, row: usize) -> Vec<Bar<'_>> {
    let [low, high] = panel.x.range;
    let of = |value: f64| ((value - low) / (high - low)).clamp(0.0, 1.0);
    let mut found = Vec::new();
    for (place, series) in panel.series.iter().enumerate() {
        for index in (0..series.y.len()).filter(|&index| series.y[index] as usize == row) {
            let value = series.x[index];
            let (from, mark) = match &series.shape {
                Shape::Spans(from) | Shape::Swings(from) => (from[index], None),
                Shape::Bars(marks) => (low, marks.get(index).copied().filter(|mark| *mark > low)),
                _ => continue,
            };
            if value.is_finite() && (value > low || !matches!(series.shape, Shape::Bars(_))) {
                found.push(Bar {
                    place,
                    colour: series.colour,
                    ends: [of(from.min(value)), of(from.max(value))],
                    mark: mark.map(of),
                    note: note(series, index),
                });
            }
        }
    }
    found
}

/// Text after a bar: bars that share a row have no room for it.
fn note(series: &Series, index: usize) -> Option<&str> {
    let own = series.notes.get(index).map(String::as_str);
    own.filter(|_| matches!(series.shape, Shape::Spans(_)) || series.name.is_empty())
}

/// A row in words, for those who see no bars.
fn words(panel: &Panel, row: usize, bars: &[Bar<'_>]) -> Option<String> {
    if bars.iter().any(|bar| bar.note.is_some()) {
        return None;
    }
    let word = |series: &Series| {
        let index = series.y.iter().position(|place| *place as usize == row)?;
        let note = series.notes.get(index)?;
        Some(format!("{} {note}", series.name))
    };
    let words: Vec<String> = panel.series.iter().filter_map(word).collect();
    (!words.is_empty()).then(|| words.join("; "))
}
