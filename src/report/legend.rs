//! Legends of charts, and texts with subscripts.

use maud::{Markup, PreEscaped, html};

use crate::figures::{Panel, Shape, subscripts};

/// A text with `_{...}` as a subscript.
pub(super) fn marked(text: &str) -> Markup {
    let escaped = html! { (text) }.into_string();
    PreEscaped(subscripts(&escaped, "<sub>", "</sub>"))
}

/// Entries for the series that have a name.
pub(super) fn legend(panel: &Panel) -> Markup {
    let named = panel.series.iter().enumerate().filter(|(_, own)| !own.name.is_empty());
    html! {
        div.legend { @for (place, series) in named {
            button type="button" class={ "key c" (series.colour) " " (sample(&series.shape)) } data-series=(place)
                aria-pressed="true" {
                (marked(&series.name))
            }
        } }
    }
}

fn sample(shape: &Shape) -> &'static str {
    match shape {
        Shape::Line | Shape::Steps => "line",
        Shape::Broad => "broad",
        Shape::Dashed => "dashed",
        Shape::Points => "dots",
        Shape::Bars(_) | Shape::Spans(_) | Shape::Swings(_) => "area",
        Shape::Band(_) | Shape::Whiskers(_) => "pale",
    }
}
