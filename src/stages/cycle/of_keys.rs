//! The shot of the tool described by a design's keys.
//!
//! Gas pressures p are gauge pressures. A uniform pressure exerts no net force on the cycle's rod, piston and head
//! valve, because A_1 = A_2 + A_r and A_h1 = A_h2 + A_h3, so that the ambient pressure cancels. Along the axis,
//! downwards, the loads on the housing are
//!
//! ```text
//! roof within the valve   - p_1 A_i + F_st                                    A_i = pi/4 D_i^2
//! cap, above the valve    - p_h A_h1 + F_hc - F_s + F_fh + thrust
//! cylinder's rim          p_1 (A_i + A_h3 - A_1) + p_ext A_h2 + F_seat
//! floor of the cylinder   p_2 A_2 + F_b
//! cylinder's bore         F_fp, evenly
//! nose                    - F_n - F_e + F_mag
//! handle                  F_hm, evenly
//! ```
//!
//! and weight: their sum is the force on the tool in the cycle's equation of motion. Gas also presses on walls without
//! moving the tool. The pressures p_1 and p_2 act on the bore on both sides of the piston, and p_ext inside the handle.
//! Around the cylinder, p_ext acts above the check-ring holes (the jacket) and p_r below them. In the cap the plenum's
//! pressure acts.

use nailnoise_dynamics::network::{EventTime, FlowHistory, LoadHistory, PressureHistory};
use nailnoise_dynamics::{CycleRecord, Events, Form, Geometry, Parameters, Volume};

use super::shot::{BORE, EngineRecord, OnWorkpiece, RETURN_WALL, ShotRecord, SummaryFigures};

/// Name of the housing in [`LoadHistory::body`].
const TOOL: &str = "tool";

impl ShotRecord {
    /// The shot of a cycle with these parameters.
    pub fn of_keys(parameters: &Parameters, record: CycleRecord) -> Self {
        let f = &record.forces;
        let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + b).collect::<Vec<_>>();
        let uniform = |surface: &str, pressure: &[f64]| PressureHistory {
            body: TOOL.to_owned(),
            surface: surface.to_owned(),
            pressure: pressure.to_vec(),
            below: Vec::new(),
            divide: Vec::new(),
        };
        Self {
            sample_interval: record.sample_interval,
            samples: record.len(),
            ambient_pressure: parameters.ambient.pressure,
            outcome: record.outcome.name().to_owned(),
            events: event_times(&record.events),
            figures: SummaryFigures::Keys(Box::new(record.summary.clone())),
            openings: openings(parameters, &record),
            tool: Some(record.tool.clone()),
            loads: loads(parameters, &record),
            impulse_corrections: impulse_corrections(parameters, &record),
            pressures: vec![
                PressureHistory {
                    below: record.below_piston.pressure.clone(),
                    divide: record.motion.piston_travel.clone(),
                    ..uniform(BORE, &record.above_piston.pressure)
                },
                uniform("jacket", &record.supply.pressure),
                uniform(RETURN_WALL, &record.return_volume.pressure),
                uniform("plenum", &record.exhaust.plenum_pressure),
            ],
            workpiece: Some(OnWorkpiece {
                motion: record.workpiece.clone(),
                seat: sum(&f.nose, &f.guard),
                nose: f.nose.clone(),
                fastener: f.penetration.clone(),
                deepest: record.motion.nail_depth.clone(),
                fastener_speed: None,
            }),
            checks: record.checks.clone(),
            record: EngineRecord::Keys(Box::new(record)),
        }
    }
}

/// Description of each event, in the order t0..t18.
pub const EVENT_NAMES: [&str; 19] = [
    "trigger pulled",
    "head valve lifts",
    "volume above valve vented",
    "intake opens",
    "piston starts",
    "rod meets the nail",
    "nail meets the wood",
    "piston at 50.51 mm down",
    "check-ring holes uncovered",
    "piston stops relative to the workpiece",
    "piston on the bumper",
    "piston at rest on the bumper",
    "trigger valve released",
    "exhaust opens",
    "return stroke begins",
    "piston at 50.51 mm up",
    "piston on the stopper",
    "exhaust ended",
    "piston at rest on the stopper",
];

/// Times of the events t0 to t18 by name.
pub fn event_times(events: &Events) -> Vec<EventTime> {
    let times = events.to_array().into_iter().zip(EVENT_NAMES).enumerate();
    let named = times.map(|(number, (time, description))| EventTime {
        name: format!("t{number}"),
        description: description.to_owned(),
        time,
    });
    named.collect()
}

/// Exhaust holes, then the vent of the trigger valve.
fn openings(parameters: &Parameters, record: &CycleRecord) -> Vec<FlowHistory> {
    let (holes, vent) = (&record.exhaust, &record.vent);
    let ambient = vec![parameters.ambient.pressure; record.len()];
    vec![
        FlowHistory {
            name: "exhaust".to_owned(),
            mass_flow: holes.mass_flow.clone(),
            pressure: holes.plenum_pressure.clone(),
            back_pressure: holes.back_pressure.clone(),
            temperature: holes.stagnation_temperature.clone(),
            choked: holes.choked.clone(),
        },
        FlowHistory {
            name: "vent".to_owned(),
            mass_flow: vent.mass_flow.clone(),
            pressure: vent.pressure.clone(),
            back_pressure: ambient,
            temperature: vent.temperature.clone(),
            choked: Vec::new(),
        },
    ]
}

fn load(surface: &str, force: Vec<f64>) -> LoadHistory {
    LoadHistory {
        body: TOOL.to_owned(),
        surface: surface.to_owned(),
        force,
    }
}

fn loads(parameters: &Parameters, record: &CycleRecord) -> Vec<LoadHistory> {
    let (p, g) = (parameters, Geometry::new(parameters));
    let within = 0.25 * std::f64::consts::PI * p.head_valve.inner_diameter.powi(2);
    // As published, nothing acts on the valve's underside: the ambient pressure on it is not balanced.
    let underside = match p.model.valve_underside {
        Form::Corrected => g.valve_cylinder_area,
        Form::Published => 0.0,
    };
    let ambient = p.ambient.pressure;
    let unbalanced = ambient * (g.valve_control_area - g.valve_supply_area - underside);
    let f = &record.forces;
    let over = |volume: &Volume, n: usize| volume.pressure[n] - ambient;
    let history = |force: &dyn Fn(usize) -> f64| (0..record.len()).map(force).collect::<Vec<_>>();
    let above = |n| over(&record.above_piston, n);
    let (control, supply) = (|n| over(&record.above_valve, n), |n| over(&record.supply, n));
    vec![
        load("roof", history(&|n| f.stopper[n] - above(n) * within)),
        load(
            "cap",
            history(&|n| {
                f.cap[n] - f.spring[n] + f.valve_friction[n] + f.thrust[n]
                    - control(n) * g.valve_control_area
                    - unbalanced
            }),
        ),
        load(
            "rim",
            history(&|n| f.seat[n] + above(n) * (within + underside - g.piston_area) + supply(n) * g.valve_supply_area),
        ),
        load(
            "floor",
            history(&|n| f.bumper[n] + over(&record.below_piston, n) * g.ring_area),
        ),
        load(BORE, f.piston_friction.clone()),
        load("nose", history(&|n| f.magazine[n] - f.nose[n] - f.guard[n])),
        load("handle", f.hand.clone()),
    ]
}

/// The correction at the stop closer to the head valve.
fn impulse_corrections(parameters: &Parameters, record: &CycleRecord) -> Vec<LoadHistory> {
    let sampled: Vec<f64> = (0..record.len())
        .map(|n| record.forces.cap[n] + record.forces.seat[n])
        .collect();
    let correction = impulse_correction(
        parameters.head_valve.mass,
        &record.head_valve,
        &sampled,
        record.sample_interval,
    );
    let at = |cap: bool| {
        let lift = record.motion.valve_lift.iter();
        let here = lift.map(|lift| (*lift > 0.5 * parameters.head_valve.lift) == cap);
        here.zip(&correction)
            .map(|(here, force)| if here { *force } else { 0.0 })
            .collect()
    };
    vec![load("cap", at(true)), load("rim", at(false))]
}

/// Mean force of a body on its stiff stops around each sample, minus the `sampled` force, positive downwards \[N\].
///
/// The body may leave a stiff stop within less than a sampling interval. Between two samples at an interval h, its
/// momentum changes by M (v' - v). The mean of the smooth forces, gas, spring, friction and weight (M a + F), accounts
/// for part of the change; the rest is the impulse of the stops. Half of it is assigned to each of the two samples.
pub(super) fn impulse_correction(
    mass: f64,
    body: &nailnoise_dynamics::Body,
    sampled: &[f64],
    interval: f64,
) -> Vec<f64> {
    let smooth = |n: usize| mass * body.acceleration[n] + sampled[n];
    let mut forces: Vec<f64> = sampled.iter().map(|force| -force).collect();
    for n in 1..sampled.len() {
        let gained = mass * (body.velocity[n] - body.velocity[n - 1]) / interval;
        let force = 0.5 * (smooth(n - 1) + smooth(n)) - gained;
        forces[n - 1] += 0.5 * force;
        forces[n] += 0.5 * force;
    }
    // Half an interval is missing at each end, where the body is at rest.
    if let Some(last) = sampled.len().checked_sub(1) {
        for end in [0, last] {
            forces[end] += 0.5 * sampled[end];
        }
    }
    forces
}
