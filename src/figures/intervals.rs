//! Level of every source between neighbouring events.

use super::canvas::{Anchor, draw};
use super::decibels::{HEADING, LEGEND, LevelPanel, entries, heading, legend};
use super::style::*;
use super::{Figure, symbol};
use crate::result::RunResult;

/// Height of the panel.
const PANEL: i32 = 80 * MM;
/// Levels shown below the highest \[dB\].
const SHOWN: f64 = 60.0;
/// Room under the panel: two rows of events, and the label.
const FOOT: i32 = 18 * MM;

/// "Level per interval and source": bars are the energy radiated in an interval, ticks across them what a measurement
/// that cuts the signal at both events finds. Intervals of no length are left out.
pub(super) fn figure(subject: &str, result: &RunResult) -> Figure {
    let intervals: Vec<usize> = result.ranking.first().map_or_else(Vec::new, |source| {
        let lasting = |(_, interval): &(usize, &crate::result::IntervalLevel)| interval.to_s > interval.from_s;
        source
            .intervals
            .iter()
            .enumerate()
            .filter(lasting)
            .map(|(i, _)| i)
            .collect()
    });
    let sources = entries(result);
    let svg = draw(HEADING + LEGEND + PANEL + FOOT, |canvas| {
        heading(canvas, "Level between events", subject);
        legend(canvas, &sources, HEADING + 4 * MM, true);
        let note = "line: signal cut at the events";
        canvas.text(note, [RIGHT, HEADING + 4 * MM], Anchor::End, GREY);
        let top = HEADING + LEGEND;
        let levels = result.ranking.iter().flat_map(|source| &source.intervals);
        let both = levels
            .flat_map(|interval| [interval.lwa_db, interval.lwa_cut_db])
            .flatten();
        let panel = LevelPanel::new("L_WA,1s in the interval (dB)", [top, top + PANEL], both, SHOWN);
        panel.grid(canvas);
        let count = intervals.len().max(1) as f64;
        let edge = |i: f64| LEFT + (f64::from(RIGHT - LEFT) * i / count).round() as i32;
        for (column, &index) in intervals.iter().enumerate() {
            let (left, right) = (edge(column as f64 + 0.1), edge(column as f64 + 0.9));
            let width = (right - left) / sources.len().max(1) as i32;
            for (place, ((_, colour), source)) in sources.iter().zip(&result.ranking).enumerate() {
                let Some(interval) = source.intervals.get(index) else {
                    continue;
                };
                let from = left + place as i32 * width;
                let to = from + width - MM / 8;
                if let Some(level) = interval.lwa_db {
                    canvas.rectangle([from, panel.at(level)], [to, panel.foot()], *colour, 1.0);
                }
                if let Some(level) = interval.lwa_cut_db.filter(|level| panel.at(*level) < panel.foot()) {
                    canvas.path([[from, panel.at(level)], [to, panel.at(level)]], INK, FRAME);
                }
            }
            let middle = (left + right) / 2;
            let interval = &result.ranking[0].intervals[index];
            let foot = panel.foot();
            canvas.text(&event(&interval.from), [middle, foot + 3 * MM], Anchor::Middle, INK);
            canvas.text(&event(&interval.to), [middle, foot + 7 * MM], Anchor::Middle, INK);
            if column > 0 {
                canvas.path(
                    [[edge(column as f64), foot], [edge(column as f64), foot + TICK]],
                    INK,
                    FRAME,
                );
            }
        }
        canvas.text(
            "Interval: from the upper event to the lower",
            [(LEFT + RIGHT) / 2, panel.foot() + 13 * MM],
            Anchor::Middle,
            INK,
        );
        panel.frame(canvas);
    });
    Figure { name: "intervals", svg }
}

/// `t13` with its number as subscript.
fn event(name: &str) -> String {
    match name.strip_prefix('t').and_then(|number| number.parse().ok()) {
        Some(number) => symbol(number),
        None => name.to_owned(),
    }
}
