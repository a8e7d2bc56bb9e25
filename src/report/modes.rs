//! The loudest modes: table and pictures.

use maud::{Markup, html};
use rayon::prelude::*;

use super::surface::ColouredSurface;
use super::tables::decibels;
use super::{picture, table};
use crate::tables::{self, Cell, Column, Table, dash};
use crate::wording::change;

/// Number of modes in the table, and number of those that are drawn.
const LISTED: usize = 15;
const DRAWN: usize = 6;

/// All modes as indices of their body and in its basis, loudest first with their own radiation efficiency. A mode
/// without one takes its place by its level at efficiency 1, so that none is hidden.
fn by_level(bodies: &[ColouredSurface<'_>]) -> Vec<(usize, usize)> {
    let modes =
        |(body, painted): (usize, &ColouredSurface<'_>)| (0..painted.body.basis.hz.len()).map(move |mode| (body, mode));
    let mut modes: Vec<(usize, usize)> = bodies.iter().enumerate().flat_map(modes).collect();
    let level = |&(body, mode): &(usize, usize)| {
        let painted: &ColouredSurface<'_> = &bodies[body];
        let known = painted.own_level(mode).or_else(|| painted.level_at_one(mode));
        known.unwrap_or(f64::NEG_INFINITY)
    };
    modes.sort_by(|a, b| level(b).total_cmp(&level(a)));
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

/// The level of a mode alone, with its own radiation efficiency if that is known.
fn level_text(painted: &ColouredSurface<'_>, mode: usize) -> String {
    match painted.own_level(mode) {
        Some(level) => format!("{} dB alone", decibels(Some(level))),
        None => format!(
            "{} dB alone at radiation efficiency 1",
            decibels(painted.level_at_one(mode))
        ),
    }
}

/// How the radiation efficiencies of each body are known: `workpiece by boundary elements`.
fn methods(bodies: &[ColouredSurface<'_>]) -> String {
    let of_body = |painted: &ColouredSurface<'_>| {
        let method = painted.efficiencies.map_or("not computed", |own| &own.method);
        format!("{}: {method}", painted.body.name)
    };
    bodies.iter().map(of_body).collect::<Vec<_>>().join("; ")
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
            tables::decibels(painted.own_level(*mode)),
            dash(painted.efficiency_db(*mode), change),
            decibels(painted.level_at_one(*mode)),
            painted.loss_factor.to_string(),
        ];
        cells.map(Cell::from).to_vec()
    });
    let numbers = [
        "mode",
        "frequency",
        "alone, L_{WA,1s} dB",
        "radiation efficiency dB",
        "at radiation efficiency 1 dB",
        "loss factor",
    ];
    let numbers = numbers.map(Column::number);
    let columns = std::iter::once(Column::words("body")).chain(numbers);
    html! {
        p.quiet {
            "What each mode alone would radiate, A-weighted, from its motion in this shot: with its own radiation \
             efficiency at its natural frequency, and with radiation efficiency 1. Modes radiate together, and one may \
             cancel another, so that these levels do not sum to the source\u{2019}s. Loudest first; a mode without an \
             efficiency of its own, such as a rigid one, which has no natural frequency, is placed by its level at \
             radiation efficiency 1. Radiation efficiencies: " (methods(bodies)) "."
        }
        div.pictures { @for (place, ((painted, mode), picture)) in drawn.iter().zip(&pictures).enumerate() {
            figure {
                img src=(picture) width="480" height="330"
                    alt={ "deflection of the " (painted.body.name) " in mode " (mode + 1) ", " (name(painted, *mode)) };
                figcaption {
                    (painted.body.name) ", mode " (mode + 1) ", " b { (name(painted, *mode)) } br;
                    (level_text(painted, *mode)) " "
                    button.with-script.in-space type="button" data-mode=(place) { "Animate" }
                }
            }
        } }
        (table::markup(&Table::new(columns, listed)))
        p.quiet { (modes.len()) " modes in all: " a href="#checks" { "their number is proven by a Sturm count" } "." }
    }
}
