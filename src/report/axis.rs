//! Labels along the axes of a page.

use maud::{Markup, html};

use crate::figures::ticks::Tick;

/// Labels along an axis; `side` is the reference side of the box for their places.
pub(super) fn labels(ticks: &[Tick], side: &str) -> Markup {
    html! { @for tick in ticks {
        span.tick.w[!tick.narrow] style={ (side) ":" (percent(tick.at)) } { (tick.label) }
    } }
}

/// A part as a length of CSS.
pub(super) fn percent(part: f64) -> String {
    let rounded = (1e4 * part).round() / 1e2;
    format!("{rounded}%")
}
