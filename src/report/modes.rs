//! The loudest modes: table and pictures.

use maud::{Markup, html};
use rayon::prelude::*;

use super::picture;
use super::surface::{ColouredSurface, level};

/// Modes in the table, and those that are drawn.
const LISTED: usize = 15;
const DRAWN: usize = 6;

pub(super) fn section(bodies: &[ColouredSurface<'_>]) -> Markup {
    let mut modes: Vec<(&ColouredSurface<'_>, usize)> = bodies
        .iter()
        .flat_map(|painted| (0..painted.body.basis.hz.len()).map(move |mode| (painted, mode)))
        .collect();
    modes.sort_by(|a, b| b.0.modes[b.1].total_cmp(&a.0.modes[a.1]));
    let name = |painted: &ColouredSurface<'_>, mode: usize| -> String {
        if painted.body.basis.rigid[mode] {
            "rigid".to_owned()
        } else {
            format!("{:.0} Hz", painted.body.basis.hz[mode])
        }
    };
    let drawn = &modes[..DRAWN.min(modes.len())];
    let pictures: Vec<String> = drawn
        .par_iter()
        .map(|(painted, mode)| picture::mode(painted.body, *mode))
        .collect();
    html! {
        p.quiet {
            "What each mode alone would radiate at radiation efficiency 1, A-weighted, from its motion in this shot. \
             Modes act \
             together, so that these levels do not sum to the source\u{2019}s."
        }
        div.pictures { @for ((painted, mode), picture) in drawn.iter().zip(&pictures) {
            figure {
                img src=(picture) width="480" height="330"
                    alt={ "deflection of the " (painted.body.name) " in mode " (mode + 1) ", " (name(painted, *mode)) };
                figcaption {
                    (painted.body.name) ", mode " (mode + 1) ", " b { (name(painted, *mode)) } br;
                    (super::tables::decibels(level(painted.modes[*mode]))) " dB alone"
                }
            }
        } }
        div.scroll { table {
            thead { tr { th { "body" } th.n { "mode" } th.n { "frequency" } th.n { "alone, L" sub { "WA,1s" } " dB" }
                th.n { "loss factor" } } }
            tbody { @for (painted, mode) in modes.iter().take(LISTED) { tr {
                td { (painted.body.name) } td.n { (mode + 1) } td.n { (name(painted, *mode)) }
                td.n { (super::tables::decibels(level(painted.modes[*mode]))) } td.n { (painted.loss_factor) }
            } } }
        } }
        p.quiet { (modes.len()) " modes in all: " a href="#checks" { "their number is proven by a Sturm count" } "." }
    }
}
