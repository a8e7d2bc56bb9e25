//! Charts of a nailing cycle: pressures, motion, pressure ratios, forces and flow.

use nailnoise_dynamics::network::Record;

use super::chart::{Axis, Chart, Panel, Series, Shape, events};
use crate::design::Values;
use crate::stages::cycle::NailerShot;

/// The charts of a nailing cycle, [`energy`](super::energy) last. `subject` names the design.
pub fn cycle(subject: &str, design: &Values, shot: NailerShot<'_>) -> Vec<Chart> {
    let r = shot.record;
    let of = |name: &str| r.history(name);
    let time: Vec<f64> = (0..r.len()).map(|index| 1e3 * r.time(index)).collect();
    let line = |name: &str, colour, y: Vec<f64>| Series::line(name, colour, &time, &y);
    let scaled = |values: &[f64], factor: f64| values.iter().map(|value| factor * value).collect::<Vec<_>>();
    // One trajectory or force plus `sign` times another, in the unit of the axis.
    let sum = |a: &[f64], sign: f64, b: &[f64], factor: f64| {
        let both = a.iter().zip(b);
        both.map(|(a, b)| factor * (a + sign * b)).collect::<Vec<_>>()
    };
    let axis = || time_axis(r);
    let panel = |label: &str, unit, height, series: Vec<Series>| Panel {
        x: axis(),
        y: Axis::around(label, unit, &series),
        height,
        series,
    };
    let ruled = |label: &str, unit, height, mut series: Vec<Series>, rules: &[(String, f64)]| {
        series.extend(rules.iter().map(|(name, value)| Series::rule(name, &axis(), *value)));
        panel(label, unit, height, series)
    };
    let chart = |name: &str, title, caption: &str, panels| Chart {
        name: name.to_owned(),
        title,
        subject: subject.to_owned(),
        caption: caption.to_owned(),
        panels,
        events: events(&r.events),
    };

    let ambient = 1e-3 * design.ambient.pressure;
    let pressures = vec![
        line("above piston", 0, scaled(of("above_piston.pressure"), 1e-3)),
        line("below piston", 1, scaled(of("below_piston.pressure"), 1e-3)),
        line("return volume", 2, scaled(of("return_volume.pressure"), 1e-3)),
        line("above head valve", 3, scaled(of("above_valve.pressure"), 1e-3)),
        line("supply side", 4, scaled(of("supply.pressure"), 1e-3)),
    ];
    let travel = vec![
        line("piston, from the stopper", 0, scaled(of("piston.travel"), 1e3)),
        line("nail, depth in the wood", 1, scaled(of("nail.deepest"), 1e3)),
        line(
            "tool, above the wood",
            2,
            sum(of("workpiece.position"), -1.0, of("tool.position"), 1e3),
        ),
    ];
    let speed = vec![
        line(
            "piston, in the tool, down",
            0,
            sum(of("piston.velocity"), -1.0, of("tool.velocity"), 1.0),
        ),
        line("tool, up", 2, scaled(of("tool.velocity"), -1.0)),
    ];
    let lift = vec![line("head valve, lift from its seat", 3, scaled(of("valve_lift"), 1e3))];
    let mm = |name: &str, value: f64| (format!("{name} {:.1} mm", 1e3 * value), 1e3 * value);
    let valve = [
        mm("intake opens at", design.head_valve.intake_lap),
        mm("exhaust closes at", design.head_valve.exhaust_lap),
    ];
    let on_valve = vec![line(
        "head valve on cap (up) and seat",
        3,
        sum(of("cap.force"), 1.0, of("seat.force"), 1e-3),
    )];
    let on_body = vec![
        line("gas", 0, sum(of("piston_gas_force"), 1.0, of("valve_gas_force"), -1e-3)),
        line(
            "piston on bumper and stopper",
            1,
            sum(of("bumper.force"), 1.0, of("stopper.force"), 1e-3),
        ),
        line(
            "wood on nose and guard",
            2,
            sum(of("nose.force"), 1.0, of("guard.force"), -1e-3),
        ),
        line("hand", 6, scaled(of("hand.force"), 1e-3)),
    ];
    let on_workpiece = vec![
        line("nail", 1, scaled(of("nail.force"), 1e-3)),
        line("support", 0, scaled(of("support.force"), -1e-3)),
        line("nose and guard", 2, sum(of("nose.force"), 1.0, of("guard.force"), 1e-3)),
    ];
    let flow = vec![
        line("exhaust", 1, scaled(of("exhaust.mass_flow"), 1e3)),
        line("intake", 0, scaled(of("intake.mass_flow"), 1e3)),
        line("trigger vent", 3, scaled(of("vent.mass_flow"), 1e3)),
    ];

    // The thesis assesses the exhaust by the chamber, P_a/P_1, but sound originates at the holes, which have P_a/P_m. A
    // ratio is drawn while its passage is open.
    let critical = design.ambient.critical_ratio();
    let [above, supply, motion] = ["above_piston.pressure", "supply.pressure", "valve_lift"].map(of);
    let [before, behind] = ["exhaust_plenum_pressure", "exhaust_back_pressure"].map(of);
    let ratio = |open: &dyn Fn(f64) -> bool, ratio: &dyn Fn(usize) -> f64| {
        let at = |index| if open(motion[index]) { ratio(index) } else { f64::NAN };
        (0..r.len()).map(at).collect::<Vec<f64>>()
    };
    let (intake_open, exhaust_open) = (
        |lift| lift > design.head_valve.intake_lap,
        |lift| lift < design.head_valve.exhaust_lap,
    );
    let intake = ratio(&intake_open, &|i| above[i] / supply[i]);
    let chamber = ratio(&exhaust_open, &|i| design.ambient.pressure / above[i]);
    let holes = ratio(&exhaust_open, &|i| behind[i] / before[i]);
    let choked = |name: &str, colour: usize, ratios: &[f64]| {
        let at = |ratio: &f64| {
            if *ratio < critical {
                0.03 + 0.05 * colour as f64
            } else {
                f64::NAN
            }
        };
        Series {
            shape: Shape::Broad,
            ..line(name, colour, ratios.iter().map(at).collect())
        }
    };
    let rule = [(format!("critical ratio {critical:.3}"), critical)];
    let into = vec![
        choked("choked", 0, &intake),
        line("intake: P above piston / P supply side", 0, intake),
    ];
    let out = vec![
        choked("choked at the chamber", 0, &chamber),
        choked("choked at the holes", 1, &holes),
        line("chamber: P ambient / P above piston", 0, chamber),
        line("holes: P behind / P before the holes", 1, holes),
    ];

    vec![
        chart(
            "pressures",
            "Pressures",
            "Absolute pressures of the five gas volumes.",
            vec![ruled(
                "Absolute pressure",
                "kPa",
                88,
                pressures,
                &[(format!("ambient {ambient:.0} kPa"), ambient)],
            )],
        ),
        chart(
            "motion",
            "Motion",
            "Travel of the piston in the tool, depth of the nail, rise of the tool above the wood; velocities of \
             piston and \
             tool; lift of the head valve.",
            vec![
                ruled("Travel", "mm", 58, travel, &[mm("bumper at", design.piston.stroke)]),
                panel("Velocity", "m/s", 36, speed),
                ruled("Lift", "mm", 36, lift, &valve),
            ],
        ),
        chart(
            "ratios",
            "Pressure ratios",
            "Pressure ratios across intake and exhaust while they are open. The flow is choked below the critical \
             ratio.",
            vec![
                ruled("Intake ratio", "", 42, into, &rule),
                ruled("Exhaust ratio", "", 42, out, &rule),
            ],
        ),
        chart(
            "forces",
            "Forces, positive down",
            "Forces on the tool body and on the workpiece, down positive.",
            vec![
                panel("On the body", "kN", 34, on_valve),
                panel("On the body", "kN", 44, on_body),
                panel("On the workpiece", "kN", 50, on_workpiece),
            ],
        ),
        chart(
            "flow",
            "Air flow",
            "Air that enters from the supply side and leaves through exhaust and trigger vent.",
            vec![panel("Mass flow", "g/s", 66, flow)],
        ),
        super::energy(subject, &design.ambient, shot.figures),
    ]
}

/// The time axis of all charts.
pub(super) fn time_axis(record: &Record) -> Axis {
    let last = record.len().checked_sub(1).map_or(1.0, |last| 1e3 * record.time(last));
    Axis::new("Time from the trigger", "ms", [0.0, last])
}
