//! The loudest modes: table and pictures.

use maud::{Markup, html};
use rayon::prelude::*;

use super::surface::{ColouredSurface, level};
use super::tables::decibels;
use super::{picture, table};
use crate::tables::{Cell, Column, Table};

/// Number of modes in the table, and number of those that are drawn.
const LISTED: usize = 15;
const DRAWN: usize = 6;

/// The section; empty for a tool without elastic bodies.
pub(super) fn section(bodies: &[ColouredSurface<'_>]) -> Markup {
    if bodies.is_empty() {
        return html! {};
    }
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
    let listed = modes.iter().take(LISTED).map(|(painted, mode)| {
        let cells = [
            painted.body.name.to_string(),
            (mode + 1).to_string(),
            name(painted, *mode),
            decibels(level(painted.modes[*mode])),
            painted.loss_factor.to_string(),
        ];
        cells.map(Cell::from).to_vec()
    });
    let numbers = ["mode", "frequency", "alone, L_{WA,1s} dB", "loss factor"].map(Column::number);
    let columns = std::iter::once(Column::words("body")).chain(numbers);
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
                    (decibels(level(painted.modes[*mode]))) " dB alone"
                }
            }
        } }
        (table::markup(&Table::new(columns, listed)))
        p.quiet { (modes.len()) " modes in all: " a href="#checks" { "their number is proven by a Sturm count" } "." }
    }
}
