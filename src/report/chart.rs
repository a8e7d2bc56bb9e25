//! Charts of a page: the curves as SVG that stretches to the width of the window, with HTML texts around them.
//!
//! A chart is complete without a script. The script of the page reads the values under the pointer from the curves,
//! whose coordinates are relative to a box of [`FRAME`] between the ends of the axes.

use maud::{Markup, html};

use super::axis::{labels, percent};
use super::legend::legend;
use super::typography::with_subscripts;
use crate::figures::path::Frame;
use crate::figures::ticks::{Tick, across, rows, upwards};
use crate::figures::{Chart, Event, PALETTE, Panel, Series, hexadecimal, subscripts};

/// Box of the coordinates of a plot.
const FRAME: Frame = Frame {
    across: 4000.0,
    up: 2000.0,
};

/// Points of a series whose dots are large.
const FEW: usize = 16;

/// Width of the symbol of an event \[px\].
const SYMBOL: f64 = 21.0;

/// Colours on a dark page, in the order of the [`PALETTE`].
const DARK: [&str; 20] = [
    "#4DA3DC", "#F0803C", "#2FBF93", "#DC98BD", "#E9B23C", "#7CC8F2", "#ECEFF2", "#9AA2AB", "#8C84F0", "#5DBB7B",
    "#D487C6", "#C2C25A", "#E58A99", "#52BDAE", "#B9527B", "#8DB5D6", "#D98A5F", "#A7AFBA", "#DDAF3A", "#E0C3FF",
];

/// A chart as part of the page.
pub(super) fn markup(chart: &Chart) -> Markup {
    html! {
        figure.chart id={ "chart-" (chart.name) } {
            @for panel in &chart.panels {
                @if panel.y.categories.is_empty() { (plot(chart, panel)) } @else { (super::rows::markup(panel)) }
            }
            figcaption { (with_subscripts(&chart.caption)) }
        }
    }
}

/// The colours of series as custom properties, for light and for dark pages.
pub(super) fn colours() -> String {
    let property = |(place, colour): (usize, String)| format!("--c{place}:{colour};");
    let light: String = (0..PALETTE.len()).map(hexadecimal).enumerate().map(property).collect();
    let dark: String = DARK.map(str::to_owned).into_iter().enumerate().map(property).collect();
    let classes: String = (0..PALETTE.len())
        .map(|place| format!(".c{place}{{--c:var(--c{place})}}"))
        .collect();
    format!(":root{{{light}}}@media screen and (prefers-color-scheme:dark){{:root{{{dark}}}}}{classes}")
}

/// A pair of axes with a linear vertical axis.
fn plot(chart: &Chart, panel: &Panel) -> Markup {
    let height = panel.pixels();
    let (xs, ys) = (across(&panel.x), upwards(&panel.y, height));
    let [left, right] = panel.x.range;
    let events: Vec<(&Event, f64)> = chart
        .events
        .iter()
        .map(|event| (event, (event.at - left) / (right - left)))
        .filter(|(_, at)| (0.0..=1.0).contains(at))
        .collect();
    let description = format!("{}: {}", panel.y.title(), chart.caption);
    html! {
        div.panel data-x={ (left) " " (right) } data-y={ (panel.y.range[0]) " " (panel.y.range[1]) }
            data-unit=(panel.y.unit)
            data-across=(panel.x.unit) data-group=[(!chart.events.is_empty()).then_some("time")]
            data-categories=[(!panel.x.categories.is_empty()).then(|| panel.x.categories.join("|"))] {
            (legend(panel))
            p.axis { (with_subscripts(&panel.y.title())) }
            div.frame {
                (symbols(&events))
                div.ys aria-hidden="true" { (labels(&ys, "bottom")) }
                div.plot style={ "height:" (height) "px" } role="img" aria-label=(subscripts(&description, "", "")) {
                    svg viewBox={ "0 0 " (FRAME.across) " " (FRAME.up) } preserveAspectRatio="none" aria-hidden="true" {
                        path.grid d=(grid(&ys)) {}
                        @if !events.is_empty() { path.moments d=(moments(&events)) {} }
                        @for (place, own) in panel.in_order() { (series(panel, place, own)) }
                    }
                }
                div.xs aria-hidden="true" { (labels(&xs, "left")) }
            }
            p.axis.below { (with_subscripts(&panel.x.title())) }
        }
    }
}

fn series(panel: &Panel, place: usize, series: &Series) -> Markup {
    let of_categories = !panel.x.categories.is_empty();
    // A position for each category; a gap if the series has no value.
    let values = || {
        let mut values = vec![String::new(); panel.x.categories.len()];
        for (x, y) in series.x.iter().zip(&series.y).filter(|(_, y)| y.is_finite()) {
            if let Some(value) = values.get_mut(*x as usize) {
                *value = format!("{y:.2}");
            }
        }
        values.join(" ")
    };
    html! {
        g class={ "s c" (series.colour) } data-series=(place)
            data-name=[(!series.name.is_empty()).then(|| subscripts(&series.name, "", ""))]
            data-values=[of_categories.then(values)]
                data-notes=[(!series.notes.is_empty()).then(|| series.notes.join("|"))] {
            @for (class, d) in FRAME.paths(panel, place, series) {
                path class=(class) d=(d) data-few[class == "dots" && series.x.len() <= FEW] {}
            }
        }
    }
}

/// The symbols of events above a plot.
fn symbols(events: &[(&Event, f64)]) -> Markup {
    let places: Vec<f64> = events.iter().map(|(_, at)| *at).collect();
    let rows = rows(&places, SYMBOL);
    let most = |window: usize| rows.iter().map(|row| row[window] + 1).max().unwrap_or(0);
    html! { @if !events.is_empty() {
        div.events style={ "--wide:" (most(0)) ";--narrow:" (most(1)) } {
            @for ((event, at), [wide, narrow]) in events.iter().zip(&rows) {
                abbr data-at=(event.at) title={ (event.symbol) " " (event.name) ", " (format!("{:.2} ms", event.at)) }
                    style={ "left:" (percent(*at)) ";--wide:" (wide) ";--narrow:" (narrow) } { (event.symbol) }
            }
        }
    } }
}

fn grid(ticks: &[Tick]) -> String {
    let line = |tick: &Tick| format!("M0 {:.0}h{}", FRAME.up * (1.0 - tick.at), FRAME.across);
    ticks.iter().map(line).collect()
}

fn moments(events: &[(&Event, f64)]) -> String {
    let line = |(_, at): &(&Event, f64)| format!("M{:.0} 0v{}", FRAME.across * at, FRAME.up);
    events.iter().map(line).collect()
}
