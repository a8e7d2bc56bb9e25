//! The log of a run: crossings of the levels that define events, and changes of the mode.

use super::mode::Mode;
use super::state::*;
use super::system::System;
use crate::{Crossing, Direction, Events, LogEntry, LogState};

// Thresholds of the events. Unless a source is given, they are chosen: small compared with the stroke and the lift, and
// large compared with the integration tolerance. They determine where one interval between events ends and the next
// begins, but affect neither the motion nor a source's level over the complete shot.

/// Piston travel of the position mark used by t7 and t15 \[m\]: the position of the sensor in the thesis (1.4.2.1).
const POSITION_MARK: f64 = 50.51e-3;
/// Valve lift at t1 \[m\].
const FIRST_LIFT: f64 = 10e-6;
/// Fraction of the supply's gauge pressure left above the valve at t2.
const CONTROL_LEVEL: f64 = 0.10;
/// Piston travel at t4 \[m\].
const FIRST_TRAVEL: f64 = 0.1e-3;
/// Speed below which the piston counts as at rest, t11 and t18 \[m/s\].
const REST_SPEED: f64 = 0.1;
/// Minimum duration of rest \[s\].
const REST_TIME: f64 = 2e-3;
/// Speed below which the return stroke has not begun, t14 \[m/s\].
const STILL_SPEED: f64 = 0.05;
/// P_1/P_a at the end of the exhaust, t17.
const BLOWN_RATIO: f64 = 1.02;
/// Earliest end of the exhaust after t13 \[s\].
const BLOW_TIME: f64 = 1e-3;

/// Smallest speed of a body for a genuine reversal; slower reversals are the settling of a contact \[m/s\].
const REVERSAL_SPEED: f64 = 10e-3;

/// Number of levels that are watched.
pub(crate) const LEVELS: usize = 24;

/// The levels, in the order of `heights`.
const ORDER: [Crossing; LEVELS] = [
    Crossing::FirstLift,
    Crossing::ControlPressure,
    Crossing::Intake,
    Crossing::FirstTravel,
    Crossing::RodAtNail,
    Crossing::TipInWood,
    Crossing::FullDepth,
    Crossing::PositionMark,
    Crossing::CheckHoles,
    Crossing::Advance,
    Crossing::PistonAtBumper,
    Crossing::RestSpeed,
    Crossing::StillSpeed,
    Crossing::Guard,
    Crossing::Landing,
    Crossing::ExhaustShut,
    Crossing::PistonOffStopper,
    Crossing::ChamberPressure,
    Crossing::IntakeUnchoked,
    Crossing::ChamberChoked,
    Crossing::HolesChoked,
    Crossing::PistonReversal,
    Crossing::ValveReversal,
    Crossing::ToolReversal,
];
/// Number of reversals, which come last.
const REVERSALS: usize = 3;
const FIRST_REVERSAL: usize = LEVELS - REVERSALS;

/// Height of the trajectory above each level.
pub(crate) fn heights(system: &System, mode: &Mode, y: &State) -> [f64; LEVELS] {
    let p = &system.p;
    let now = system.instant(y);
    let lift = p.head_valve.lift - now.valve;
    let (supply, ambient) = (p.supply.pressure, p.ambient.pressure);
    let z = system.depth(mode, y);
    let gap = y[Y_G] - mode.seat_motion(y).0;
    let p1 = now.gas[ABOVE].pressure;
    [
        lift - FIRST_LIFT,
        now.gas[CONTROL].pressure - (ambient + CONTROL_LEVEL * (supply - ambient)),
        lift - p.head_valve.intake_lap,
        now.travel - FIRST_TRAVEL,
        now.travel - system.geometry.head_gap,
        z,
        z - p.nail.length,
        now.travel - POSITION_MARK,
        now.travel - p.chambers.check_hole_position,
        y[V_P] - mode.nail_motion(y).1,
        now.travel - p.piston.stroke,
        now.travel_rate.abs() - REST_SPEED,
        now.travel_rate.abs() - STILL_SPEED,
        gap + p.contacts.guard_travel,
        gap,
        lift - p.head_valve.exhaust_lap,
        now.travel,
        p1 - BLOWN_RATIO * ambient,
        p1 - system.air.critical * now.gas[SUPPLY].pressure,
        system.air.critical * p1 - ambient,
        system.hole_choking(&now),
        now.travel_rate,
        now.valve_rate,
        y[V_G],
    ]
}

/// All entries in chronological order.
#[derive(Debug, Clone)]
pub(crate) struct Log {
    entries: Vec<LogEntry>,
    stroke: f64,
    ambient: f64,
    /// Time at which the operator releases the trigger valve; 0 if only the rising tool does \[s\].
    release_after: f64,
    t13_blown: Option<bool>,
    /// For each body whose reversals are recorded, the largest speed since its last reversal.
    swing: [f64; REVERSALS],
    /// For each of them, the last reversal after slow motion, which counts if fast motion follows.
    slow: [Option<LogEntry>; REVERSALS],
}

impl Log {
    pub(crate) fn new(system: &System) -> Self {
        Self {
            entries: Vec::with_capacity(512),
            stroke: system.p.piston.stroke,
            ambient: system.p.ambient.pressure,
            release_after: system.p.trigger.release_after,
            t13_blown: None,
            swing: [0.0; REVERSALS],
            slow: [None; REVERSALS],
        }
    }

    /// Records the crossing of a level; a reversal counts only if the motion is fast before or after it.
    pub(crate) fn level(&mut self, (system, mode): (&System, &Mode), level: usize, time: f64, rising: bool, y: &State) {
        let entry = Self::entry((system, mode), ORDER[level], time, rising, y);
        let Some(body) = level.checked_sub(FIRST_REVERSAL) else {
            self.add(entry);
            return;
        };
        let slow = std::mem::replace(&mut self.swing[body], 0.0) < REVERSAL_SPEED;
        match (slow, self.slow[body].take()) {
            // Two successive slow reversals do not count.
            (true, Some(_)) => {}
            (true, None) => self.slow[body] = Some(entry),
            (false, earlier) => {
                if let Some(earlier) = earlier {
                    let place = self.entries.partition_point(|e| e.time <= earlier.time);
                    self.entries.insert(place, earlier);
                }
                self.add(entry);
            }
        }
    }

    /// Tracks the speeds of the bodies whose reversals are recorded.
    pub(crate) fn follow(&mut self, heights: &[f64; LEVELS]) {
        for (swing, speed) in self.swing.iter_mut().zip(&heights[FIRST_REVERSAL..]) {
            *swing = swing.max(speed.abs());
        }
    }

    /// Records events other than level crossings.
    pub(crate) fn push(&mut self, place: (&System, &Mode), crossing: Crossing, time: f64, rising: bool, y: &State) {
        self.add(Self::entry(place, crossing, time, rising, y));
    }

    fn add(&mut self, entry: LogEntry) {
        if entry.crossing == Crossing::ExhaustShut && !entry.is_rising() {
            self.t13_blown = Some(entry.state.pressures[ABOVE] <= BLOWN_RATIO * self.ambient);
        }
        self.entries.push(entry);
    }

    fn entry((system, mode): (&System, &Mode), crossing: Crossing, time: f64, rising: bool, y: &State) -> LogEntry {
        let now = system.instant(y);
        LogEntry {
            time,
            crossing,
            direction: Direction::new(rising),
            state: LogState {
                piston_travel: now.travel,
                piston_velocity: now.travel_rate,
                valve_lift: system.p.head_valve.lift - now.valve,
                valve_velocity: -now.valve_rate,
                tool_rise: mode.seat_motion(y).0 - y[Y_G],
                tool_velocity: y[V_G],
                tip_depth: system.depth(mode, y),
                pressures: now.gas.map(|gas| gas.pressure),
            },
        }
    }

    pub(crate) fn into_entries(self) -> Vec<LogEntry> {
        self.entries
    }

    /// Orders the entries of one step by time.
    pub(crate) fn sort_from(&mut self, first: usize) {
        self.entries[first..].sort_by(|a, b| a.time.total_cmp(&b.time));
    }

    pub(crate) fn len(&self) -> usize {
        self.entries.len()
    }

    /// First crossing of a level at or after `after`.
    pub(crate) fn first(&self, crossing: Crossing, rising: bool, after: f64) -> Option<f64> {
        self.find(crossing, rising, after).map(|c| c.time)
    }

    fn find(&self, crossing: Crossing, rising: bool, after: f64) -> Option<&LogEntry> {
        self.entries
            .iter()
            .find(|c| c.crossing == crossing && c.is_rising() == rising && c.time >= after)
    }

    /// First time after `after` from which |v_pr| stays below the rest speed for the rest time, as far as known at
    /// `now`.
    pub(crate) fn rest(&self, after: f64, now: f64) -> Option<f64> {
        let mut slow = None;
        for c in self.entries.iter().filter(|c| c.crossing == Crossing::RestSpeed) {
            if c.time <= after {
                // Already slow at `after`: rest is counted from there.
                slow = (!c.is_rising()).then_some(after);
                continue;
            }
            if c.is_rising() {
                if let Some(since) = slow
                    && c.time - since >= REST_TIME
                {
                    return Some(since);
                }
                slow = None;
            } else {
                slow = Some(c.time);
            }
        }
        slow.filter(|since| now - since >= REST_TIME)
    }

    /// t16, the return of the piston to the stopper.
    pub(crate) fn back_home(&self) -> Option<f64> {
        let t6 = self.first(Crossing::TipInWood, true, 0.0)?;
        let t15 = self.first(Crossing::PositionMark, false, t6)?;
        self.first(Crossing::PistonOffStopper, false, t15)
    }

    /// Determines t0..t18 from the crossings; `end` is the last time integrated.
    pub(crate) fn events(&self, end: f64) -> Events {
        let up = |crossing, after: Option<f64>| after.and_then(|t| self.first(crossing, true, t));
        let down = |crossing, after: Option<f64>| after.and_then(|t| self.first(crossing, false, t));
        let t0 = self.first(Crossing::Trigger, true, 0.0);
        let t6 = up(Crossing::TipInWood, t0);
        let t9_crossing = t6.and_then(|t| self.find(Crossing::Advance, false, t));
        let t9 = t9_crossing.map(|c| c.time);
        let t10 = t9_crossing.and_then(|c| {
            if c.state.piston_travel >= self.stroke {
                Some(c.time)
            } else {
                up(Crossing::PistonAtBumper, t9)
            }
        });
        let by_guard = down(Crossing::Guard, t0);
        let by_hand = Some(self.release_after).filter(|release| *release > 0.0 && *release <= end);
        let t12 = match (by_guard, by_hand) {
            (Some(guard), Some(hand)) => Some(guard.min(hand)),
            (guard, hand) => guard.or(hand),
        };
        let t13 = t12.and_then(|t| {
            let opens = |c: &&LogEntry| {
                c.crossing == Crossing::ExhaustShut
                    && !c.is_rising()
                    && c.time >= t
                    && c.state.pressures[ABOVE] > self.ambient
            };
            self.entries.iter().find(opens).map(|c| c.time)
        });
        let t15 = down(Crossing::PositionMark, t6);
        let t16 = down(Crossing::PistonOffStopper, t15);
        let t14 = t15.and_then(|t15| {
            let last = |c: &&LogEntry| c.crossing == Crossing::StillSpeed && c.is_rising() && c.time < t15;
            self.entries
                .iter()
                .rev()
                .find(last)
                .map(|c| c.time)
                .filter(|t| t6.is_some_and(|t6| *t > t6))
        });
        let t11 = t10
            .and_then(|t| self.rest(t, t14.unwrap_or(end).min(end)))
            .filter(|t| t14.is_none_or(|t14| *t < t14));
        let t17 = t13.and_then(|t| {
            let earliest = t + BLOW_TIME;
            let mut low = self.t13_blown.unwrap_or(false);
            for c in self
                .entries
                .iter()
                .filter(|c| c.crossing == Crossing::ChamberPressure && c.time > t)
            {
                if c.time > earliest {
                    break;
                }
                low = !c.is_rising();
            }
            if low && earliest <= end {
                Some(earliest)
            } else {
                self.first(Crossing::ChamberPressure, false, earliest)
            }
        });
        Events {
            t0,
            t1: up(Crossing::FirstLift, t0),
            t2: down(Crossing::ControlPressure, t0),
            t3: up(Crossing::Intake, t0),
            t4: up(Crossing::FirstTravel, t0),
            t5: up(Crossing::RodAtNail, t0),
            t6,
            t7: up(Crossing::PositionMark, t0),
            t8: up(Crossing::CheckHoles, t0),
            t9,
            t10,
            t11,
            t12,
            t13,
            t14,
            t15,
            t16,
            t17,
            t18: t16.and_then(|t| self.rest(t, end)),
        }
    }

    /// Total time above a level within `from..to`; `above` states whether the height at t = 0 is above it.
    pub(crate) fn time_above(&self, crossing: Crossing, above: bool, from: f64, to: f64) -> f64 {
        let mut above = above;
        let mut last = from;
        let mut total = 0.0;
        for c in self.entries.iter().filter(|c| c.crossing == crossing) {
            let time = c.time.clamp(from, to);
            if above {
                total += time - last;
            }
            last = time;
            above = c.is_rising();
        }
        if above { total + (to - last) } else { total }
    }
}
