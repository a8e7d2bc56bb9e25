//! Labels along the axes of a page.

use maud::{Markup, html};

use crate::figures::ticks::Tick;

/// Labels along an axis; their positions are relative to this `side` of the box.
pub(super) fn labels(ticks: &[Tick], side: &str) -> Markup {
    html! { @for tick in ticks {
        span.tick.w[!tick.narrow] style={ (side) ":" (percent(tick.at)) } { (tick.label) }
    } }
}

/// A fraction as a CSS length.
pub(super) fn percent(part: f64) -> String {
    let rounded = (1e4 * part).round() / 1e2;
    format!("{rounded}%")
}
