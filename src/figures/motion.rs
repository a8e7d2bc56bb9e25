//! Motion of piston, nail, tool and head valve.

use super::sheet::{Level, Panel};
use super::{Figure, Shot, scale};

pub(super) fn figure(shot: &Shot<'_>) -> Figure {
    let (r, d) = (shot.record, shot.design);
    let mm = |values: &[f64]| values.iter().map(|y| 1e3 * y).collect::<Vec<_>>().into_iter();
    let level = |label: &str, value: f64, above| Level {
        label: label.to_owned(),
        value,
        above,
    };

    let rise = r
        .workpiece
        .position
        .iter()
        .zip(&r.tool.position)
        .map(|(w, g)| 1e3 * (w - g));
    let travel = vec![
        shot.curve("piston, from the stopper", 0, mm(&r.motion.piston_travel)),
        shot.curve("nail, depth in the wood", 1, mm(&r.motion.nail_depth)),
        shot.curve("tool, above the wood", 2, rise),
    ];
    let stroke = 1e3 * d.piston.stroke;
    let reach = travel
        .iter()
        .flat_map(|curve| curve.y.iter().copied())
        .chain([1.06 * stroke]);
    let positions = Panel {
        y_label: "Travel (mm)",
        y_range: scale::range(reach),
        height: 58,
        curves: travel,
        levels: vec![level("bumper", stroke, true)],
        spans: Vec::new(),
    };

    let velocity = |body: &nailnoise_dynamics::Body| {
        let relative = body.velocity.iter().zip(&r.tool.velocity).map(|(v, g)| v - g);
        relative.collect::<Vec<_>>().into_iter()
    };
    let speeds = vec![shot.curve("piston, in the tool, down", 0, velocity(&r.piston))];
    let speed = Panel {
        y_label: "Velocity (m/s)",
        y_range: scale::range(speeds.iter().flat_map(|curve| curve.y.iter().copied())),
        height: 36,
        curves: speeds,
        levels: Vec::new(),
        spans: Vec::new(),
    };

    let lifts = vec![shot.curve("head valve, lift from its seat", 3, mm(&r.motion.valve_lift))];
    let lift = Panel {
        y_label: "Lift (mm)",
        y_range: scale::range(lifts.iter().flat_map(|curve| curve.y.iter().copied())),
        height: 36,
        curves: lifts,
        levels: vec![
            level("intake opens", 1e3 * d.head_valve.intake_lap, true),
            level("exhaust shuts", 1e3 * d.head_valve.exhaust_lap, false),
        ],
        spans: Vec::new(),
    };
    Figure {
        name: "motion",
        svg: shot.sheet("Motion", vec![positions, speed, lift]).svg(),
    }
}
