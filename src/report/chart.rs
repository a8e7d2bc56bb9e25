//! Charts of a page: data for plotly.js, short enough for a file that is sent by mail.

use std::sync::LazyLock;

use maud::{Markup, PreEscaped, html};
use plotters::style::RGBColor;
use serde_json::{Value, json};

use crate::figures;

/// The colours of the figures, as a page writes them.
static INKS: LazyLock<[String; 8]> =
    LazyLock::new(|| figures::PALETTE.map(|RGBColor(red, green, blue)| format!("#{red:02X}{green:02X}{blue:02X}")));

/// Points of a curve are thinned to the extremes of so many columns.
const COLUMNS: usize = 900;

/// A chart of the page.
pub(super) struct Chart {
    /// Its name in the page.
    pub(super) id: String,
    /// What it shows, as a caption.
    pub(super) caption: String,
    /// Curves and bars.
    pub(super) data: Vec<Value>,
    /// Axes.
    pub(super) layout: Value,
    /// Height \[px\].
    pub(super) height: u32,
    /// Charts of one group are zoomed along x together.
    pub(super) group: &'static str,
}

impl Chart {
    /// The chart as part of the page.
    pub(super) fn markup(&self) -> Markup {
        html! {
            figure.chart {
                div.plot id={ "chart-" (self.id) } data-group=(self.group) style={ "height:" (self.height) "px" } role="img"
                    aria-label=(self.caption) {}
                (data(&format!("chart-{}-data", self.id), &json!({ "data": self.data, "layout": self.layout })))
                figcaption { (self.caption) }
            }
        }
    }
}

/// A JSON value that the page's script finds under this name.
fn data(id: &str, value: &Value) -> Markup {
    // A text in the data must not end the element that holds it.
    let text = value.to_string().replace('<', "\\u003c");
    html! { script type="application/json" id=(id) { (PreEscaped(text)) } }
}

/// The colour at a place of the figures' palette.
pub(super) fn ink(place: usize) -> &'static str {
    &INKS[place]
}

/// Colour of a source.
pub(super) fn colour(source: &str, place: usize) -> &'static str {
    ink(figures::in_palette(source, place))
}

/// A number with five digits; null where it is none.
pub(super) fn short(value: f64) -> Value {
    let rounded = format!("{value:.4e}").parse::<f64>().ok().filter(|v| v.is_finite());
    rounded.map_or(Value::Null, |value| {
        if value.fract() == 0.0 && value.abs() < 1e9 {
            json!(value as i64)
        } else {
            json!(value)
        }
    })
}

/// A level with two decimals; null for silence.
pub(super) fn decibel(level: Option<f64>) -> Value {
    level.map_or(Value::Null, |level| json!((100.0 * level).round() / 100.0))
}

/// A curve, thinned so that every peak stays.
pub(super) fn curve(name: &str, colour: &str, x: &[f64], y: &[f64]) -> Value {
    let kept = thin(y);
    let of = |values: &[f64]| kept.iter().map(|&index| short(values[index])).collect::<Vec<_>>();
    json!({
        "type": "scatter", "mode": "lines", "name": name, "x": of(x), "y": of(y),
        "line": { "color": colour, "width": 1.6 },
    })
}

/// Indices of the first, last, lowest and highest of every column.
fn thin(y: &[f64]) -> Vec<usize> {
    let column = y.len().div_ceil(COLUMNS).max(1);
    if column < 3 {
        return (0..y.len()).collect();
    }
    let mut kept = Vec::with_capacity(4 * COLUMNS);
    for first in (0..y.len()).step_by(column) {
        let last = (first + column).min(y.len()) - 1;
        let by = |a: &usize, b: &usize| y[*a].total_cmp(&y[*b]);
        let mut own = [
            first,
            (first..=last).min_by(by).unwrap_or(first),
            (first..=last).max_by(by).unwrap_or(first),
        ];
        own.sort_unstable();
        for index in own {
            if kept.last() != Some(&index) {
                kept.push(index);
            }
        }
    }
    if kept.last() != Some(&(y.len() - 1)) {
        kept.push(y.len() - 1);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spike_of_one_sample_stays() {
        let mut y = vec![0.0; 20_000];
        y[12_345] = 7.0;
        y[777] = -3.0;
        let kept = thin(&y);
        assert!(kept.contains(&12_345) && kept.contains(&777) && kept.contains(&19_999));
        assert!(kept.len() <= 4 * COLUMNS && kept.windows(2).all(|pair| pair[0] < pair[1]));
    }

    #[test]
    fn data_cannot_end_its_element() {
        let text = data("d", &json!("</script><b>")).into_string();
        assert_eq!(text.matches("</script>").count(), 1, "{text}");
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(short(0.123_456_789), json!(0.12346));
        assert_eq!(short(f64::NAN), Value::Null);
        assert_eq!(short(2000.0), json!(2000));
    }
}
