//! Charts of the nailing cycle with its events.

use nailnoise_dynamics::{CycleRecord, Events};
use serde_json::{Value, json};

use super::chart::{Chart, curve, ink};
use crate::output::EVENT_NAMES;

/// Rows over a chart on which the events' names take turns.
const ROWS: usize = 3;

/// Marks the events over a chart in time.
pub(super) fn event_marks(layout: &mut Value, events: &Events) {
    let mut times: Vec<(f64, usize)> = events
        .to_array()
        .iter()
        .enumerate()
        .filter_map(|(index, time)| Some((1e3 * (*time)?, index)))
        .collect();
    times.sort_by(|a, b| a.0.total_cmp(&b.0));
    let line = |(time, _): &(f64, usize)| {
        json!({
            "type": "line", "xref": "x", "yref": "paper", "x0": time, "x1": time, "y0": 0, "y1": 1,
            "line": { "color": "#b8b8b8", "width": 0.8 }, "layer": "below",
        })
    };
    let name = |(place, (time, index)): (usize, &(f64, usize))| {
        json!({
            "xref": "x", "yref": "paper", "x": time, "y": 1.0, "yshift": 2 + 11 * (place % ROWS) as i64,
            "yanchor": "bottom", "showarrow": false, "text": format!("t<sub>{index}</sub>"),
            "font": { "size": 11, "color": "#555" },
            "hovertext": format!("t{index}: {}, {time:.2} ms", EVENT_NAMES[*index]),
        })
    };
    layout["shapes"] = times.iter().map(line).collect();
    layout["annotations"] = times.iter().enumerate().map(name).collect();
    layout["margin"] = json!({ "t": 48 });
}

/// Pressures, motion, speeds, forces and flow of the shot.
pub(super) fn charts(record: &CycleRecord) -> Vec<Chart> {
    let time: Vec<f64> = (0..record.len()).map(|index| 1e3 * record.time(index)).collect();
    let scaled = |name: &str, colour: usize, values: &[f64], factor: f64| {
        let values: Vec<f64> = values.iter().map(|value| factor * value).collect();
        curve(name, ink(colour), &time, &values)
    };
    let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + b).collect::<Vec<f64>>();
    let relative = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<f64>>();
    let chart = |id: &str, caption: &str, y: &str, data: Vec<Value>| {
        let mut layout = json!({
            "xaxis": { "title": { "text": "Time from the trigger (ms)" } },
            "yaxis": { "title": { "text": y } },
        });
        event_marks(&mut layout, &record.events);
        Chart {
            id: id.to_owned(),
            caption: caption.to_owned(),
            data,
            layout,
            height: 340,
            group: "time",
        }
    };
    let (r, f) = (record, &record.forces);
    vec![
        chart(
            "pressures",
            "Absolute pressures of the five gas volumes.",
            "Pressure (kPa)",
            vec![
                scaled("above piston", 0, &r.above_piston.pressure, 1e-3),
                scaled("below piston", 1, &r.below_piston.pressure, 1e-3),
                scaled("return volume", 2, &r.return_volume.pressure, 1e-3),
                scaled("above head valve", 3, &r.above_valve.pressure, 1e-3),
                scaled("supply side", 4, &r.supply.pressure, 1e-3),
            ],
        ),
        chart(
            "travel",
            "Travel of the piston in the tool, depth of the nail, rise of the tool above the wood, lift of the head valve.",
            "Travel (mm)",
            vec![
                scaled("piston", 0, &r.motion.piston_travel, 1e3),
                scaled("nail in the wood", 1, &r.motion.nail_depth, 1e3),
                scaled(
                    "tool above the wood",
                    2,
                    &relative(&r.workpiece.position, &r.tool.position),
                    1e3,
                ),
                scaled("head valve", 3, &r.motion.valve_lift, 1e3),
            ],
        ),
        chart(
            "speed",
            "Velocity of the piston in the tool, down, and of the tool itself, up.",
            "Velocity (m/s)",
            vec![
                scaled("piston", 0, &relative(&r.piston.velocity, &r.tool.velocity), 1.0),
                scaled("tool", 2, &r.tool.velocity, -1.0),
            ],
        ),
        chart(
            "forces-body",
            "Forces on the tool body, down positive.",
            "Force (kN)",
            vec![
                scaled("gas", 0, &sum(&f.piston_gas, &f.valve_gas), -1e-3),
                scaled("piston on bumper and stopper", 1, &sum(&f.bumper, &f.stopper), 1e-3),
                scaled("head valve on cap and seat", 3, &sum(&f.cap, &f.seat), 1e-3),
                scaled("wood on nose and guard", 2, &sum(&f.nose, &f.guard), -1e-3),
                scaled("hand", 6, &f.hand, 1e-3),
            ],
        ),
        chart(
            "forces-workpiece",
            "Forces on the workpiece, down positive.",
            "Force (kN)",
            vec![
                scaled("nail", 1, &f.penetration, 1e-3),
                scaled("support", 0, &f.support, -1e-3),
                scaled("nose and guard", 2, &sum(&f.nose, &f.guard), 1e-3),
            ],
        ),
        chart(
            "flow",
            "Air that enters from the supply side and leaves through exhaust and trigger vent.",
            "Mass flow (g/s)",
            vec![
                scaled("exhaust", 1, &r.exhaust.mass_flow, 1e3),
                scaled("intake", 0, &r.exhaust.intake_mass_flow, 1e3),
                scaled("trigger vent", 3, &r.vent.mass_flow, 1e3),
            ],
        ),
    ]
}
