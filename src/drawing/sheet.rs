//! Arrangement of a view and its labels on a sheet: the scale, and labels in two columns with leader lines.
//!
//! Coordinates are in sheet units of one fifth of a millimetre on paper, x to the right and y down.

use std::collections::BTreeMap;

use super::apart::apart;
use super::label::Label;
use super::shape::{Annotation, Point, Side, View};

/// Units per millimetre of paper.
pub(super) const MM: f64 = 5.0;
/// Width of a sheet: 180 mm, the text width of a page.
pub(super) const WIDTH: f64 = 180.0 * MM;
/// Maximum height of the picture.
const TALLEST: f64 = 700.0;
/// Height of the heading, and of the foot with the scale bar.
const HEADING: f64 = 34.0;
const FOOT: f64 = 44.0;
/// Margin around the sheet, and width of the gap for the leader lines between labels and picture.
pub(super) const MARGIN: f64 = 8.0;
const GAP: f64 = 34.0;
/// Font size of keys and values, and height of a label with two lines.
pub(super) const KEY_TYPE: f64 = 10.5;
pub(super) const VALUE_TYPE: f64 = 12.0;
const LABEL: f64 = 27.0;
/// Distance between the centres of adjacent labels.
const SPACING: i32 = 31;
/// Length of the horizontal end of a leader line at its label.
const KNEE: f64 = 12.0;
/// Space for the provenance symbol next to a label.
const SYMBOL: f64 = 14.0;
/// Maximum width of a character of the two fonts relative to the font size: monospaced fonts have 0.60, sans serif
/// fonts less on average.
const MONO: f64 = 0.62;
const SANS: f64 = 0.64;

/// Scales of technical drawings (ISO 5455, with the common 1:2.5 and 1:4): steps in a decade.
const STEPS: [f64; 5] = [1.0, 2.0, 2.5, 4.0, 5.0];

/// A rectangle on the sheet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rectangle {
    /// Left and right end.
    pub x: [f64; 2],
    /// Upper and lower end.
    pub y: [f64; 2],
}

impl Rectangle {
    /// Whether two rectangles overlap.
    pub fn overlaps(&self, other: &Self) -> bool {
        let along = |a: [f64; 2], b: [f64; 2]| a[0] < b[1] && b[0] < a[1];
        along(self.x, other.x) && along(self.y, other.y)
    }

    /// Whether another rectangle is inside this one, apart from rounding.
    pub fn contains(&self, other: &Self) -> bool {
        let slack = 1e-6;
        let within = |a: [f64; 2], b: [f64; 2]| a[0] <= b[0] + slack && b[1] <= a[1] + slack;
        within(self.x, other.x) && within(self.y, other.y)
    }
}

/// A label at its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed<'a> {
    /// The annotation.
    pub annotation: &'a Annotation,
    /// Its text.
    pub label: &'a Label,
    /// The rectangle that the text needs.
    pub area: Rectangle,
    /// Where the leader line ends.
    pub port: Point,
    /// Where the leader line bends: it is straight between this point and the anchor.
    pub knee: Point,
}

/// A view with its scale and its labels.
#[derive(Debug, Clone, PartialEq)]
pub struct Sheet<'a> {
    /// The view.
    pub view: &'a View,
    /// Size of the sheet.
    pub size: [f64; 2],
    /// Length on paper divided by length of the tool.
    pub scale: f64,
    /// The rectangle of the view.
    pub picture: Rectangle,
    /// The labels.
    pub labels: Vec<Placed<'a>>,
}

/// Width of a text.
fn width(text: &str, size: f64, share: f64) -> f64 {
    text.chars().count() as f64 * size * share
}

/// Maximum length of the symbol in front of a value; some keys have a formula as their symbol.
const LONGEST_SYMBOL: usize = 8;

/// The second line of a label.
pub(super) fn value_line(label: &Label) -> String {
    if label.symbol.is_empty() || label.symbol.len() > LONGEST_SYMBOL {
        label.value.clone()
    } else {
        format!("{} = {}", label.symbol, label.value)
    }
}

fn label_width(label: &Label) -> f64 {
    let lines = [
        width(&label.key, KEY_TYPE, MONO),
        width(&value_line(label), VALUE_TYPE, SANS),
    ];
    lines[0].max(lines[1]) + SYMBOL
}

/// The largest standard scale at which a size \[m\] fits into `room`, in sheet units.
fn standard_scale(size: [f64; 2], room: [f64; 2]) -> f64 {
    let most = [0, 1]
        .map(|axis| room[axis] / (size[axis].max(1e-6) * 1e3 * MM))
        .into_iter()
        .fold(f64::INFINITY, f64::min);
    let decades = (-6..=6).flat_map(|decade| STEPS.map(|step| step * 10f64.powi(decade)));
    let both = decades.flat_map(|step| [step, 1.0 / step]);
    both.filter(|scale| *scale <= most * (1.0 + 1e-9))
        .fold(f64::MIN_POSITIVE, f64::max)
}

impl<'a> Sheet<'a> {
    /// Places a view and the labels of its annotations. Keys without a label are omitted.
    pub(super) fn new(view: &'a View, labels: &'a BTreeMap<String, Label>) -> Self {
        let known: Vec<(&Annotation, &Label)> = view
            .annotations
            .iter()
            .filter_map(|annotation| Some((annotation, labels.get(annotation.key)?)))
            .collect();
        let of = |side: Side| -> Vec<(&'a Annotation, &'a Label)> {
            known.iter().copied().filter(|(own, _)| own.side == side).collect()
        };
        let columns = [of(Side::Left), of(Side::Right)];
        let widths = columns
            .each_ref()
            .map(|column| column.iter().map(|(_, label)| label_width(label)).fold(0.0, f64::max));
        let room = WIDTH - widths[0] - widths[1] - 2.0 * (MARGIN + GAP);
        let bounds = view.bounds();
        let scale = standard_scale(bounds.size(), [room, TALLEST]);
        let [wide, high] = bounds.size().map(|length| length * scale * 1e3 * MM);
        let most = columns.iter().map(Vec::len).max().unwrap_or(0);
        let body = high.max(most as f64 * f64::from(SPACING));
        let left = MARGIN + widths[0] + GAP + 0.5 * (room - wide);
        let up = HEADING + 0.5 * (body - high);
        let mut sheet = Self {
            view,
            size: [WIDTH, HEADING + body + FOOT],
            scale,
            picture: Rectangle {
                x: [left, left + wide],
                y: [up, up + high],
            },
            labels: Vec::new(),
        };
        let ends = [HEADING, HEADING + body];
        for (column, own, gutter) in [
            (&columns[0], widths[0], MARGIN + widths[0]),
            (&columns[1], widths[1], WIDTH - MARGIN - widths[1]),
        ] {
            let placed = sheet.column(column, own, gutter, ends);
            sheet.labels.extend(placed);
        }
        sheet
    }

    /// Position of a point of the view on the sheet.
    pub fn at(&self, [x, z]: Point) -> Point {
        let bounds = self.view.bounds();
        let units = self.scale * 1e3 * MM;
        [
            self.picture.x[0] + (x - bounds.low[0]) * units,
            self.picture.y[0] + (bounds.high[1] - z) * units,
        ]
    }

    /// The scale as text, such as "1 : 4".
    pub fn scale_words(&self) -> String {
        let number = |value: f64| crate::wording::rounded(value, 3, 1e9);
        if self.scale >= 1.0 {
            format!("{} : 1", number(self.scale))
        } else {
            format!("1 : {}", number(1.0 / self.scale))
        }
    }

    /// Labels of a column in the order of their anchors, at the required distance.
    fn column(
        &self,
        column: &[(&'a Annotation, &'a Label)],
        width: f64,
        gutter: f64,
        ends: [f64; 2],
    ) -> Vec<Placed<'a>> {
        let mut column = column.to_vec();
        let height = |annotation: &Annotation| self.at(annotation.anchor)[1];
        column.sort_by(|(a, _), (b, _)| height(a).total_cmp(&height(b)));
        let wanted: Vec<i32> = column.iter().map(|(own, _)| height(own).round() as i32).collect();
        let half = 0.5 * f64::from(SPACING);
        let places = apart(
            &wanted,
            SPACING,
            [(ends[0] + half).ceil() as i32, (ends[1] - half).floor() as i32],
        );
        let inwards = if gutter < 0.5 * WIDTH { KNEE } else { -KNEE };
        let knees: Vec<Point> = places
            .iter()
            .map(|place| [gutter + inwards, f64::from(*place)])
            .collect();
        self.uncross(&mut column, &knees);
        let area = |[x, y]: Point, side: Side| Rectangle {
            x: if side == Side::Left {
                [x - width, x]
            } else {
                [x, x + width]
            },
            y: [y - 0.5 * LABEL, y + 0.5 * LABEL],
        };
        column
            .into_iter()
            .zip(knees)
            .map(|((annotation, label), knee)| Placed {
                annotation,
                label,
                area: area([gutter, knee[1]], annotation.side),
                port: [gutter, knee[1]],
                knee,
            })
            .collect()
    }

    /// Swaps labels as long as this shortens the leader lines: straight lines of minimum total length do not cross.
    fn uncross(&self, column: &mut [(&'a Annotation, &'a Label)], knees: &[Point]) {
        let length = |annotation: &Annotation, [x, y]: Point| {
            let [u, v] = self.at(annotation.anchor);
            (u - x).hypot(v - y)
        };
        // The loop ends because each swap shortens the total by more than rounding.
        let mut improved = true;
        while improved {
            improved = false;
            for first in 0..column.len() {
                for second in first + 1..column.len() {
                    let (a, b) = (column[first].0, column[second].0);
                    let now = length(a, knees[first]) + length(b, knees[second]);
                    let then = length(b, knees[first]) + length(a, knees[second]);
                    if then < now - 1e-6 {
                        column.swap(first, second);
                        improved = true;
                    }
                }
            }
        }
    }
}
