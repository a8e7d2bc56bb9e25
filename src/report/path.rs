//! Series as paths of SVG in the box of a plot's coordinates.

use std::fmt::Write as _;

use crate::figures::{Panel, Series, Shape};

/// Size of the box of a plot's coordinates.
pub(super) const ACROSS: f64 = 4000.0;
pub(super) const UP: f64 = 2000.0;

/// Part of a category that its bars take.
const FILLED: f64 = 0.8;

/// The paths of a series, each with its class; `place` is its place in the panel.
pub(super) fn of(panel: &Panel, place: usize, series: &Series) -> Vec<(&'static str, String)> {
    let at = |x: f64, y: f64| [x_of(panel, x), y_of(panel, y)];
    let points = || series.x.iter().copied().zip(series.y.iter().copied());
    let curve = || line(points().map(|(x, y)| y.is_finite().then(|| at(x, y))));
    match &series.shape {
        Shape::Line => vec![("line", curve())],
        Shape::Broad => vec![("broad", curve())],
        Shape::Dashed => vec![("dashed", curve())],
        Shape::Points => {
            let mut d = String::new();
            for [x, y] in points()
                .filter(|(x, y)| x.is_finite() && y.is_finite())
                .map(|(x, y)| at(x, y))
            {
                // A line of no length with round ends is a dot however the box is stretched.
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
            vec![("pale", format!("{}z", line(all.map(|(x, y)| Some(at(x, y))))))]
        }
        Shape::Bars(marks) => {
            let floor = panel.y.range[0];
            let bars = points().map(|(x, y)| (x, [floor, y]));
            let marks = series.x.iter().copied().zip(marks.iter().copied());
            vec![
                ("area", boxes(panel, place, bars)),
                ("mark", across(panel, place, marks.filter(|(_, mark)| *mark > floor))),
            ]
        }
        Shape::Whiskers(ends) => {
            let bars = points().zip(ends).filter(|((_, y), _)| y.is_finite());
            vec![
                ("pale", boxes(panel, place, bars.map(|((x, _), ends)| (x, *ends)))),
                ("mark", across(panel, place, points())),
            ]
        }
        // Horizontal bars are rows.
        Shape::Spans(_) | Shape::Swings(_) => Vec::new(),
    }
}

fn x_of(panel: &Panel, x: f64) -> i64 {
    let [low, high] = panel.x.range;
    (ACROSS * (x - low) / (high - low)).round() as i64
}

/// Limited to the surroundings of the box: points far outside would only make the numbers long.
fn y_of(panel: &Panel, y: f64) -> i64 {
    let [low, high] = panel.y.range;
    (UP * (1.0 - (y - low) / (high - low))).clamp(-UP, 2.0 * UP).round() as i64
}

/// A line through points, interrupted at missing ones. Steps from point to point are short to write.
fn line(points: impl Iterator<Item = Option<[i64; 2]>>) -> String {
    let mut d = String::new();
    let mut last: Option<[i64; 2]> = None;
    for point in points {
        match (last, point) {
            (None, Some([x, y])) => {
                // A dot where the line has one point only.
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

/// Left and right end of the bar of a series in a category: series of bars are next to each other.
fn sides(panel: &Panel, place: usize, x: f64) -> [i64; 2] {
    let is_bar = |series: &&Series| matches!(series.shape, Shape::Bars(_) | Shape::Whiskers(_));
    let before = panel.series[..place].iter().filter(is_bar).count() as f64;
    let width = FILLED / panel.series.iter().filter(is_bar).count().max(1) as f64;
    let start = x + 0.5 * (1.0 - FILLED) + before * width;
    [x_of(panel, start), x_of(panel, start + 0.92 * width)]
}

fn boxes(panel: &Panel, place: usize, bars: impl Iterator<Item = (f64, [f64; 2])>) -> String {
    let mut d = String::new();
    for (x, [low, high]) in bars.filter(|(_, [low, high])| high > low) {
        let [left, right] = sides(panel, place, x);
        let [low, high] = [low, high].map(|y| y_of(panel, y));
        let _ = write!(d, "M{left} {low}V{high}H{right}V{low}z");
    }
    d
}

fn across(panel: &Panel, place: usize, marks: impl Iterator<Item = (f64, f64)>) -> String {
    let mut d = String::new();
    for (x, y) in marks.filter(|(_, y)| y.is_finite()) {
        let [left, right] = sides(panel, place, x);
        let _ = write!(d, "M{left} {}H{right}", y_of(panel, y));
    }
    d
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figures::Axis;

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
            of(&panel, 0, &panel.series[0]),
            [("line", "M0 2000l0 0 1000 -2000M3000 1000l0 0 1000 0".to_owned())]
        );
    }
}
