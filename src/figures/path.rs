//! Series as SVG paths, and as horizontal bars.

use std::fmt::Write as _;

use super::chart::{Panel, Series, Shape};

/// Size of the box that contains a plot, in the units of its coordinates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame {
    /// From the left to the right end of the horizontal axis.
    pub(crate) across: f64,
    /// From the lower to the upper end of the vertical axis.
    pub(crate) up: f64,
}

/// Fraction of a category's width that its bars take.
const FILLED: f64 = 0.8;

impl Frame {
    /// The paths of a series, each with its class; `place` is the index of the series in the panel. Coordinates start
    /// in the upper left corner.
    pub(crate) fn paths(&self, panel: &Panel, place: usize, series: &Series) -> Vec<(&'static str, String)> {
        let at = |x: f64, y: f64| [self.x(panel, x), self.y(panel, y)];
        let points = || series.x.iter().copied().zip(series.y.iter().copied());
        let curve = || line(points().map(|(x, y)| y.is_finite().then(|| at(x, y))));
        match &series.shape {
            Shape::Line => vec![("line", curve())],
            Shape::Broad => vec![("broad", curve())],
            Shape::Dashed => vec![("dashed", curve())],
            Shape::Points => {
                let mut d = String::new();
                let finite = points().filter(|(x, y)| x.is_finite() && y.is_finite());
                for [x, y] in finite.map(|(x, y)| at(x, y)) {
                    // A line of zero length with round ends is drawn as a dot, however the box is stretched.
                    let _ = write!(d, "M{x} {y}h0");
                }
                vec![("dots", d)]
            }
            Shape::Steps => {
                let ends = |(x, y): (f64, f64)| [0.0, 1.0].map(|end| y.is_finite().then(|| at(x + end, y)));
                vec![("line", line(points().flat_map(ends)))]
            }
            Shape::Band(lower) => {
                let back = series.x.iter().copied().zip(lower.iter().copied()).rev();
                let all = points().chain(back).filter(|(_, y)| y.is_finite());
                vec![("spread", format!("{}z", line(all.map(|(x, y)| Some(at(x, y))))))]
            }
            Shape::Bars(marks) => {
                let floor = panel.y.range[0];
                let bars = points().map(|(x, y)| (x, [floor, y]));
                let marks = series.x.iter().copied().zip(marks.iter().copied());
                vec![
                    ("area", self.boxes(panel, place, bars)),
                    (
                        "mark",
                        self.across(panel, place, marks.filter(|(_, mark)| *mark > floor)),
                    ),
                ]
            }
            Shape::Whiskers(ends) => {
                let bars = points().zip(ends).filter(|((_, y), _)| y.is_finite());
                vec![
                    ("pale", self.boxes(panel, place, bars.map(|((x, _), ends)| (x, *ends)))),
                    ("mark", self.across(panel, place, points())),
                ]
            }
            Shape::Errors(ends) => {
                let mut d = String::new();
                let finite = |[low, high]: &[f64; 2]| low.is_finite() && high.is_finite();
                for (x, ends) in series.x.iter().zip(ends).filter(|(_, ends)| finite(ends)) {
                    let [left, right] = self.sides(panel, place.saturating_sub(1), *x);
                    let (middle, cap) = ((left + right) / 2, (right - left) / 6);
                    let [low, high] = ends.map(|y| self.y(panel, y));
                    let [from, to] = [middle - cap, middle + cap];
                    let _ = write!(d, "M{middle} {low}V{high}M{from} {low}H{to}M{from} {high}H{to}");
                }
                vec![("mark", d)]
            }
            // Horizontal bars are drawn as rows.
            Shape::Spans(_) | Shape::Swings(_) => Vec::new(),
        }
    }

    fn x(&self, panel: &Panel, x: f64) -> i64 {
        let [low, high] = panel.x.range;
        (self.across * (x - low) / (high - low)).round() as i64
    }

    /// Limited to the surroundings of the box, because distant points would only lengthen the numbers.
    fn y(&self, panel: &Panel, y: f64) -> i64 {
        let [low, high] = panel.y.range;
        let y = self.up * (1.0 - (y - low) / (high - low));
        y.clamp(-self.up, 2.0 * self.up).round() as i64
    }

    /// Left and right end of the bar of a series in a category; the bars of several series are next to each other.
    fn sides(&self, panel: &Panel, place: usize, x: f64) -> [i64; 2] {
        let is_bar = |series: &&Series| matches!(series.shape, Shape::Bars(_) | Shape::Whiskers(_));
        let before = panel.series[..place].iter().filter(is_bar).count() as f64;
        let width = FILLED / panel.series.iter().filter(is_bar).count().max(1) as f64;
        let start = x + 0.5 * (1.0 - FILLED) + before * width;
        [self.x(panel, start), self.x(panel, start + 0.92 * width)]
    }

    fn boxes(&self, panel: &Panel, place: usize, bars: impl Iterator<Item = (f64, [f64; 2])>) -> String {
        let mut d = String::new();
        for (x, [low, high]) in bars.filter(|(_, [low, high])| high > low) {
            let [left, right] = self.sides(panel, place, x);
            let [low, high] = [low, high].map(|y| self.y(panel, y));
            let _ = write!(d, "M{left} {low}V{high}H{right}V{low}z");
        }
        d
    }

    fn across(&self, panel: &Panel, place: usize, marks: impl Iterator<Item = (f64, f64)>) -> String {
        let mut d = String::new();
        for (x, y) in marks.filter(|(_, y)| y.is_finite()) {
            let [left, right] = self.sides(panel, place, x);
            let _ = write!(d, "M{left} {}H{right}", self.y(panel, y));
        }
        d
    }
}

/// A line through points, interrupted at missing ones. Relative steps between the points keep the text short.
fn line(points: impl Iterator<Item = Option<[i64; 2]>>) -> String {
    let mut d = String::new();
    let mut last: Option<[i64; 2]> = None;
    for point in points {
        match (last, point) {
            (None, Some([x, y])) => {
                // A dot if the line has only one point.
                let _ = write!(d, "M{x} {y}l0 0");
            }
            (Some([x0, y0]), Some([x, y])) if [x0, y0] != [x, y] => {
                let _ = write!(d, " {} {}", x - x0, y - y0);
            }
            _ => {}
        }
        last = point;
    }
    d
}

/// A bar in a row, which is a category of the vertical axis.
pub(crate) struct RowBar<'a> {
    /// Index of its series in the panel.
    pub(crate) place: usize,
    /// Index of its colour in the palette.
    pub(crate) colour: usize,
    /// Its ends as fractions of the horizontal axis.
    pub(crate) ends: [f64; 2],
    /// A mark across it, as a fraction of the axis.
    pub(crate) mark: Option<f64>,
    /// Text after the bar.
    pub(crate) note: Option<&'a str>,
}

/// Number of series whose bars share each row; spans take turns in their rows.
pub(crate) fn sharing(panel: &Panel) -> usize {
    let shares = |own: &&Series| matches!(own.shape, Shape::Bars(_) | Shape::Swings(_));
    panel.series.iter().filter(shares).count()
}

/// The bars of a row.
pub(crate) fn row_bars(panel: &Panel, row: usize) -> Vec<RowBar<'_>> {
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
                found.push(RowBar {
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

/// Text after a bar; bars that share a row have no room for it.
fn note(series: &Series, index: usize) -> Option<&str> {
    let own = series.notes.get(index).map(String::as_str);
    own.filter(|_| matches!(series.shape, Shape::Spans(_)) || series.name.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figures::chart::Axis;

    const FRAME: Frame = Frame {
        across: 4000.0,
        up: 2000.0,
    };

    #[test]
    fn a_line_is_interrupted_where_there_is_no_value() {
        let panel = Panel {
            x: Axis::new("", "", [0.0, 4.0]),
            y: Axis::new("", "", [0.0, 1.0]),
            height: 10,
            series: vec![Series::over(
                "",
                0,
                Shape::Line,
                [Some(0.0), Some(1.0), None, Some(0.5), Some(0.5)],
            )],
        };
        assert_eq!(
            FRAME.paths(&panel, 0, &panel.series[0]),
            [("line", "M0 2000l0 0 1000 -2000M3000 1000l0 0 1000 0".to_owned())]
        );
    }
}
