//! Charts as SVG for print: as wide as the text of a page (180 mm), 8 pt type, lines of 1 pt, as journals ask.
//!
//! Axes, ticks, grids, legends and series are those of plotters. The leader lines that separate labels of close events
//! and the joints of a cascade are drawn by hand, because plotters does not have them.

use std::ops::Range;

use plotters::backend::SVGBackend;
use plotters::chart::{ChartBuilder, ChartContext, LabelAreaPosition, SeriesLabelPosition};
use plotters::coord::Shift;
use plotters::coord::cartesian::Cartesian2d;
use plotters::coord::ranged1d::{BoldPoints, KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::data::float::pretty_print_float;
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind, IntoDrawingArea};
use plotters::element::{Circle, DashedPathElement, DynElement, IntoDynElement, PathElement, Polygon, Rectangle, Text};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontFamily, FontStyle, RGBColor, ShapeStyle, TextStyle, WHITE};

use super::PALETTE;
use super::chart::{Axis, Chart, Event, Panel, Series, Shape, subscripts};

/// Grid units in a millimetre: whole units are finer than the dots of a printer.
const MM: i32 = 20;
const WIDTH: i32 = 180 * MM;
/// Margin at the right.
const RIGHT: i32 = 4 * MM;
/// Height of 8 pt type, which the backend divides by 1.24, and of a line of it.
const TYPE: f64 = 56.0 * 1.24;
const LEADING: i32 = 87;
/// Height of the heading, of the space over a legend, of the labels of events, of an axis' numbers and title, and below
/// it.
const HEADING: i32 = 7 * MM;
const GAP: i32 = 3 * MM;
const EVENTS: i32 = 8 * MM;
const NUMBERS: i32 = 6 * MM;
const TITLE: i32 = 4 * MM;
const MARGIN: i32 = MM + MM / 2;
/// Smallest distance of labels of events.
const APART: i32 = 5 * MM;
/// Length of a sample in a legend with its distance from the text, and distance of the entries.
const SAMPLE: i32 = 6 * MM;
const SAMPLE_GAP: i32 = MM + MM / 2;
const ENTRY_GAP: i32 = 5 * MM;

/// Widths of curves, of axes, and of grid and leader lines.
const CURVE: u32 = 7;
const FRAME: u32 = 4;
const HAIR: u32 = 2;
/// Radius of a dot.
const DOT: i32 = 9;

const FONT: &str = "Helvetica, Arial, Liberation Sans, DejaVu Sans, sans-serif";
const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
const GREY: RGBColor = RGBColor(0x66, 0x66, 0x66);
const PALE: RGBColor = RGBColor(0xB8, 0xB8, 0xB8);
const FAINT: RGBColor = RGBColor(0xEA, 0xEA, 0xEA);

type Svg<'a> = SVGBackend<'a>;
type Area<'a> = DrawingArea<Svg<'a>, Shift>;
type Axes<'c, 'a> = ChartContext<'c, Svg<'a>, Cartesian2d<Scale, Scale>>;
type Drawn<T = ()> = Result<T, DrawingAreaErrorKind<std::io::Error>>;

/// The linear scale of plotters, with ticks in the middle of categories if any.
struct Scale {
    linear: RangedCoordf64,
    ticks: Vec<f64>,
    categories: Vec<String>,
}

impl Scale {
    /// The scale of an axis with at most `count` ticks on numbers.
    fn new(axis: &Axis, count: u32, vertical: bool) -> Self {
        let [low, high] = axis.range;
        let downwards = vertical && !axis.categories.is_empty();
        let linear = RangedCoordf64::from(if downwards { high..low } else { low..high });
        Self {
            ticks: if axis.categories.is_empty() {
                linear.key_points(BoldPoints(count as usize))
            } else {
                axis.ticks.iter().map(|&place| place as f64 + 0.5).collect()
            },
            linear,
            categories: axis.categories.clone(),
        }
    }
}

impl Ranged for Scale {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        self.linear.map(value, limit)
    }

    fn key_points<H: KeyPointHint>(&self, hint: H) -> Vec<f64> {
        if hint.weight().allow_light_points() {
            Vec::new()
        } else {
            self.ticks.clone()
        }
    }

    fn range(&self) -> Range<f64> {
        self.linear.range()
    }
}

impl ValueFormatter<f64> for Scale {
    fn format_ext(&self, value: &f64) -> String {
        let number = || pretty_print_float(*value, false).replace('-', "\u{2212}");
        self.categories.get(*value as usize).cloned().unwrap_or_else(number)
    }
}

impl Chart {
    /// The chart as SVG.
    pub fn svg(&self) -> String {
        let height = HEADING
            + (0..self.panels.len())
                .map(|index| self.room(index).iter().sum::<i32>())
                .sum::<i32>();
        let mut svg = String::new();
        // Writing to a string cannot fail.
        let _ = self.draw(SVGBackend::with_string(&mut svg, (WIDTH as u32, height as u32)).into_drawing_area());
        // The size in print, a name and a description for screen readers, joints that do not shoot beyond a spike's
        // tip.
        let plain = |text: &str| subscripts(text, "", "").replace('&', "&amp;").replace('<', "&lt;");
        let head = format!(
            r#"<svg width="{}mm" height="{}mm" role="img" stroke-linejoin="round" stroke-linecap="round""#,
            WIDTH / MM,
            f64::from(height) / f64::from(MM),
        );
        let names = format!(
            "xmlns=\"http://www.w3.org/2000/svg\">\n<title>{}: {}</title>\n<desc>{}</desc>",
            plain(self.title),
            plain(&self.subject),
            plain(&self.caption)
        );
        let svg = svg
            .replacen(&format!(r#"<svg width="{WIDTH}" height="{height}""#), &head, 1)
            .replacen(r#"xmlns="http://www.w3.org/2000/svg">"#, &names, 1);
        subscripts(&svg, r#"<tspan baseline-shift="sub" font-size="75%">"#, "</tspan>")
    }

    /// Heights of a panel's legend, events, axes and horizontal axis.
    fn room(&self, index: usize) -> [i32; 4] {
        let panel = &self.panels[index];
        let legend = GAP + LEADING * legend(&panel.series).1 as i32;
        let events = if index == 0 && !self.events.is_empty() {
            EVENTS
        } else {
            0
        };
        // The axis of the panel below has the same title.
        let shared = self.panels.get(index + 1).is_some_and(|below| below.x == panel.x);
        [
            legend,
            events,
            panel.height as i32 * MM,
            if shared { NUMBERS } else { NUMBERS + TITLE + MARGIN },
        ]
    }

    fn draw(&self, page: Area<'_>) -> Drawn {
        page.fill(&WHITE)?;
        let left = self.panels.iter().map(left).max().unwrap_or(0);
        let heading = text(&INK).pos(Pos::new(HPos::Left, VPos::Center));
        page.draw_text(self.title, &bold(&heading), (left, 4 * MM))?;
        let subject = text(&GREY).pos(Pos::new(HPos::Right, VPos::Center));
        page.draw_text(&self.subject, &subject, (WIDTH - RIGHT, 4 * MM))?;
        let (_, mut rest) = page.split_vertically(HEADING);
        for (index, panel) in self.panels.iter().enumerate() {
            let [legend, events, axes, foot] = self.room(index);
            let (strip, below) = rest.split_vertically(legend);
            if self.panels.len() > 1 {
                strip.draw_text(
                    &char::from(b'a' + index as u8).to_string(),
                    &bold(&text(&INK)),
                    (3 * MM, GAP / 2),
                )?;
            }
            draw_legend(&strip.margin(GAP / 2, 0, left, RIGHT), &panel.series)?;
            let (labels, below) = below.split_vertically(events);
            let (area, below) = below.split_vertically(axes + foot);
            let axes = panel.draw(&area, [left, foot], &self.events)?;
            if events > 0 {
                draw_events(&labels, &axes, &self.events)?;
            }
            rest = below;
        }
        page.present()
    }
}

impl Panel {
    fn draw<'c, 'a: 'c>(&self, area: &Area<'a>, [left, foot]: [i32; 2], events: &[Event]) -> Drawn<Axes<'c, 'a>> {
        let [low, high] = self.y.range;
        let mut axes = ChartBuilder::on(area)
            .margin_right(RIGHT)
            .margin_left(2 * MM)
            .margin_bottom(if foot > NUMBERS { MARGIN } else { 0 })
            .set_label_area_size(LabelAreaPosition::Left, left - 2 * MM)
            .set_label_area_size(
                LabelAreaPosition::Bottom,
                if foot > NUMBERS { NUMBERS + TITLE } else { NUMBERS },
            )
            .build_cartesian_2d(
                Scale::new(&self.x, 10, false),
                Scale::new(&self.y, (self.height / 8).max(3), true),
            )?;
        let mut mesh = axes.configure_mesh();
        mesh.bold_line_style(FAINT.stroke_width(HAIR))
            .axis_style(INK.stroke_width(FRAME))
            .set_all_tick_mark_size(MM)
            .label_style(text(&INK));
        if self.y.categories.is_empty() {
            mesh.disable_x_mesh();
        } else {
            mesh.disable_y_mesh();
        }
        if foot > NUMBERS {
            mesh.x_desc(self.x.title());
        }
        mesh.y_desc(self.y.title()).draw()?;
        axes.draw_series(
            events
                .iter()
                .map(|event| PathElement::new([(event.at, low), (event.at, high)], PALE.stroke_width(HAIR))),
        )?;
        let bars = self
            .series
            .iter()
            .filter(|series| matches!(series.shape, Shape::Bars(_) | Shape::Whiskers(_) | Shape::Swings(_)))
            .count();
        for (place, series) in self.series.iter().enumerate().rev() {
            axes.draw_series(series.elements(self, [place, bars]))?;
        }
        Ok(axes)
    }
}

impl Series {
    fn colour(&self) -> RGBColor {
        let [red, green, blue] = PALETTE[self.colour];
        RGBColor(red, green, blue)
    }

    /// Style of the line.
    fn stroke(&self) -> ShapeStyle {
        self.colour()
            .stroke_width(if self.shape == Shape::Broad { 2 * CURVE } else { CURVE })
    }

    /// The series as elements of a chart; `place` is its place among `bars` series of bars.
    fn elements<'s>(&self, panel: &Panel, [place, bars]: [usize; 2]) -> Vec<DynElement<'static, Svg<'s>, (f64, f64)>> {
        let points = || self.x.iter().copied().zip(self.y.iter().copied());
        let line = |line: Vec<(f64, f64)>| PathElement::new(line, self.stroke()).into_dyn();
        let filled = self.colour().filled();
        let mut elements = Vec::new();
        match &self.shape {
            Shape::Line | Shape::Broad => elements.extend(panel.lines(points().map(|point| vec![point])).map(line)),
            Shape::Steps => elements.extend(panel.lines(points().map(|(x, y)| vec![(x, y), (x + 1.0, y)])).map(line)),
            Shape::Dashed => {
                let style = self.colour().stroke_width(FRAME);
                elements.push(DashedPathElement::new(points().collect::<Vec<_>>(), 25, 20, style).into_dyn());
            }
            Shape::Bars(marks) if !panel.y.categories.is_empty() => {
                let width = 0.8 / bars as f64;
                let floor = panel.x.range[0];
                for (index, (value, row)) in points().enumerate() {
                    let [from, to] = [0, 1].map(|end| row + 0.1 + width * (place + end) as f64);
                    if value > floor {
                        elements.push(Rectangle::new([(floor, from), (value, to - 0.02)], filled).into_dyn());
                    }
                    if let Some(mark) = marks.get(index).filter(|mark| **mark > floor) {
                        elements
                            .push(PathElement::new([(*mark, from), (*mark, to)], INK.stroke_width(FRAME)).into_dyn());
                    }
                }
            }
            Shape::Bars(marks) => {
                let width = 0.8 / bars as f64;
                let floor = panel.y.range[0];
                for (index, (x, y)) in points().enumerate() {
                    let [from, to] = [0, 1].map(|end| x + 0.1 + width * (place + end) as f64);
                    if y > floor {
                        elements.push(Rectangle::new([(from, floor), (to - 0.02, y)], filled).into_dyn());
                    }
                    if let Some(mark) = marks.get(index).filter(|mark| **mark > floor) {
                        elements
                            .push(PathElement::new([(from, *mark), (to, *mark)], INK.stroke_width(FRAME)).into_dyn());
                    }
                }
            }
            Shape::Points => {
                let within = |&(x, y): &(f64, f64)| x.is_finite() && y.is_finite();
                elements.extend(
                    points()
                        .filter(within)
                        .map(|point| Circle::new(point, DOT, filled).into_dyn()),
                );
            }
            Shape::Whiskers(ends) => {
                let width = 0.8 / bars as f64;
                for ((x, middle), [low, high]) in points().zip(ends).filter(|((_, y), _)| y.is_finite()) {
                    let [from, to] = [0, 1].map(|end| x + 0.1 + width * (place + end) as f64);
                    let pale = self.colour().mix(0.45).filled();
                    elements.push(Rectangle::new([(from, *low), (to - 0.02, *high)], pale).into_dyn());
                    let line = [(from, middle), (to - 0.02, middle)];
                    elements.push(PathElement::new(line, self.colour().stroke_width(CURVE)).into_dyn());
                }
            }
            Shape::Band(lower) => {
                let lower = self.x.iter().copied().zip(lower.iter().copied()).rev();
                elements
                    .push(Polygon::new(points().chain(lower).collect::<Vec<_>>(), self.colour().mix(0.13)).into_dyn());
            }
            Shape::Swings(from) => {
                let width = 0.8 / bars as f64;
                for ((to, row), from) in points().zip(from).filter(|((to, _), _)| to.is_finite()) {
                    let [upper, lower] = [0, 1].map(|end| row + 0.1 + width * (place + end) as f64);
                    elements.push(Rectangle::new([(*from, upper), (to, lower)], filled).into_dyn());
                }
            }
            Shape::Spans(from) => {
                for (((to, row), from), note) in points().zip(from).zip(&self.notes) {
                    let [upper, lower] = [row + 0.15, row + 0.85];
                    elements.push(Rectangle::new([(*from, upper), (to, lower)], filled).into_dyn());
                    // Parts too thin for a rectangle are drawn as a line.
                    elements.push(
                        PathElement::new([(*from, upper), (*from, lower)], self.colour().stroke_width(FRAME))
                            .into_dyn(),
                    );
                    if row + 1.0 < panel.y.range[1] {
                        elements.push(
                            PathElement::new([(to, lower), (to, row + 1.15)], GREY.stroke_width(HAIR)).into_dyn(),
                        );
                    }
                    let beside = text(&INK).pos(Pos::new(HPos::Left, VPos::Center));
                    let end = from.max(to) + 0.008 * (panel.x.range[1] - panel.x.range[0]);
                    elements.push(Text::new(note.clone(), (end, row + 0.5), beside).into_dyn());
                }
            }
        }
        elements
    }

    /// The sample of a legend that begins at a point.
    fn sample<'s>(&self, (x, y): (i32, i32)) -> DynElement<'static, Svg<'s>, (i32, i32)> {
        let ends = [(x, y), (x + SAMPLE, y)];
        match self.shape {
            Shape::Bars(_) | Shape::Spans(_) | Shape::Swings(_) | Shape::Whiskers(_) => {
                Rectangle::new([(x, y - MM), (x + SAMPLE, y + MM)], self.colour().filled()).into_dyn()
            }
            Shape::Band(_) => {
                Rectangle::new([(x, y - MM), (x + SAMPLE, y + MM)], self.colour().mix(0.26).filled()).into_dyn()
            }
            Shape::Points => Circle::new((x + SAMPLE / 2, y), DOT, self.colour().filled()).into_dyn(),
            Shape::Dashed => DashedPathElement::new(ends, 25, 20, self.colour().stroke_width(FRAME)).into_dyn(),
            _ => PathElement::new(ends, self.stroke()).into_dyn(),
        }
    }
}

impl Panel {
    /// The unbroken lines through points, some of them drawn together, without those beyond the axes.
    fn lines(&self, points: impl Iterator<Item = Vec<(f64, f64)>>) -> impl Iterator<Item = Vec<(f64, f64)>> {
        let within = |[low, high]: [f64; 2], value| (low..=high).contains(&value);
        let mut lines = vec![Vec::new()];
        for points in points {
            if points
                .iter()
                .all(|(x, y)| within(self.x.range, *x) && within(self.y.range, *y))
            {
                lines
                    .last_mut()
                    .into_iter()
                    .for_each(|line: &mut Vec<_>| line.extend(&points));
            } else if lines.last().is_some_and(|line| !line.is_empty()) {
                lines.push(Vec::new());
            }
        }
        lines.into_iter().filter(|line| line.len() > 1)
    }
}

/// Room left of the vertical axis.
fn left(panel: &Panel) -> i32 {
    if panel.y.categories.is_empty() {
        17 * MM
    } else {
        56 * MM
    }
}

fn text(colour: &'static RGBColor) -> TextStyle<'static> {
    TextStyle::from((FontFamily::Name(FONT), TYPE)).color(colour)
}

fn bold(style: &TextStyle<'static>) -> TextStyle<'static> {
    TextStyle {
        font: style.font.style(FontStyle::Bold),
        ..style.clone()
    }
}

/// Width of a column of a legend, and its rows.
fn legend(series: &[Series]) -> (i32, usize) {
    let named = series.iter().filter(|series| !series.name.is_empty());
    let widths = named.map(|series| {
        text(&INK)
            .font
            .box_size(&series.name)
            .map_or(0, |(width, _)| width as i32)
    });
    let (entries, widest) = widths.fold((0, 0), |(count, widest), width| (count + 1, widest.max(width)));
    let column = SAMPLE + SAMPLE_GAP + widest + ENTRY_GAP;
    let columns = ((WIDTH - 17 * MM - RIGHT + ENTRY_GAP) / column).max(1);
    (column, (entries as usize).div_ceil(columns as usize))
}

/// Draws the legend in columns: plotters has a list only, and places it over the curves.
fn draw_legend(strip: &Area<'_>, series: &[Series]) -> Drawn {
    let (width, rows) = legend(series);
    let named: Vec<&Series> = series.iter().filter(|series| !series.name.is_empty()).collect();
    for (column, entries) in named.chunks(rows.max(1)).enumerate() {
        let (_, cell) = strip.split_horizontally(column as i32 * width);
        let mut list = ChartBuilder::on(&cell).build_cartesian_2d(0..1, 0..1)?;
        for entry in entries {
            list.draw_series(std::iter::empty::<PathElement<(i32, i32)>>())?
                .label(&entry.name)
                .legend(|at| entry.sample(at));
        }
        list.configure_series_labels()
            .position(SeriesLabelPosition::Coordinate(0, 0))
            .margin(0)
            .legend_area_size(SAMPLE + SAMPLE_GAP)
            .label_font(text(&INK))
            .draw()?;
    }
    Ok(())
}

/// The symbols of events in a row, with lines to where the events are.
fn draw_events(labels: &Area<'_>, axes: &Axes<'_, '_>, events: &[Event]) -> Drawn {
    let at: Vec<i32> = events
        .iter()
        .map(|event| axes.backend_coord(&(event.at, 0.0)).0)
        .collect();
    let middle = text(&GREY).pos(Pos::new(HPos::Center, VPos::Center));
    for ((event, label), at) in events.iter().zip(apart(&at, APART, [17 * MM, WIDTH - RIGHT])).zip(at) {
        labels.draw_text(&event.symbol, &middle, (label, 2 * MM))?;
        let leader = [(label, 4 * MM), (at, EVENTS - MM), (at, EVENTS - 1)];
        labels.draw(&PathElement::new(leader, PALE.stroke_width(HAIR)))?;
    }
    Ok(())
}

/// Rising positions, separated by a distance: the mean of pushing all to the right and all to the left, as both
/// maintain the distance.
pub(crate) fn apart(wanted: &[i32], distance: i32, [low, high]: [i32; 2]) -> Vec<i32> {
    let pushed = |places: &mut dyn Iterator<Item = i32>| -> Vec<i32> {
        let mut last = i32::MIN / 2;
        let push = |place: i32| {
            last = place.max(last + distance);
            last
        };
        places.map(push).collect()
    };
    let to_the_right = pushed(&mut wanted.iter().copied());
    let to_the_left = pushed(&mut wanted.iter().rev().map(|place| -place));
    let mean = |(right, left): (i32, &i32)| (right - left) / 2;
    let mut placed: Vec<i32> = to_the_right
        .into_iter()
        .zip(to_the_left.iter().rev())
        .map(mean)
        .collect();
    placed = pushed(&mut placed.into_iter().map(|place| place.max(low)));
    placed = pushed(&mut placed.into_iter().rev().map(|place| -place.min(high)));
    placed.into_iter().rev().map(|place| -place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_keep_apart_on_the_line_and_stay_where_they_can() {
        let ends = [0, 20 * APART];
        assert_eq!(apart(&[APART, 5 * APART], APART, ends), [APART, 5 * APART]);
        assert_eq!(apart(&[5 * APART; 3], APART, ends), [4 * APART, 5 * APART, 6 * APART]);
        let placed = apart(&[0, 0, 0, ends[1], ends[1]], APART, ends);
        assert_eq!([placed[0], placed[4]], ends);
        assert!(placed.windows(2).all(|pair| pair[1] - pair[0] >= APART), "{placed:?}");
    }
}
