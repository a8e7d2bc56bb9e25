//! Legends of charts.

use maud::{Markup, html};

use super::typography::with_subscripts;
use crate::figures::{Panel, Shape};

/// Entries for the series that have a name.
pub(super) fn legend(panel: &Panel) -> Markup {
    let named = panel.series.iter().enumerate().filter(|(_, own)| !own.name.is_empty());
    html! {
        div.legend { @for (place, series) in named {
            button type="button" class={ "key c" (series.colour) " " (sample(&series.shape)) } data-series=(place)
                aria-pressed="true" {
                (with_subscripts(&series.name))
            }
        } }
    }
}

fn sample(shape: &Shape) -> &'static str {
    match shape {
        Shape::Line | Shape::Steps | Shape::Errors(_) => "line",
        Shape::Broad => "broad",
        Shape::Dashed => "dashed",
        Shape::Points => "dots",
        Shape::Bars(_) | Shape::Spans(_) | Shape::Swings(_) => "area",
        Shape::Band(_) => "spread",
        Shape::Whiskers(_) => "pale",
    }
}
