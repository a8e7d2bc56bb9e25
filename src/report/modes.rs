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

/// All modes as indices of their body and in its basis, loudest first.
fn by_level(bodies: &[ColouredSurface<'_>]) -> Vec<(usize, usize)> {
    let modes =
        |(body, painted): (usize, &ColouredSurface<'_>)| (0..painted.body.basis.hz.len()).map(move |mode| (body, mode));
    let mut modes: Vec<(usize, usize)> = bodies.iter().enumerate().flat_map(modes).collect();
    let energy = |own: &(usize, usize)| bodies[own.0].modes[own.1];
    modes.sort_by(|a, b| energy(b).total_cmp(&energy(a)));
    modes
}

/// The modes that are drawn, as indices of their body and in its basis.
pub(super) fn drawn(bodies: &[ColouredSurface<'_>]) -> Vec<(usize, usize)> {
    let mut modes = by_level(bodies);
    modes.truncate(DRAWN);
    modes
}

/// The frequency of a mode, or that it is rigid.
fn name(painted: &ColouredSurface<'_>, mode: usize) -> String {
    match painted.body.basis.rigid[mode] {
        true => "rigid".to_owned(),
        false => format!("{:.0} Hz", painted.body.basis.hz[mode]),
    }
}

/// A mode in words: `workpiece, mode 12, 843 Hz`.
pub(super) fn title(painted: &ColouredSurface<'_>, mode: usize) -> String {
    format!("{}, mode {}, {}", painted.body.name, mode + 1, name(painted, mode))
}

/// The section; empty for a tool without elastic bodies.
pub(super) fn section(bodies: &[ColouredSurface<'_>]) -> Markup {
    if bodies.is_empty() {
        return html! {};
    }
    let modes = by_level(bodies);
    let modes: Vec<(&ColouredSurface<'_>, usize)> = modes.iter().map(|(body, mode)| (&bodies[*body], *mode)).collect();
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
        div.pictures { @for (place, ((painted, mode), picture)) in drawn.iter().zip(&pictures).enumerate() {
            figure {
                img src=(picture) width="480" height="330"
                    alt={ "deflection of the " (painted.body.name) " in mode " (mode + 1) ", " (name(painted, *mode)) };
                figcaption {
                    (painted.body.name) ", mode " (mode + 1) ", " b { (name(painted, *mode)) } br;
                    (decibels(level(painted.modes[*mode]))) " dB alone "
                    button.with-script.in-space type="button" data-mode=(place) { "Animate" }
                }
            }
        } }
        (table::markup(&Table::new(columns, listed)))
        p.quiet { (modes.len()) " modes in all: " a href="#checks" { "their number is proven by a Sturm count" } "." }
    }
}
