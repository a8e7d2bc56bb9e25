//! From a run to its record: events, outcome and figures.

use nailnoise_quantities::Check;

use super::integrate::Run;
use super::mode::Contact;
use super::state::*;
use super::switching::deepest;
use super::system::System;
use crate::{Crossing, CycleRecord, Events, Form, Outcome, Summary};

/// Assembles the record.
pub(crate) fn record(system: &System, run: Run) -> CycleRecord {
    let events = run.log.events(run.end);
    let summary = summarise(system, &run, &events);
    let outcome = outcome(system, &run, &events, &summary);
    let mut checks = run.balance.checks(system);
    if models_the_head(system) {
        let (depth, limit) = (summary.head_depth.max(0.0), system.p.nail.overdrive_limit);
        checks.push(Check::at_most("head of the nail below the surface [m]", depth, limit));
    }
    let energy = run.balance.energy(system, &run.last_mode, &run.last);
    let log = run.log.into_entries();
    let recorder = run.recorder;
    let [piston, head_valve, tool, workpiece] = recorder.bodies;
    let [above_piston, below_piston, return_volume, above_valve, supply] = recorder.volumes;
    CycleRecord {
        sample_interval: recorder.interval,
        piston,
        head_valve,
        tool,
        workpiece,
        motion: recorder.motion,
        above_piston,
        below_piston,
        return_volume,
        above_valve,
        supply,
        forces: recorder.forces,
        exhaust: recorder.exhaust,
        vent: recorder.vent,
        events,
        log,
        outcome,
        summary,
        energy,
        checks,
        work: run.work,
    }
}

/// Whether the model includes the depth of the head; in the published form, the nail ends with its first reversal.
fn models_the_head(system: &System) -> bool {
    system.p.model.nail == Form::Corrected
}

fn is_overdriven(system: &System, summary: &Summary) -> bool {
    models_the_head(system) && summary.head_depth > system.p.nail.overdrive_limit
}

fn outcome(system: &System, run: &Run, events: &Events, summary: &Summary) -> Outcome {
    let bumper = run.log.first(Crossing::PistonAtBumper, true, 0.0);
    if events.t3.is_none() {
        Outcome::DoesNotOpen
    } else if is_overdriven(system, summary) {
        Outcome::Overdriven
    } else if bumper.is_some_and(|bumper| events.t9.is_none_or(|t9| bumper < t9)) {
        Outcome::StrikesBumper
    } else if summary.penetration < system.p.nail.length {
        Outcome::Underdriven
    } else if events.t12.is_none() {
        Outcome::DoesNotRelease
    } else if events.t13.is_none() {
        Outcome::DoesNotExhaust
    } else {
        Outcome::Drives
    }
}

fn summarise(system: &System, run: &Run, events: &Events) -> Summary {
    let penetration = deepest(system, &run.last_mode, &run.last);
    let y = &run.last;
    let full = run.log.first(Crossing::FullDepth, true, 0.0);
    let drive = |(start, end): (f64, f64)| system.p.nail.length / (end - start);
    let opened = events.t3;
    // The intake is open from t3 until it closes again or the record ends.
    let intake = opened.map(|t3| (t3, run.log.first(Crossing::Intake, false, t3).unwrap_or(run.end)));
    let blow = events.t13.zip(events.t17);
    let share = |(from, to): (f64, f64), time: f64| time / (to - from);
    let holes = |(from, to): (f64, f64)| {
        let samples = &run.recorder.exhaust.choked;
        let first = (from / run.recorder.interval).ceil() as usize;
        let last = ((to / run.recorder.interval).floor() as usize).min(samples.len().saturating_sub(1));
        let choked = samples
            .get(first..=last)
            .map_or(0, |window| window.iter().filter(|c| **c).count());
        share((from, to), choked as f64 * run.recorder.interval)
    };
    Summary {
        speed_before_impact: run.impact.map(|(before, _)| before),
        speed_after_impact: run.impact.map(|(_, after)| after),
        mean_drive_speed: events.t6.zip(full).map(drive),
        full_penetration: full,
        penetration,
        head_depth: penetration - system.p.nail.length,
        exhaust_mass: y[EXHAUST_MASS],
        vent_mass: y[VENT_MASS],
        leak_mass: y[LEAK_MASS],
        supply_mass: y[SUPPLY_MASS],
        // P_1 starts below the choking level of the supply, and P_a/P_1 above the critical ratio.
        intake_choked_fraction: intake.map(|(from, to)| {
            share(
                (from, to),
                (to - from) - run.log.time_above(Crossing::IntakeUnchoked, false, from, to),
            )
        }),
        exhaust_chamber_choked_fraction: blow
            .map(|(from, to)| share((from, to), run.log.time_above(Crossing::ChamberChoked, false, from, to))),
        exhaust_choked_fraction: blow.map(holes),
        cap_contacts: run.closings[Contact::Cap as usize],
        seat_contacts: run.closings[Contact::Seat as usize],
        ..run.recorder.peaks()
    }
}
