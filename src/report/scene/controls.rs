//! The controls of the surfaces in space, which scripts of the page operate.

use maud::{Markup, html};

use super::super::modes;
use super::super::surface::ColouredSurface;
use super::triangles::Triangles;
use super::view::View;

/// Directions to look from: the value for the script, and the words.
const DIRECTIONS: [(&str, &str); 7] = [
    ("first", "front, right and above"),
    ("front", "the front"),
    ("right", "the right"),
    ("back", "the back"),
    ("left", "the left"),
    ("above", "above"),
    ("below", "below"),
];

/// Choice of the frequency range and of the mode.
pub(super) fn range_and_mode(views: &[View], bodies: &[ColouredSurface<'_>]) -> Markup {
    html! {
        div.choice.in-space {
            label { "Shown " select.view { @for (index, view)
                in views.iter().enumerate() { option value=(index) { (view.label) } }
                option value="mode" disabled { "displacement of the mode" } } }
            " "
            label { "Mode " select.mode { option value="" { "none" } @for (index, (body, mode))
                in modes::drawn(bodies).into_iter().enumerate() {
                    option value=(index) { (modes::title(&bodies[body], mode)) } } } }
            " " button.play type="button" hidden { "Play" }
        }
    }
}

/// The direction of the view, its size and place, edges, and the distance between the bodies.
pub(super) fn view_controls() -> Markup {
    let button = |name: &str, label: &str, text: &str| {
        html! {
            button type="button" data-tool=(name) aria-label=(label) title=(label) { (text) }
        }
    };
    html! {
        div.tools.with-script.in-space role="group" aria-label="View" {
            label { "From " select.direction {
                @for (value, words) in DIRECTIONS { option value=(value) { (words) } }
                option value="" disabled hidden { "another side" }
            } }
            label { "Dragging " select.dragging { option value="turn" { "turns" } option value="move" { "moves" } } }
            span.buttons {
                (button("closer", "Zoom in", "+")) (button("farther", "Zoom out", "\u{2212}"))
                (button("fit", "Fit the shown parts into the view", "Fit"))
                (button("reset", "First view of all parts", "Reset"))
            }
            label { input.edges type="checkbox" checked; " Edges" }
            label.apart { "Apart " input type="range" min="0" max="100" step="5" value="0"
                aria-label="Distance between the bodies, and between board and block" ; }
        }
    }
}

/// A list of bodies and of their parts, each of which can be hidden or shown alone.
pub(super) fn parts(surfaces: &[Triangles<'_>]) -> Markup {
    let mut next = 0;
    let bodies = surfaces
        .iter()
        .filter(|surface| !surface.parts.is_empty())
        .map(|surface| {
            let body = surface.painted.body.name.to_string();
            let first = next;
            next += surface.parts.len();
            let own = surface.parts.iter().enumerate();
            let parts = own.map(|(place, part)| (part.name.clone(), first + place..first + place + 1));
            let parts: Vec<_> = parts.filter(|_| surface.parts.len() > 1).collect();
            (body, first..next, parts)
        });
    let bodies: Vec<_> = bodies.collect();
    let entry = |class: &str, label: &str, name: &str, range: &std::ops::Range<usize>| {
        let numbers: Vec<String> = range.clone().map(|part| part.to_string()).collect();
        html! {
            div class=(class) data-parts=(numbers.join(" ")) {
                label { input type="checkbox" checked aria-label={ "Show " (name) }; " " (label) }
                span.most {}
                button type="button" aria-pressed="false" aria-label={ "Show only " (name) } { "Only" }
            }
        }
    };
    html! {
        fieldset.parts.with-script.in-space {
            legend { "Parts, each with the highest level of its faces" }
            @for (body, range, parts) in &bodies {
                div.of-body {
                    (entry("entry", body, &format!("the {body}"), range))
                    @for (part, range) in parts {
                        (entry("entry inner", part, &format!("the {part} of the {body}"), range))
                    }
                }
            }
        }
    }
}
