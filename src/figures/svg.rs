//! Charts as SVG files for print, as journals require: 180 mm wide (the text width of a page), with 8 pt type and 1 pt
//! lines.
//!
//! Curves, bars and ticks are the same as on pages; only the frame and the texts are laid out here.

use maud::{Markup, PreEscaped, html};

use super::chart::{Chart, Event, Panel, Series, Shape, subscripts};
use super::palette::hexadecimal;
use super::path::{Frame, RowBar, row_bars, sharing};
use super::ticks::{Tick, WIDE, across, rows, upwards};

/// Units of length per millimetre.
const MM: f64 = 20.0;
const WIDTH: f64 = 180.0 * MM;
/// Right margin.
const RIGHT: f64 = 4.0 * MM;
/// Height of 8 pt type, mean width of its characters, and line height.
const TYPE: f64 = 56.0;
const LETTER: f64 = 0.53 * TYPE;
const LEADING: f64 = 87.0;
/// Heights of the heading, of the space above a legend, of the numbers on an axis, and of its title.
const HEADING: f64 = 8.0 * MM;
const GAP: f64 = 3.0 * MM;
const NUMBERS: f64 = 5.0 * MM;
const TITLE: f64 = 6.0 * MM;
/// Space left of a vertical axis of numbers, and maximum space left of one of categories.
const LEFT: f64 = 17.0 * MM;
const MOST_LEFT: f64 = 80.0 * MM;
/// Length of a sample in a legend, its distance from the text, and distance between entries.
const SAMPLE: f64 = 6.0 * MM;
const SAMPLE_GAP: f64 = 1.5 * MM;
const ENTRY_GAP: f64 = 5.0 * MM;
/// Width of the symbol of an event, and height of a row of symbols.
const SYMBOL: f64 = 4.5 * MM;
const SYMBOLS: f64 = 3.5 * MM;

const INK: &str = "#222222";
const QUIET: &str = "#666666";
const PALE: &str = "#B8B8B8";
const FAINT: &str = "#E3E3E3";

/// Position of a panel on the sheet, from the top.
struct Place {
    /// Letter of the panel; `None` for a single panel.
    letter: Option<char>,
    /// Upper edge of the panel, and of the axes.
    top: f64,
    axes: f64,
    /// Left end of the horizontal axis.
    left: f64,
    /// Size of the axes.
    frame: Frame,
    /// Whether the horizontal axis has its title; otherwise the panel below has it.
    titled: bool,
}

/// Where a text is anchored.
#[derive(Clone, Copy)]
enum Anchor {
    Start,
    Middle,
    End,
}

impl Chart {
    /// The chart as SVG.
    pub fn svg(&self) -> String {
        let left = self.panels.iter().map(left).fold(0.0, f64::max);
        let mut top = HEADING;
        let mut panels = Vec::new();
        for (index, panel) in self.panels.iter().enumerate() {
            let events = top + GAP + LEADING * legend(panel).rows as f64;
            let symbols = if index == 0 {
                symbols(&placed(&self.events, panel), left)
            } else {
                Vec::new()
            };
            let lines = symbols.iter().map(|(row, _)| row + 1).max().unwrap_or(0);
            let place = Place {
                letter: (self.panels.len() > 1).then_some(char::from(b'a' + index as u8)),
                top,
                axes: events + SYMBOLS * lines as f64,
                left,
                frame: Frame {
                    across: WIDTH - RIGHT - left,
                    up: MM * f64::from(panel.height),
                },
                titled: self.panels.get(index + 1).is_none_or(|below| below.x != panel.x),
            };
            panels.push(place.markup(panel, &placed(&self.events, panel), &symbols));
            top = place.axes + place.frame.up + NUMBERS + if place.titled { TITLE } else { MM };
        }
        let plain = |text: &str| subscripts(text, "", "");
        html! {
            svg xmlns="http://www.w3.org/2000/svg" role="img"
                width={ (WIDTH / MM) "mm" } height={ (top / MM) "mm" } viewBox={ "0 0 " (WIDTH) " " (top) }
                font-family="Helvetica, Arial, Liberation Sans, DejaVu Sans, sans-serif" font-size=(TYPE)
                stroke-linejoin="round" stroke-linecap="round" {
                title { (plain(self.title)) ": " (plain(&self.subject)) }
                desc { (plain(&self.caption)) }
                rect width=(WIDTH) height=(top) fill="#FFFFFF" {}
                g font-weight="bold" { (text(left, 4.0 * MM, Anchor::Start, INK, self.title)) }
                (text(WIDTH - RIGHT, 4.0 * MM, Anchor::End, QUIET, &self.subject))
                @for panel in panels { (panel) }
            }
        }
        .into_string()
    }
}

impl Place {
    fn markup(&self, panel: &Panel, events: &[(&Event, f64)], symbols: &[(usize, f64)]) -> Markup {
        let Frame { across: wide, up: high } = self.frame;
        let [left, axes, bottom] = [self.left, self.axes, self.axes + high];
        let of_rows = !panel.y.categories.is_empty();
        let xs: Vec<Tick> = across(&panel.x)
            .into_iter()
            .filter(|tick| tick.narrow || !of_rows)
            .collect();
        html! {
            @if let Some(letter) = self.letter {
                g font-weight="bold" {
                    (text(3.0 * MM, self.top + 0.5 * GAP, Anchor::Middle, INK, &letter.to_string()))
                }
            }
            (self.legend(panel))
            @for ((event, _), (row, x)) in events.iter().zip(symbols) {
                (text(left + x, self.axes - SYMBOLS * (*row as f64 + 0.6), Anchor::Middle, QUIET, &event.symbol))
            }
            svg x=(left) y=(axes) width=(wide) height=(high) viewBox={ "0 0 " (wide) " " (high) } fill="none" {
                @if of_rows { path stroke=(FAINT) stroke-width="3"
                    d=(upright(xs.iter().map(|tick| tick.at), self.frame)) {} }
                @else {
                    path stroke=(FAINT) stroke-width="3"
                        d=(ticks(panel).iter().map(|tick| level(tick, self.frame)).collect::<String>()) {}
                }
                @if !events.is_empty() {
                    path stroke=(PALE) stroke-width="2" d=(upright(events.iter().map(|(_, at)| *at), self.frame)) {}
                }
                @if of_rows { (self.rows(panel)) }
                @else { @for (place, own) in panel.in_order() {
                    @for (class, d) in self.frame.paths(panel, place, own) {
                        (stroke(class, &hexadecimal(own.colour), &d))
                    }
                } }
            }
            @if of_rows { (self.notes(panel)) }
            path fill="none" stroke=(QUIET) stroke-width="4"
                d={ "M" (left) " " (axes) "V" (bottom) "H" (left + wide) } {}
            @if of_rows {
                @let pitch = high / panel.y.categories.len().max(1) as f64;
                @for (row, name) in panel.y.categories.iter().enumerate() {
                    (text(left - MM, axes + pitch * (row as f64 + 0.5), Anchor::End, INK, name))
                }
            } @else {
                @for tick in ticks(panel) {
                    (text(left - MM, bottom - tick.at * high, Anchor::End, INK, &tick.label))
                }
            }
            @for tick in &xs {
                (text(left + tick.at * wide, bottom + 0.55 * NUMBERS, Anchor::Middle, INK, &tick.label))
            }
            @if self.titled {
                (text(left + 0.5 * wide, bottom + NUMBERS + 1.5 * MM, Anchor::Middle, INK, &panel.x.title()))
            }
            g transform={ "translate(" (3.0 * MM) " " (axes + 0.5 * high) ") rotate(-90)" } {
                (text(0.0, 0.0, Anchor::Middle, INK, &panel.y.title()))
            }
        }
    }

    fn legend(&self, panel: &Panel) -> Markup {
        let Legend { column, rows } = legend(panel);
        let named = panel.series.iter().filter(|own| !own.name.is_empty());
        html! { @for (place, own) in named.enumerate() {
            @let x = self.left + column * (place / rows) as f64;
            @let y = self.top + 0.5 * GAP + LEADING * (place % rows) as f64;
            @let colour = hexadecimal(own.colour);
            @match &own.shape {
                Shape::Line | Shape::Steps | Shape::Errors(_) => { (sample("line", &colour, x, y)) }
                Shape::Broad => { (sample("broad", &colour, x, y)) }
                Shape::Dashed => { (sample("dashed", &colour, x, y)) }
                Shape::Points => { (stroke("dots", &colour, &format!("M{} {y}h0", x + 0.5 * SAMPLE))) }
                shape => {
                    @let class = match shape {
                        Shape::Band(_) => "spread",
                        Shape::Whiskers(_) => "pale",
                        _ => "area",
                    };
                    (stroke(class, &colour, &format!("M{x} {}h{SAMPLE}v{}h-{SAMPLE}z", y - MM, 2.0 * MM)))
                }
            }
            (text(x + SAMPLE + SAMPLE_GAP, y, Anchor::Start, INK, &own.name))
        } }
    }

    /// Horizontal bars, each with its mark.
    fn rows(&self, panel: &Panel) -> Markup {
        let pitch = self.frame.up / panel.y.categories.len().max(1) as f64;
        let shared = sharing(panel).max(1) as f64;
        let wide = self.frame.across;
        let bar = |row: usize, bar: &RowBar<'_>| {
            let place = if shared > 1.0 { bar.place as f64 } else { 0.0 };
            let [top, height] = [pitch * (row as f64 + 0.1 + 0.8 * place / shared), 0.76 * pitch / shared];
            let [from, to] = bar.ends.map(|end| end * wide);
            html! {
                // A bar of zero length is as wide as a line.
                rect x=(from) y=(top) width=((to - from).max(4.0)) height=(height) fill=(hexadecimal(bar.colour)) {}
                @if let Some(mark) = bar.mark {
                    path stroke=(INK) stroke-width="4" d={ "M" (mark * wide) " " (top) "v" (height) } {}
                }
            }
        };
        html! { @for row in 0..panel.y.categories.len() { @for own in row_bars(panel, row) { (bar(row, &own)) } } }
    }

    /// Texts after horizontal bars.
    fn notes(&self, panel: &Panel) -> Markup {
        let pitch = self.frame.up / panel.y.categories.len().max(1) as f64;
        html! { @for row in 0..panel.y.categories.len() { @for own in row_bars(panel, row) {
            @if let Some(note) = own.note {
                @let x = self.left + own.ends[1] * self.frame.across + MM;
                (text(x, self.axes + pitch * (row as f64 + 0.5), Anchor::Start, INK, note))
            }
        } } }
    }
}

impl Panel {
    /// Height of the axes on a page \[px\].
    pub(crate) fn pixels(&self) -> u32 {
        90 + 12 * self.height / 5
    }
}

/// Space left of the vertical axis, for its title and its numbers or the names of its categories.
fn left(panel: &Panel) -> f64 {
    let letters = panel
        .y
        .categories
        .iter()
        .map(|name| subscripts(name, "", "").chars().count());
    letters
        .max()
        .map_or(LEFT, |most| (7.0 * MM + LETTER * most as f64).clamp(LEFT, MOST_LEFT))
}

/// Ticks of the vertical axis; they are denser than on the screen, because a printed page is read at a shorter
/// distance.
fn ticks(panel: &Panel) -> Vec<Tick> {
    upwards(&panel.y, panel.pixels() * 3 / 2)
}

/// A legend in columns.
struct Legend {
    /// Width of a column.
    column: f64,
    /// Entries in a column.
    rows: usize,
}

fn legend(panel: &Panel) -> Legend {
    let named = panel.series.iter().filter(|own: &&Series| !own.name.is_empty());
    let letters = |own: &Series| subscripts(&own.name, "", "").chars().count();
    let (entries, longest) = named.fold((0, 0), |(count, longest), own| (count + 1, longest.max(letters(own))));
    let column = SAMPLE + SAMPLE_GAP + LETTER * longest as f64 + ENTRY_GAP;
    let columns = ((WIDTH - left(panel) - RIGHT + ENTRY_GAP) / column).floor().max(1.0) as usize;
    Legend {
        column,
        rows: usize::div_ceil(entries, columns).max(1),
    }
}

/// Events with their positions on the axis, as fractions of its length.
fn placed<'a>(events: &'a [Event], panel: &Panel) -> Vec<(&'a Event, f64)> {
    let [low, high] = panel.x.range;
    let events = events.iter().map(|event| (event, (event.at - low) / (high - low)));
    events.filter(|(_, at)| (0.0..=1.0).contains(at)).collect()
}

/// Row and abscissa of the symbol of each event.
fn symbols(events: &[(&Event, f64)], left: f64) -> Vec<(usize, f64)> {
    let wide = WIDTH - RIGHT - left;
    let places: Vec<f64> = events.iter().map(|(_, at)| *at).collect();
    let rows = rows(&places, SYMBOL * WIDE / wide);
    rows.iter()
        .zip(places)
        .map(|([row, _], at)| (*row, at * wide))
        .collect()
}

fn upright(places: impl Iterator<Item = f64>, frame: Frame) -> String {
    places
        .map(|at| format!("M{:.0} 0v{}", frame.across * at, frame.up))
        .collect()
}

fn level(tick: &Tick, frame: Frame) -> String {
    format!("M0 {:.0}h{}", frame.up * (1.0 - tick.at), frame.across)
}

fn sample(class: &str, colour: &str, x: f64, y: f64) -> Markup {
    stroke(class, colour, &format!("M{x} {y}h{SAMPLE}"))
}

/// A path in the style of its class on a page.
fn stroke(class: &str, colour: &str, d: &str) -> Markup {
    let line = |width: u32, dashes: Option<&str>, cap: Option<&str>| {
        html! { path fill="none" stroke=(colour) stroke-width=(width) stroke-dasharray=[dashes] stroke-linecap=[cap]
        d=(d) {} }
    };
    match class {
        "area" => html! { path fill=(colour) d=(d) {} },
        "pale" => html! { path fill=(colour) fill-opacity="0.4" d=(d) {} },
        // Bands of several series lie on each other.
        "spread" => html! { path fill=(colour) fill-opacity="0.2" d=(d) {} },
        "broad" => line(20, None, Some("butt")),
        "dashed" => line(5, Some("24 16"), Some("butt")),
        "dots" => line(18, None, None),
        "mark" => html! { path fill="none" stroke=(INK) stroke-width="5" stroke-linecap="butt" d=(d) {} },
        _ => line(7, None, None),
    }
}

/// A line of text centred on an ordinate.
fn text(x: f64, y: f64, anchor: Anchor, colour: &str, text: &str) -> Markup {
    let anchor = match anchor {
        Anchor::Start => None,
        Anchor::Middle => Some("middle"),
        Anchor::End => Some("end"),
    };
    let escaped = html! { (text) }.into_string();
    let set = subscripts(&escaped, r#"<tspan baseline-shift="sub" font-size="75%">"#, "</tspan>");
    // Capitals of Helvetica are 0.72 em high.
    html! { text x=(x.round()) y=((y + 0.36 * TYPE).round()) text-anchor=[anchor] fill=(colour) { (PreEscaped(set)) } }
}
