//! Energy of a shot as two cascades: of the gas, and of the mechanics that its work drives.
//!
//! Each bar begins where the one above it ends, so that inputs build up to the right and losses lead back to what is
//! left at the end.

use nailnoise_dynamics::EnergyFlow;
use plotters::style::RGBColor;

use super::canvas::{Anchor, Canvas, draw};
use super::scale::{Scale, ticks};
use super::style::*;
use super::{Figure, Shot};

/// Part of the largest level below which terms are drawn together.
const SMALL: f64 = 1e-3;

/// Left edge of the bars: the terms' names stand before it.
const BARS: i32 = 52 * MM;
/// Right edge of the bars: their values stand behind it.
const END: i32 = RIGHT - 20 * MM;
/// Height of a row, and of the bar in it.
const ROW: i32 = 5 * MM;
const BAR: i32 = 3 * MM + MM / 2;
/// Room for the heading, over a panel, and for its axis.
const HEADING: i32 = 7 * MM;
const OVER: i32 = 7 * MM;
const FOOT: i32 = 12 * MM;

/// A step of a cascade.
struct Term {
    name: &'static str,
    /// Energy that comes in (positive) or goes out \[J\].
    energy: f64,
    /// Whether it is held at the start or end, rather than flowing.
    stored: bool,
}

struct Cascade {
    title: &'static str,
    terms: Vec<Term>,
}

pub(super) fn figure(shot: &Shot<'_>) -> Figure {
    let cascades = [gas(&shot.record.energy), mechanics(&shot.record.energy)];
    let height = |cascade: &Cascade| OVER + ROW * cascade.terms.len() as i32 + FOOT;
    let total = HEADING + cascades.iter().map(height).sum::<i32>();
    let svg = draw(total, |canvas| {
        canvas.bold("Energy flow", [LEFT, 4 * MM], Anchor::Start, INK);
        canvas.text(shot.subject, [RIGHT, 4 * MM], Anchor::End, GREY);
        let mut top = HEADING;
        for (letter, cascade) in ["a", "b"].into_iter().zip(&cascades) {
            canvas.bold(letter, [3 * MM, top + 3 * MM], Anchor::Start, INK);
            canvas.text(cascade.title, [LEFT, top + 3 * MM], Anchor::Start, INK);
            cascade.paint(canvas, top + OVER);
            top += height(cascade);
        }
    });
    Figure { name: "energy", svg }
}

fn stored(name: &'static str, energy: f64) -> Term {
    Term {
        name,
        energy,
        stored: true,
    }
}

fn flow(name: &'static str, energy: f64) -> Term {
    Term {
        name,
        energy,
        stored: false,
    }
}

fn gas(e: &EnergyFlow) -> Cascade {
    let mut terms = vec![
        flow("hose, enthalpy in", e.supply),
        flow("heat from the walls", e.wall_heat),
        flow("work on the piston", -e.piston_work),
        flow("work on the head valve", -e.valve_work),
        flow("exhaust, enthalpy out", -e.exhaust),
        flow("trigger vent, enthalpy out", -e.vent),
        flow("leak, enthalpy out", -e.leak),
    ];
    gather(&mut terms, e.gas_start, e.gas_residual());
    terms.insert(0, stored("gas at the start", e.gas_start));
    terms.push(stored("gas at the end", -e.gas_end));
    Cascade {
        title: "Gas; enthalpies are counted from 0 K",
        terms,
    }
}

fn mechanics(e: &EnergyFlow) -> Cascade {
    let c = &e.contacts;
    let mut terms = vec![
        flow("gas on the piston", e.piston_work),
        flow("gas on the head valve", e.valve_work),
        flow("air on the rod", e.atmosphere),
        flow("hand", e.hand),
        flow("gravity", e.gravity),
        flow("thrust of the exhaust", e.thrust),
        flow("nail into the wood", -e.penetration),
        flow("rod on nail, impact", -e.nail_impact),
        flow("left with the nail", -e.nail_left),
        flow("friction of the piston", -e.piston_friction),
        flow("friction of the head valve", -e.valve_friction),
        flow("friction in the magazine", -e.magazine_friction),
        flow("bumper", -c.bumper),
        flow("stopper", -c.stopper),
        flow("head valve on the cap", -c.cap),
        flow("head valve on its seat", -c.seat),
        flow("nose on the wood", -c.nose),
        flow("support", -c.support),
        flow("damping in the hand", -e.hand_damping),
    ];
    let largest = e.piston_work.abs().max(e.penetration.abs());
    gather(&mut terms, largest, e.mechanical_residual());
    let (start, end) = (e.kinetic_start + e.elastic_start, e.kinetic_end + e.elastic_end);
    terms.insert(0, stored("springs and motion at the start", start));
    terms.push(stored("springs and motion at the end", -end));
    Cascade {
        title: "Mechanics",
        terms,
    }
}

/// Draws small terms together, so that the cascade still closes. What a published form does not keep is a term of its
/// own; the rounding of a form that keeps energy is too small to be one.
fn gather(terms: &mut Vec<Term>, largest: f64, residual: f64) {
    let small = |energy: f64| energy.abs() < SMALL * largest;
    let rest: f64 = terms
        .iter()
        .map(|term| term.energy)
        .filter(|energy| small(*energy))
        .sum();
    terms.retain(|term| !small(term.energy));
    if rest != 0.0 {
        terms.push(flow("all others", rest));
    }
    if !small(residual) {
        terms.push(flow("not kept by the model", -residual));
    }
}

impl Cascade {
    fn paint(&self, canvas: &mut Canvas<'_>, top: i32) {
        let mut level = 0.0;
        let bars: Vec<[f64; 2]> = self
            .terms
            .iter()
            .map(|term| {
                let from = level;
                level += term.energy;
                [from, level]
            })
            .collect();
        let low = bars.iter().flatten().copied().fold(0.0, f64::min);
        let high = bars.iter().flatten().copied().fold(0.0, f64::max);
        let values = if high > low { [low, high] } else { [0.0, 1.0] };
        let x = Scale {
            values,
            units: [BARS, END],
        };
        let bottom = top + ROW * self.terms.len() as i32;
        let (round, decimals) = ticks(values, 6);
        for value in &round {
            let at = x.at(*value);
            canvas.path([[at, top], [at, bottom]], FAINT, HAIR);
            canvas.path([[at, bottom], [at, bottom + TICK]], INK, FRAME);
            let text = minus(format!("{value:.decimals$}"));
            canvas.text(&text, [at, bottom + 3 * MM], Anchor::Middle, INK);
        }
        canvas.text(
            "Energy (J)",
            [(BARS + END) / 2, bottom + 7 * MM + MM / 2],
            Anchor::Middle,
            INK,
        );
        for (row, (term, bar)) in self.terms.iter().zip(&bars).enumerate() {
            let middle = top + ROW * row as i32 + ROW / 2;
            let [from, to] = bar.map(|value| x.at(value));
            canvas.text(term.name, [BARS - 2 * MM, middle], Anchor::End, INK);
            let (left, right) = (from.min(to), from.max(to));
            canvas.rectangle(
                [left, middle - BAR / 2],
                [right.max(left + FRAME as i32), middle + BAR / 2],
                term.colour(),
                1.0,
            );
            if row + 1 < self.terms.len() {
                canvas.path([[to, middle + BAR / 2], [to, middle + ROW - BAR / 2]], GREY, HAIR);
            }
            canvas.text(&term.value(), [right + MM, middle], Anchor::Start, INK);
        }
        canvas.path([[BARS, top], [BARS, bottom], [END, bottom]], INK, FRAME);
    }
}

impl Term {
    fn colour(&self) -> RGBColor {
        match (self.stored, self.energy >= 0.0) {
            (true, _) => PALETTE[7],
            (false, true) => PALETTE[0],
            (false, false) => PALETTE[1],
        }
    }

    /// The energy with three digits; a flow with its sign.
    fn value(&self) -> String {
        let size = self.energy.abs();
        let decimals = if size > 0.0 {
            (2 - size.log10().floor() as i32).clamp(0, 3) as usize
        } else {
            0
        };
        minus(if self.stored {
            format!("{size:.decimals$}")
        } else {
            format!("{:+.decimals$}", self.energy)
        })
    }
}

/// With the sign that is as wide as a plus.
fn minus(text: String) -> String {
    text.replace('-', "\u{2212}")
}
