//! Charts of a page: data for plotly.js, short enough for a file that is sent by mail.
//!
//! Written as JSON: the types of the plotly crate lack the base of a bar and the data behind its label.

use maud::{Markup, PreEscaped, html};
use serde_json::{Value, json};

use crate::figures::{Axis, Chart, Event, PALETTE, Panel, Series, Shape, subscripts};

/// Rows over a chart on which the symbols of events take turns.
const ROWS: usize = 3;

/// A drawing by plotly.js.
pub(super) struct Plot {
    /// Its name in the page.
    pub(super) id: String,
    /// What it shows, for screen readers.
    pub(super) description: String,
    /// Curves and bars.
    pub(super) data: Vec<Value>,
    /// Axes.
    pub(super) layout: Value,
    /// Height \[px\].
    pub(super) height: u32,
    /// Plots of one group are zoomed along x together.
    pub(super) group: &'static str,
}

impl Plot {
    /// The plot as part of the page.
    pub(super) fn markup(&self) -> Markup {
        html! {
            div.plot id={ "chart-" (self.id) } data-group=(self.group) style={ "height:" (self.height) "px" } role="img"
                aria-label=(self.description) {}
            (data(&format!("chart-{}-data", self.id), &json!({ "data": self.data, "layout": self.layout })))
        }
    }
}

/// A chart as part of the page: a plot for each panel.
pub(super) fn markup(chart: &Chart) -> Markup {
    html! {
        figure.chart {
            @for (index, panel) in chart.panels.iter().enumerate() { (plot(chart, index, panel).markup()) }
            figcaption { (chart.caption) }
        }
    }
}

fn plot(chart: &Chart, index: usize, panel: &Panel) -> Plot {
    let mut layout = json!({
        "xaxis": axis(&panel.x), "yaxis": axis(&panel.y), "barmode": "group",
        "hovermode": if panel.x.categories.is_empty() { "closest" } else { "x unified" },
    });
    if !panel.y.categories.is_empty() {
        layout["yaxis"]["autorange"] = json!("reversed");
        layout["yaxis"]["title"]["standoff"] = json!(12);
        layout["barmode"] = json!("overlay");
    }
    let mut data: Vec<Value> = panel.series.iter().flat_map(|series| traces(panel, series)).collect();
    // The last trace is drawn on top, and bars stand in the order of their traces.
    if !panel
        .series
        .iter()
        .any(|series| matches!(series.shape, Shape::Bars(_) | Shape::Whiskers(_)))
    {
        data.reverse();
        layout["legend"] = json!({ "traceorder": "reversed" });
    }
    mark_events(&mut layout, &chart.events);
    Plot {
        id: if index == 0 {
            chart.name.clone()
        } else {
            format!("{}-{}", chart.name, index + 1)
        },
        description: subscripts(&format!("{}: {}", panel.y.title(), chart.caption), "", ""),
        data,
        layout,
        height: 160 + 3 * panel.height,
        group: if chart.events.is_empty() { "" } else { "time" },
    }
}

fn axis(axis: &Axis) -> Value {
    let title = json!({ "text": subscripts(&axis.title(), "<sub>", "</sub>") });
    if axis.categories.is_empty() {
        return json!({ "title": title, "range": axis.range.map(short) });
    }
    let ticks: Vec<&String> = axis.ticks.iter().map(|&place| &axis.categories[place]).collect();
    json!({ "title": title, "type": "category", "tickmode": "array", "tickvals": ticks, "categoryarray": axis.categories })
}

/// Marks the events over a chart in time.
fn mark_events(layout: &mut Value, events: &[Event]) {
    let line = |event: &Event| {
        json!({
            "type": "line", "xref": "x", "yref": "paper", "x0": event.at, "x1": event.at, "y0": 0, "y1": 1,
            "line": { "color": "#b8b8b8", "width": 0.8 }, "layer": "below",
        })
    };
    let name = |(place, event): (usize, &Event)| {
        json!({
            "xref": "x", "yref": "paper", "x": event.at, "y": 1.0, "yshift": 2 + 11 * (place % ROWS) as i64,
            "yanchor": "bottom", "showarrow": false, "text": event.symbol, "font": { "size": 11, "color": "#555" },
            "hovertext": format!("{}: {}, {:.2} ms", event.symbol, event.name, event.at),
        })
    };
    if !events.is_empty() {
        layout["shapes"] = events.iter().map(line).collect();
        layout["annotations"] = events.iter().enumerate().map(name).collect();
        layout["margin"] = json!({ "t": 48 });
    }
}

/// A series as traces of plotly.
fn traces(panel: &Panel, series: &Series) -> Vec<Value> {
    let numbers = |values: &[f64]| values.iter().copied().map(short).collect::<Vec<_>>();
    let names = |axis: &Axis, values: &[f64]| match axis.categories.as_slice() {
        [] => numbers(values),
        names => values.iter().map(|&place| json!(names[place as usize])).collect(),
    };
    let (x, y, color) = (
        names(&panel.x, &series.x),
        names(&panel.y, &series.y),
        colour(series.colour),
    );
    let line = |more: Value| {
        let mut style = json!({ "color": color, "width": 1.6 });
        style
            .as_object_mut()
            .into_iter()
            .for_each(|style| style.extend(more.as_object().cloned().unwrap_or_default()));
        json!({ "type": "scatter", "mode": "lines", "name": series.name, "x": x, "y": y, "line": style })
    };
    match &series.shape {
        Shape::Line => vec![line(json!({}))],
        Shape::Broad => vec![line(json!({ "width": 5 }))],
        Shape::Dashed => vec![line(json!({ "dash": "dash", "width": 1.2 }))],
        Shape::Steps => {
            let mut steps = line(json!({ "shape": "hvh", "width": 2 }));
            steps["mode"] = json!("lines+markers");
            vec![steps]
        }
        Shape::Points => {
            let mut dots = line(json!({}));
            dots["mode"] = json!("markers");
            dots["marker"] = json!({ "color": color, "size": 5, "opacity": 0.7 });
            vec![dots]
        }
        Shape::Whiskers(ends) => {
            // Bars of a group without a name would not lie over each other.
            let group = format!("group {}", series.name);
            let low: Vec<f64> = ends.iter().map(|[low, _]| *low).collect();
            let heights: Vec<f64> = ends.iter().map(|[low, high]| high - low).collect();
            let middle: Vec<Value> = series.y.iter().map(|y| short(y - 0.1)).collect();
            let thin: Vec<f64> = series
                .y
                .iter()
                .map(|y| if y.is_finite() { 0.2 } else { f64::NAN })
                .collect();
            vec![
                json!({
                    "type": "bar", "name": series.name, "offsetgroup": group, "x": x, "base": numbers(&low),
                    "y": numbers(&heights), "customdata": series.notes, "hovertemplate": "%{customdata}", "showlegend": !series.name.is_empty(),
                    "marker": { "color": format!("{color}80") },
                }),
                json!({
                    "type": "bar", "offsetgroup": group, "x": x, "base": middle, "y": numbers(&thin), "hoverinfo": "skip",
                    "marker": { "color": "#222" }, "showlegend": false,
                }),
            ]
        }
        Shape::Band(lower) => {
            let back = |values: &[f64]| values.iter().rev().copied().map(short).collect::<Vec<_>>();
            vec![json!({
                "type": "scatter", "mode": "lines", "fill": "toself", "fillcolor": format!("{color}21"), "hoverinfo": "skip",
                "x": ([x, back(&series.x)].concat()), "y": ([y, back(lower)].concat()), "line": { "width": 0 }, "showlegend": false,
            })]
        }
        // Bars stand on the lower end of the axis: a level has no zero of its own.
        Shape::Bars(marks) => {
            let floor = panel.y.range[0];
            let above = |values: &[f64]| {
                let height = |value: &f64| short((value - floor).max(0.0));
                values.iter().map(height).collect::<Vec<_>>()
            };
            let mut traces = vec![json!({
                "type": "bar", "name": series.name, "offsetgroup": series.name, "x": x, "base": floor, "y": above(&series.y),
                "customdata": series.notes, "hovertemplate": "%{customdata}", "marker": { "color": color }, "showlegend": !series.name.is_empty(),
            })];
            if !marks.is_empty() {
                let base: Vec<Value> = marks.iter().map(|mark| short(mark - 0.1)).collect();
                let thin: Vec<f64> = marks
                    .iter()
                    .map(|mark| if *mark > floor { 0.2 } else { f64::NAN })
                    .collect();
                traces.push(json!({
                    "type": "bar", "offsetgroup": series.name, "x": x, "base": base, "y": numbers(&thin), "hoverinfo": "skip",
                    "marker": { "color": "#222" }, "showlegend": false,
                }));
            }
            traces
        }
        Shape::Spans(from) => {
            // To the right, where the text has its place.
            let lower: Vec<f64> = series.x.iter().zip(from).map(|(to, from)| from.min(*to)).collect();
            let lengths: Vec<f64> = series.x.iter().zip(from).map(|(to, from)| (to - from).abs()).collect();
            vec![json!({
                "type": "bar", "orientation": "h", "name": series.name, "base": numbers(&lower), "x": numbers(&lengths), "y": y,
                "text": series.notes, "textposition": "outside", "cliponaxis": false, "hovertemplate": "%{y}: %{text} J",
                "marker": { "color": color },
            })]
        }
    }
}

/// A JSON value that the page's script finds under this name.
fn data(id: &str, value: &Value) -> Markup {
    // A text in the data must not end the element that holds it.
    let text = value.to_string().replace('<', "\\u003c");
    html! { script type="application/json" id=(id) { (PreEscaped(text)) } }
}

/// The colour at a place of the palette.
pub(super) fn colour(place: usize) -> String {
    let [red, green, blue] = PALETTE[place];
    format!("#{red:02X}{green:02X}{blue:02X}")
}

/// A number with five digits; null where it is none.
fn short(value: f64) -> Value {
    let rounded = format!("{value:.4e}").parse::<f64>().ok().filter(|v| v.is_finite());
    rounded.map_or(Value::Null, |value| {
        if value.fract() == 0.0 && value.abs() < 1e9 {
            json!(value as i64)
        } else {
            json!(value)
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

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
