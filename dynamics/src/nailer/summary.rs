//! Events, outcome and figures of the shot.

use crate::network::Record;
use crate::{CycleError, Events, Outcome, Parameters, Summary};

/// Whether an event of the assembly is one of t0 to t18.
pub(super) fn is_event(name: &str) -> bool {
    name.strip_prefix('t')
        .is_some_and(|number| number.parse::<u8>().is_ok())
}

/// Times of t0 to t18.
pub(super) fn events(record: &Record) -> Events {
    let event = |name: &str| record.event(name);
    Events {
        t0: event("t0"),
        t1: event("t1"),
        t2: event("t2"),
        t3: event("t3"),
        t4: event("t4"),
        t5: event("t5"),
        t6: event("t6"),
        t7: event("t7"),
        t8: event("t8"),
        t9: event("t9"),
        t10: event("t10"),
        t11: event("t11"),
        t12: event("t12"),
        t13: event("t13"),
        t14: event("t14"),
        t15: event("t15"),
        t16: event("t16"),
        t17: event("t17"),
        t18: event("t18"),
    }
}

/// The outcome by its name in the assembly.
pub(super) fn outcome(record: &Record) -> Result<Outcome, CycleError> {
    let name = record.outcome.as_deref().unwrap_or_default();
    let found = Outcome::ALL.into_iter().find(|outcome| outcome.name() == name);
    found.ok_or_else(|| CycleError::Assembly {
        cause: format!("no outcome \"{name}\""),
    })
}

/// Figures of the shot with these events.
pub(super) fn summary(p: &Parameters, record: &Record, events: &Events) -> Summary {
    let penetration = record.history("nail.deepest").last().copied().unwrap_or(0.0);
    let full = record.event("full_depth");
    let strike = record.strikes.first();
    let peak = |block: &str| record.peak(block).unwrap_or(0.0);
    let closings = |block: &str| {
        record
            .log
            .iter()
            .filter(|entry| entry.block == block && entry.word == "closes")
            .count()
    };
    let mass = |name: &str| record.integral(name).unwrap_or(0.0);
    let critical = p.ambient.critical_ratio();
    let part = |window: Option<(f64, f64)>, height: &dyn Fn(usize) -> f64| {
        let interval = record.interval?;
        window.map(|(from, to)| part_above([from, to], interval, record.len(), height))
    };
    // The intake is open from t3 until it closes again or the record ends.
    let shut = |t3: f64| {
        let mut changes = record.condition_changes.iter();
        changes.find(|change| change.event == "t3" && !change.satisfied && change.time >= t3)
    };
    let intake = events
        .t3
        .map(|t3| (t3, shut(t3).map_or(record.end, |change| change.time)));
    let exhaust = events.t13.zip(events.t17);
    let pressure = |volume: &str| record.history(&format!("{volume}.pressure"));
    let [above, supply] = ["above_piston", "supply"].map(pressure);
    let holes = record.opening("exhaust");
    Summary {
        speed_before_impact: strike.map(|strike| strike.before),
        speed_after_impact: strike.map(|strike| strike.after),
        mean_drive_speed: events.t6.zip(full).map(|(start, end)| p.nail.length / (end - start)),
        full_penetration: full,
        penetration,
        head_depth: penetration - p.nail.length,
        peak_penetration_force: peak("nail"),
        peak_cap_force: peak("cap"),
        peak_seat_force: peak("seat"),
        peak_bumper_force: peak("bumper"),
        peak_stopper_force: peak("stopper"),
        peak_support_force: peak("support"),
        peak_nose_force: peak("nose"),
        exhaust_mass: mass("mass.exhaust"),
        vent_mass: mass("mass.vent"),
        leak_mass: mass("mass.leak"),
        supply_mass: mass("mass.refill"),
        intake_choked_fraction: part(intake, &|n| critical * supply[n] - above[n]),
        exhaust_chamber_choked_fraction: part(exhaust, &|n| critical * above[n] - p.ambient.pressure),
        exhaust_choked_fraction: holes
            .and_then(|holes| part(exhaust, &|n| critical * holes.pressure[n] - holes.back_pressure[n])),
        cap_contacts: closings("cap"),
        seat_contacts: closings("seat"),
    }
}

/// Fraction of a window during which a sampled height is positive, with linear interpolation between samples.
fn part_above([from, to]: [f64; 2], interval: f64, samples: usize, height: &dyn Fn(usize) -> f64) -> f64 {
    let first = (from / interval).floor() as usize;
    let last = ((to / interval).ceil() as usize).min(samples.saturating_sub(1));
    let mut above = 0.0;
    for n in first..last {
        let (start, end) = (n as f64 * interval, (n + 1) as f64 * interval);
        let (a, b) = (height(n), height(n + 1));
        // Fraction of the interval above zero.
        let zero = start + interval * a / (a - b);
        let [start, end] = match (a > 0.0, b > 0.0) {
            (true, true) => [start, end],
            (true, false) => [start, zero],
            (false, true) => [zero, end],
            (false, false) => continue,
        };
        above += (end.min(to) - start.max(from)).max(0.0);
    }
    above / (to - from)
}
