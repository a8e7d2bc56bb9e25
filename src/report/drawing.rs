//! The drawing of the tool on a page: one figure per view, the legend of provenances, and a table of the keys.
//!
//! The page is complete without its script, which highlights a key in all views and in the table.

use maud::{Markup, PreEscaped, html};

use crate::design::{Design, inputs};
use crate::drawing::{self, Drawing};

/// The drawing of a design.
pub(super) fn section(design: &Design) -> Markup {
    if let Ok(Some(cycle)) = inputs::assembly::cycle(design) {
        return html! {
            p.quiet { "The network of the tool: spaces, bodies and triggers are columns, passages, faces and forces \
                are rows." }
            div.scroll { (PreEscaped(drawing::network(design.name(), &cycle.assembly))) }
        };
    }
    let drawing = Drawing::new(design);
    let labels = drawing.shown();
    html! {
        p.quiet {
            "The tool at the dimensions of this design. Point at a key or its dimension, or use the Tab key, for \
             value, range and source. \
             The scales apply in print, at a width of 180 mm. Parts without a key are schematic: thickness of the \
             piston, ring of the head valve, trigger valve."
        }
        ul.legend-of-drawing { @for (standing, symbol) in drawing.legend() {
            li { svg class="drawing sample" viewBox="-6 -6 12 12" aria-hidden="true" { (symbol) } (standing.words()) }
        } }
        @if drawing.is_based() {
            p.quiet { "Values in italics are those of the base of the design." }
        }
        @for (title, figure) in drawing.figures() {
            figure.of-tool { figcaption { (title) } div.scroll { (figure) } }
        }
        @if !drawing.misfits.is_empty() {
            h3 { "Keys that do not fit together as drawn" }
            p.quiet { "The cycle and the vibrating housing use different keys, and a run does not need them to agree." }
            ul.notes { @for misfit in &drawing.misfits { li {
                (misfit.text) " "
                span.quiet { "(" @for (index, key) in misfit.keys.iter().enumerate() { @if index > 0 { ", " }
                    span.key-name { (key) } } ")" }
            } } }
        }
        details {
            summary { (labels.len()) " keys of the drawing" }
            div.scroll { table.keys-of-drawing {
                thead { tr { th { "key" } th { "symbol" } th.n { "value" } th { "provenance" } } }
                tbody { @for label in &labels {
                    tr data-key=(label.key) tabindex="0" title=(label.title) {
                        td.key-name { (label.key) }
                        td { (label.symbol) }
                        td.n { (label.value) }
                        td { (label.standing.words()) }
                    }
                } }
            } }
        }
    }
}
