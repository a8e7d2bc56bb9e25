//! Pressure ratios across intake and exhaust, and where the flow is choked.
//!
//! The thesis judges the exhaust by the chamber, P_a/P_1; the holes, where the sound is made, see P_a/P_m.

use super::sheet::{Curve, Level, Panel, Span};
use super::{Figure, Shot};

pub(super) fn figure(shot: &Shot<'_>) -> Figure {
    let (r, d) = (shot.record, shot.design);
    let gamma = d.ambient.heat_capacity_ratio;
    let critical = (2.0 / (gamma + 1.0)).powf(gamma / (gamma - 1.0));
    let ambient = d.ambient.pressure;
    let above = &r.above_piston.pressure;
    let lift = &r.motion.valve_lift;

    // A ratio is drawn where its passage is open.
    let gap = |open: bool, ratio: f64| if open { ratio } else { f64::NAN };
    let intake = (0..r.len()).map(|i| gap(lift[i] > d.head_valve.intake_lap, above[i] / r.supply.pressure[i]));
    let open = |i: usize| lift[i] < d.head_valve.exhaust_lap;
    let chamber = (0..r.len()).map(|i| gap(open(i), ambient / above[i]));
    let holes = (0..r.len()).map(|i| gap(open(i), r.exhaust.back_pressure[i] / r.exhaust.plenum_pressure[i]));

    let into = vec![shot.curve("intake: P above the piston / P supply side", 0, intake)];
    let out = vec![
        shot.curve("exhaust, at the chamber: P ambient / P above the piston", 0, chamber),
        shot.curve("exhaust, at the holes: P behind / P before the holes", 1, holes),
    ];
    let panels = vec![panel(into, critical), panel(out, critical)];
    Figure {
        name: "ratios",
        svg: shot.sheet("Pressure ratios", panels).svg(),
    }
}

fn panel(curves: Vec<Curve<'_>>, critical: f64) -> Panel<'_> {
    let highest = curves
        .iter()
        .flat_map(|curve| &curve.y)
        .copied()
        .filter(|y| y.is_finite())
        .fold(1.0, f64::max);
    Panel {
        y_label: "Pressure ratio",
        y_range: [0.0, 1.08 * highest],
        height: 42,
        levels: vec![Level {
            label: format!("critical {critical:.3}; bars: choked"),
            value: critical,
            above: true,
        }],
        spans: curves
            .iter()
            .zip(0..)
            .flat_map(|(curve, row)| choked(curve, critical, row))
            .collect(),
        curves,
    }
}

/// Bars where a ratio is below the critical one.
fn choked(curve: &Curve<'_>, critical: f64, row: i32) -> Vec<Span> {
    let mut spans: Vec<Span> = Vec::new();
    let mut since = None;
    for (x, y) in curve.x.iter().zip(&curve.y) {
        match (since, *y < critical) {
            (None, true) => since = Some(*x),
            (Some(from), false) => {
                spans.push(Span {
                    x: [from, *x],
                    colour: curve.colour,
                    row,
                });
                since = None;
            }
            _ => {}
        }
    }
    if let (Some(from), Some(end)) = (since, curve.x.last()) {
        spans.push(Span {
            x: [from, *end],
            colour: curve.colour,
            row,
        });
    }
    spans
}
