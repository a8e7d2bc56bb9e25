//! A figure: panels below each other over one horizontal axis, with a legend over each and events across all.

use plotters::style::RGBColor;

use super::canvas::{Anchor, Canvas, draw};
use super::decimate::decimate;
use super::scale::{Scale, ticks};
use super::spread::spread;
use super::style::*;

/// What is drawn, before it has a place on paper.
pub(super) struct Sheet<'a> {
    /// Heading, left.
    pub(super) title: &'static str,
    /// What it is of, right.
    pub(super) subject: String,
    /// Label of the horizontal axis.
    pub(super) x_label: &'static str,
    /// Its ends.
    pub(super) x_range: [f64; 2],
    /// Abscissas and labels of events, in order.
    pub(super) events: Vec<(f64, String)>,
    /// Panels, from the top.
    pub(super) panels: Vec<Panel<'a>>,
}

/// One pair of axes.
pub(super) struct Panel<'a> {
    /// Label of the vertical axis.
    pub(super) y_label: &'static str,
    /// Its ends.
    pub(super) y_range: [f64; 2],
    /// Height of the frame \[mm\].
    pub(super) height: i32,
    /// Curves; the first lies on top.
    pub(super) curves: Vec<Curve<'a>>,
    /// Horizontal lines.
    pub(super) levels: Vec<Level>,
    /// Bars along the lower edge.
    pub(super) spans: Vec<Span>,
}

/// A line with its entry in the legend.
pub(super) struct Curve<'a> {
    pub(super) label: String,
    pub(super) colour: RGBColor,
    /// Abscissas, not falling.
    pub(super) x: &'a [f64],
    /// Ordinates; the line has a gap where they are not a number.
    pub(super) y: Vec<f64>,
    /// Lower and upper edge of a band around the line; may be empty.
    pub(super) band: Vec<[f64; 2]>,
}

/// A dashed horizontal line with its name at the right end.
pub(super) struct Level {
    pub(super) label: String,
    pub(super) value: f64,
    /// Whether the name stands above the line or below it.
    pub(super) above: bool,
}

/// A bar along the lower edge of a panel; spans of one colour stand in one row.
pub(super) struct Span {
    pub(super) x: [f64; 2],
    pub(super) colour: RGBColor,
    /// Row, from the bottom.
    pub(super) row: i32,
}

/// Height of the heading.
const HEADING: i32 = 7 * MM;
/// Height of the row of event labels, and of the lines that lead from them to their events.
const LABELS: i32 = 4 * MM;
const LEADERS: i32 = 4 * MM;
/// Smallest distance of event labels.
const LABEL_GAP: i32 = 5 * MM;
/// Distance of the first legend's line of type from what is above it, and of the frame from the last one.
const ABOVE_LEGEND: i32 = 4 * MM;
const BELOW_LEGEND: i32 = 3 * MM;
/// Room for the horizontal axis' numbers and label.
const FOOT: i32 = 12 * MM;
/// Length of a line in the legend, its distance from its text, and of entries from each other.
const SAMPLE: i32 = 6 * MM;
const SAMPLE_GAP: i32 = MM + MM / 2;
const ENTRY_GAP: i32 = 5 * MM;

/// Where a panel stands.
struct Place {
    legend: i32,
    top: i32,
    bottom: i32,
}

impl Sheet<'_> {
    /// The figure as SVG.
    pub(super) fn svg(&self) -> String {
        let (places, height) = self.layout();
        draw(height, |canvas| self.paint(canvas, &places))
    }

    fn layout(&self) -> (Vec<Place>, i32) {
        let mut y = HEADING;
        let mut places = Vec::new();
        for (index, panel) in self.panels.iter().enumerate() {
            let legend = y + ABOVE_LEGEND;
            let rows = panel.legend().last().map_or(0, |(_, [_, row])| row + 1);
            let mut top = if rows == 0 {
                y + ABOVE_LEGEND
            } else {
                legend + (rows - 1) * LEADING + BELOW_LEGEND
            };
            if index == 0 && !self.events.is_empty() {
                top += LABELS + LEADERS;
            }
            let bottom = top + panel.height * MM;
            places.push(Place { legend, top, bottom });
            y = bottom;
        }
        (places, y + FOOT)
    }

    fn paint(&self, canvas: &mut Canvas<'_>, places: &[Place]) {
        let (Some(first), Some(last)) = (places.first(), places.last()) else {
            return;
        };
        canvas.bold(self.title, [LEFT, 4 * MM], Anchor::Start, INK);
        canvas.text(&self.subject, [RIGHT, 4 * MM], Anchor::End, GREY);
        let x = Scale {
            values: self.x_range,
            units: [LEFT, RIGHT],
        };
        self.label_events(canvas, &x, first.top);
        let events: Vec<i32> = self.events.iter().map(|(time, _)| x.at(*time)).collect();
        let (round, decimals) = ticks(self.x_range, 9);
        for (index, (panel, place)) in self.panels.iter().zip(places).enumerate() {
            if self.panels.len() > 1 {
                let letter = char::from(b'a' + index as u8).to_string();
                canvas.bold(&letter, [3 * MM, place.legend], Anchor::Start, INK);
            }
            panel.paint(canvas, &x, place, &events);
            for value in &round {
                let at = x.at(*value);
                canvas.path([[at, place.bottom], [at, place.bottom + TICK]], INK, FRAME);
            }
        }
        for value in &round {
            let at = [x.at(*value), last.bottom + 3 * MM];
            canvas.text(&format!("{value:.decimals$}"), at, Anchor::Middle, INK);
        }
        canvas.text(
            self.x_label,
            [(LEFT + RIGHT) / 2, last.bottom + 8 * MM],
            Anchor::Middle,
            INK,
        );
    }

    /// The row of labels over the first panel, with lines to where the events are.
    fn label_events(&self, canvas: &mut Canvas<'_>, x: &Scale, top: i32) {
        let wanted: Vec<i32> = self.events.iter().map(|(time, _)| x.at(*time)).collect();
        let placed = spread(&wanted, LABEL_GAP, [LEFT, RIGHT]);
        for ((at, label), (_, text)) in wanted.iter().zip(placed).zip(&self.events) {
            let middle = top - LEADERS - LABELS / 2;
            canvas.text(text, [label, middle], Anchor::Middle, GREY);
            canvas.path(
                [[label, top - LEADERS + MM / 4], [*at, top - MM], [*at, top]],
                PALE,
                HAIR,
            );
        }
    }
}

impl Panel<'_> {
    fn paint(&self, canvas: &mut Canvas<'_>, x: &Scale, place: &Place, events: &[i32]) {
        let y = Scale {
            values: self.y_range,
            units: [place.bottom, place.top],
        };
        let (round, decimals) = ticks(self.y_range, (self.height / 9).max(2) as usize);
        for value in &round {
            let at = y.at(*value);
            canvas.path([[LEFT, at], [RIGHT, at]], FAINT, HAIR);
            canvas.path([[LEFT - TICK, at], [LEFT, at]], INK, FRAME);
            let text = format!("{value:.decimals$}").replace('-', "\u{2212}");
            canvas.text(&text, [LEFT - TICK - MM / 2, at], Anchor::End, INK);
        }
        for event in events {
            canvas.path([[*event, place.top], [*event, place.bottom]], PALE, HAIR);
        }
        let lines: Vec<Vec<Vec<[i32; 2]>>> = self.curves.iter().map(|curve| curve.lines(x, &y)).collect();
        for level in &self.levels {
            canvas.dashes([LEFT, RIGHT], y.at(level.value), GREY, FRAME);
        }
        self.name_levels(canvas, &y, &lines);
        for span in &self.spans {
            let middle = place.bottom - MM - span.row * (MM + MM / 2);
            let [from, to] = span.x.map(|value| x.at(value));
            canvas.rectangle([from, middle - MM / 2], [to, middle + MM / 2], span.colour, 1.0);
        }
        for curve in self.curves.iter().rev() {
            curve.shade(canvas, x, &y);
        }
        for (curve, lines) in self.curves.iter().zip(lines).rev() {
            lines
                .into_iter()
                .for_each(|line| canvas.path(line, curve.colour, CURVE));
        }
        let frame = [
            [LEFT, place.top],
            [RIGHT, place.top],
            [RIGHT, place.bottom],
            [LEFT, place.bottom],
            [LEFT, place.top],
        ];
        canvas.path(frame, INK, FRAME);
        canvas.upwards(self.y_label, [5 * MM, (place.top + place.bottom) / 2], INK);
        for (curve, [left, row]) in self.curves.iter().zip(self.legend().into_iter().map(|(_, at)| at)) {
            let middle = place.legend + row * LEADING;
            canvas.path([[left, middle], [left + SAMPLE, middle]], curve.colour, CURVE);
            canvas.text(&curve.label, [left + SAMPLE + SAMPLE_GAP, middle], Anchor::Start, INK);
        }
    }

    /// Writes the names of levels beside their lines, where they cover least of the curves.
    fn name_levels(&self, canvas: &mut Canvas<'_>, y: &Scale, lines: &[Vec<Vec<[i32; 2]>>]) {
        let mut taken: Vec<Room> = Vec::new();
        for level in &self.levels {
            let (width, at) = (width(&level.label), y.at(level.value));
            let sides = if level.above { [-1, 1] } else { [1, -1] };
            // The estimate of the width may be short of the reader's font: text grows away from the frame.
            let places = [
                (RIGHT - MM - width, Anchor::End),
                (LEFT + MM, Anchor::Start),
                ((LEFT + RIGHT - width) / 2, Anchor::Middle),
            ];
            let boxes = sides
                .into_iter()
                .flat_map(|side| places.map(|(left, anchor)| (Room::beside(at, side, [left, left + width]), anchor)));
            let others = || {
                self.levels
                    .iter()
                    .map(|other| y.at(other.value))
                    .filter(|other| *other != at)
            };
            let covered = |label: &Room| {
                let crossed = others()
                    .filter(|other| label.y[0] < *other && *other < label.y[1])
                    .count();
                let outside = !(y.units[1]..=y.units[0]).contains(&label.y[0]) || label.y[1] > y.units[0];
                let clash = taken.iter().any(|other| other.meets(label)) || outside;
                let curves: usize = lines.iter().flatten().map(|line| label.covers(line)).sum();
                curves + crossed + if clash { 1000 } else { 0 }
            };
            if let Some((label, anchor)) = boxes.min_by_key(|(label, _)| covered(label)) {
                let x = match anchor {
                    Anchor::Start => label.x[0],
                    Anchor::Middle => (label.x[0] + label.x[1]) / 2,
                    Anchor::End => label.x[1],
                };
                canvas.text(&level.label, [x, (label.y[0] + label.y[1]) / 2], anchor, GREY);
                taken.push(label);
            }
        }
    }

    /// Left edge and row of each curve's entry in the legend.
    fn legend(&self) -> Vec<(usize, [i32; 2])> {
        let (mut left, mut row) = (LEFT, 0);
        let mut entries = Vec::new();
        for (index, curve) in self.curves.iter().enumerate() {
            let width = SAMPLE + SAMPLE_GAP + width(&curve.label);
            if left > LEFT && left + width > RIGHT {
                (left, row) = (LEFT, row + 1);
            }
            entries.push((index, [left, row]));
            left += width + ENTRY_GAP;
        }
        entries
    }
}

impl Curve<'_> {
    /// The unbroken lines of the curve on the grid.
    fn lines(&self, x: &Scale, y: &Scale) -> Vec<Vec<[i32; 2]>> {
        let mut lines = vec![Vec::new()];
        for (a, b) in self.x.iter().zip(&self.y) {
            match lines.last_mut() {
                Some(line) if b.is_finite() && x.holds(*a) => line.push([x.at(*a), y.at(*b)]),
                Some(line) if line.is_empty() => {}
                _ => lines.push(Vec::new()),
            }
        }
        lines.into_iter().filter(|line| line.len() > 1).map(decimate).collect()
    }

    fn shade(&self, canvas: &mut Canvas<'_>, x: &Scale, y: &Scale) {
        if self.band.is_empty() {
            return;
        }
        let edge = |side: usize| {
            self.x
                .iter()
                .zip(&self.band)
                .map(move |(a, band)| [x.at(*a), y.at(band[side])])
        };
        let lower: Vec<[i32; 2]> = edge(0).collect();
        canvas.polygon(lower.into_iter().rev().chain(edge(1)), self.colour, 0.13);
    }
}

/// Width of a text, estimated.
fn width(text: &str) -> i32 {
    (text.chars().count() as f64 * f64::from(TYPE) * ADVANCE) as i32
}

/// The room that a text takes.
struct Room {
    x: [i32; 2],
    y: [i32; 2],
}

impl Room {
    /// Room for a text below (1) or above (-1) the line at `y`.
    fn beside(y: i32, side: i32, x: [i32; 2]) -> Self {
        let middle = y + side * 2 * MM;
        Self {
            x,
            y: [middle - TYPE / 2, middle + TYPE / 2],
        }
    }

    fn meets(&self, other: &Self) -> bool {
        let overlap = |a: [i32; 2], b: [i32; 2]| a[0] < b[1] && b[0] < a[1];
        overlap(self.x, other.x) && overlap(self.y, other.y)
    }

    /// How many pieces of a line go through the room, judged by each piece's own bounds.
    fn covers(&self, line: &[[i32; 2]]) -> usize {
        let span = |a: i32, b: i32| [a.min(b) - 1, a.max(b) + 1];
        let piece = |pair: &[[i32; 2]]| Self {
            x: span(pair[0][0], pair[1][0]),
            y: span(pair[0][1], pair[1][1]),
        };
        line.windows(2).filter(|pair| self.meets(&piece(pair))).count()
    }
}
