//! Forces on tool body and workpiece; down is positive.

use super::sheet::{Curve, Panel};
use super::{Figure, Shot, scale};

pub(super) fn figure(shot: &Shot<'_>) -> Figure {
    let f = &shot.record.forces;
    let sum = |a: &[f64], b: &[f64], factor: f64| {
        a.iter()
            .zip(b)
            .map(|(a, b)| 1e-3 * factor * (a + b))
            .collect::<Vec<_>>()
            .into_iter()
    };
    let one = |values: &[f64], factor: f64| values.iter().map(|f| 1e-3 * factor * f).collect::<Vec<_>>().into_iter();
    let valve = vec![shot.curve("head valve on cap (up) and seat", 3, sum(&f.cap, &f.seat, 1.0))];
    let body = vec![
        shot.curve("gas", 0, sum(&f.piston_gas, &f.valve_gas, -1.0)),
        shot.curve("piston on bumper and stopper", 1, sum(&f.bumper, &f.stopper, 1.0)),
        shot.curve("wood on nose and guard", 2, sum(&f.nose, &f.guard, -1.0)),
        shot.curve("hand", 6, one(&f.hand, 1.0)),
    ];
    let workpiece = vec![
        shot.curve("nail", 1, one(&f.penetration, 1.0)),
        shot.curve("support", 0, one(&f.support, -1.0)),
        shot.curve("nose and guard", 2, sum(&f.nose, &f.guard, 1.0)),
    ];
    let panels = vec![
        panel("On the body (kN)", 34, valve),
        panel("On the body (kN)", 44, body),
        panel("On the workpiece (kN)", 50, workpiece),
    ];
    Figure {
        name: "forces",
        svg: shot.sheet("Forces, positive down", panels).svg(),
    }
}

fn panel<'a>(y_label: &'static str, height: i32, curves: Vec<Curve<'a>>) -> Panel<'a> {
    let y_range = scale::range(curves.iter().flat_map(|curve| curve.y.iter().copied()));
    Panel {
        y_label,
        y_range,
        height,
        curves,
        levels: Vec::new(),
        spans: Vec::new(),
    }
}
