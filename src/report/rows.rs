//! Charts with a row for each category: horizontal bars to the right of their names, or below them in a narrow window.

use maud::{Markup, html};

use super::axis::{labels, percent};
use super::legend::legend;
use super::typography::with_subscripts;
use crate::figures::path::{RowBar, row_bars, sharing};
use crate::figures::ticks::across;
use crate::figures::{Panel, Series};

/// Height of a bar that shares its row, and of one alone in its row \[px\].
const THIN: usize = 7;
const THICK: usize = 15;

pub(super) fn markup(panel: &Panel) -> Markup {
    let ticks = across(&panel.x);
    let shared = sharing(panel);
    let height = if shared > 1 { THIN * shared + 5 } else { THICK + 5 };
    html! {
        div.panel.of-rows {
            @if panel.series.len() > 1 { (legend(panel)) }
            p.axis { (with_subscripts(&panel.y.title())) }
            div.rows {
                @for (row, name) in panel.y.categories.iter().enumerate() {
                    @let bars = row_bars(panel, row);
                    @let in_words = words(panel, row, &bars);
                    div.row title=[in_words.as_deref()] {
                        span.name {
                            (with_subscripts(name))
                            @if let Some(words) = &in_words { span.unseen { ": " (words) } }
                        }
                        div.track style={ "height:" (height) "px" } {
                            @for tick in &ticks { i.grid style={ "left:" (percent(tick.at)) } {} }
                            @for bar in &bars { (one(bar, shared)) }
                        }
                    }
                }
                div.row.foot aria-hidden="true" { span.name {} div.xs { (labels(&ticks, "left")) } }
            }
            p.axis.below { (with_subscripts(&panel.x.title())) }
        }
    }
}

fn one(bar: &RowBar<'_>, shared: usize) -> Markup {
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

/// Text of a row for screen readers.
fn words(panel: &Panel, row: usize, bars: &[RowBar<'_>]) -> Option<String> {
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
