//! Crossings of the trajectory through the levels that define the events t0..t18.

use super::state::*;
use super::system::System;
use crate::Events;

/// Piston travel of the position mark that t7 and t15 refer to, the thesis' sensor position \[m\].
const POSITION_MARK: f64 = 50.51e-3;
/// Valve lift at t1 \[m\].
const FIRST_LIFT: f64 = 10e-6;
/// Part of the supply's overpressure left above the valve at t2.
const CONTROL_LEVEL: f64 = 0.10;
/// Piston travel at t4 \[m\].
const FIRST_TRAVEL: f64 = 0.1e-3;
/// Speed below which the piston rests, t11 and t18 \[m/s\].
const REST_SPEED: f64 = 0.1;
/// Time it must rest \[s\].
const REST_TIME: f64 = 2e-3;
/// Speed up to which the return stroke has not begun, t14 \[m/s\].
const STILL_SPEED: f64 = 0.05;
/// P_1/P_a at the end of the exhaust, t17.
const BLOWN_RATIO: f64 = 1.02;
/// Earliest end of the exhaust after t13 \[s\].
const BLOW_TIME: f64 = 1e-3;

/// A level the trajectory may cross.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(usize)]
pub(crate) enum Mark {
    Lift,
    Control,
    IntakeLap,
    Travel,
    Nail,
    Wood,
    FullDepth,
    Position,
    CheckHoles,
    Arrest,
    Bumper,
    Rest,
    Still,
    Guard,
    Landing,
    ExhaustLap,
    Stopper,
    Blown,
    IntakeChoked,
    SeatChoked,
}

impl Mark {
    pub(crate) const COUNT: usize = 20;
    const ALL: [Self; Self::COUNT] = [
        Self::Lift,
        Self::Control,
        Self::IntakeLap,
        Self::Travel,
        Self::Nail,
        Self::Wood,
        Self::FullDepth,
        Self::Position,
        Self::CheckHoles,
        Self::Arrest,
        Self::Bumper,
        Self::Rest,
        Self::Still,
        Self::Guard,
        Self::Landing,
        Self::ExhaustLap,
        Self::Stopper,
        Self::Blown,
        Self::IntakeChoked,
        Self::SeatChoked,
    ];

    pub(crate) fn from_index(index: usize) -> Self {
        Self::ALL[index]
    }
}

/// Height of the trajectory above every level.
pub(crate) fn heights(system: &System, y: &State) -> [f64; Mark::COUNT] {
    let p = &system.p;
    let now = system.instant(y);
    let lift = p.head_valve.lift - now.valve;
    let (supply, ambient) = (p.supply.pressure, p.ambient.pressure);
    let z = system.depth(y);
    let gap = y[Y_G] - y[Y_W];
    let p1 = now.gas[ABOVE].pressure;
    [
        lift - FIRST_LIFT,
        now.gas[CONTROL].pressure - (ambient + CONTROL_LEVEL * (supply - ambient)),
        lift - p.head_valve.intake_lap,
        now.travel - FIRST_TRAVEL,
        now.travel - p.nail.head_gap,
        z,
        z - p.nail.length,
        now.travel - POSITION_MARK,
        now.travel - p.chambers.check_hole_position,
        y[V_P] - y[V_W],
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
    ]
}

/// One crossing.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Crossing {
    pub(crate) mark: Mark,
    pub(crate) time: f64,
    pub(crate) rising: bool,
    /// y_pr at the crossing.
    travel: f64,
    /// P_1 at the crossing.
    pressure: f64,
}

/// All crossings in order of time.
#[derive(Debug, Clone)]
pub(crate) struct Log {
    crossings: Vec<Crossing>,
    stroke: f64,
    ambient: f64,
    t13_blown: Option<bool>,
}

impl Log {
    pub(crate) fn new(system: &System) -> Self {
        Self {
            crossings: Vec::new(),
            stroke: system.p.piston.stroke,
            ambient: system.p.ambient.pressure,
            t13_blown: None,
        }
    }

    pub(crate) fn push(&mut self, system: &System, mark: Mark, time: f64, rising: bool, y: &State) {
        let now = system.instant(y);
        let pressure = now.gas[ABOVE].pressure;
        if mark == Mark::ExhaustLap && !rising {
            self.t13_blown = Some(pressure <= BLOWN_RATIO * self.ambient);
        }
        self.crossings.push(Crossing {
            mark,
            time,
            rising,
            travel: now.travel,
            pressure,
        });
    }

    /// Keeps the crossings of one step in order of time.
    pub(crate) fn sort_from(&mut self, first: usize) {
        self.crossings[first..].sort_by(|a, b| a.time.total_cmp(&b.time));
    }

    pub(crate) fn len(&self) -> usize {
        self.crossings.len()
    }

    /// First crossing of a level at or after `after`.
    pub(crate) fn first(&self, mark: Mark, rising: bool, after: f64) -> Option<f64> {
        self.find(mark, rising, after).map(|c| c.time)
    }

    fn find(&self, mark: Mark, rising: bool, after: f64) -> Option<&Crossing> {
        self.crossings
            .iter()
            .find(|c| c.mark == mark && c.rising == rising && c.time >= after)
    }

    /// First time after `after` from which |v_pr| stays below the speed of rest for the time of rest, known at `now`.
    pub(crate) fn rest(&self, after: f64, now: f64) -> Option<f64> {
        let mut slow = None;
        for c in self.crossings.iter().filter(|c| c.mark == Mark::Rest) {
            if c.time <= after {
                // Slow already at `after`: rest counts from there.
                slow = (!c.rising).then_some(after);
                continue;
            }
            if c.rising {
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
        let t6 = self.first(Mark::Wood, true, 0.0)?;
        let t15 = self.first(Mark::Position, false, t6)?;
        self.first(Mark::Stopper, false, t15)
    }

    /// Reads t0..t18 from the crossings; `end` is the last time integrated.
    pub(crate) fn events(&self, end: f64) -> Events {
        let up = |mark, after: Option<f64>| after.and_then(|t| self.first(mark, true, t));
        let down = |mark, after: Option<f64>| after.and_then(|t| self.first(mark, false, t));
        let t0 = Some(0.0);
        let t6 = up(Mark::Wood, t0);
        let t9_crossing = t6.and_then(|t| self.find(Mark::Arrest, false, t));
        let t9 = t9_crossing.map(|c| c.time);
        let t10 = t9_crossing.and_then(|c| {
            if c.travel >= self.stroke {
                Some(c.time)
            } else {
                up(Mark::Bumper, t9)
            }
        });
        let t12 = down(Mark::Guard, t0);
        let t13 = t12.and_then(|t| {
            let opens =
                |c: &&Crossing| c.mark == Mark::ExhaustLap && !c.rising && c.time >= t && c.pressure > self.ambient;
            self.crossings.iter().find(opens).map(|c| c.time)
        });
        let t15 = down(Mark::Position, t6);
        let t16 = down(Mark::Stopper, t15);
        let t14 = t15.and_then(|t15| {
            let last = |c: &&Crossing| c.mark == Mark::Still && c.rising && c.time < t15;
            self.crossings
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
            for c in self.crossings.iter().filter(|c| c.mark == Mark::Blown && c.time > t) {
                if c.time > earliest {
                    break;
                }
                low = !c.rising;
            }
            if low && earliest <= end {
                Some(earliest)
            } else {
                self.first(Mark::Blown, false, earliest)
            }
        });
        Events {
            t0,
            t1: up(Mark::Lift, t0),
            t2: down(Mark::Control, t0),
            t3: up(Mark::IntakeLap, t0),
            t4: up(Mark::Travel, t0),
            t5: up(Mark::Nail, t0),
            t6,
            t7: up(Mark::Position, t0),
            t8: up(Mark::CheckHoles, t0),
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

    /// Total time within `from..to` in which a level is exceeded, the height at t = 0 being `above` or not.
    pub(crate) fn time_above(&self, mark: Mark, above: bool, from: f64, to: f64) -> f64 {
        let mut above = above;
        let mut last = from;
        let mut total = 0.0;
        for c in self.crossings.iter().filter(|c| c.mark == mark) {
            let time = c.time.clamp(from, to);
            if above {
                total += time - last;
            }
            last = time;
            above = c.rising;
        }
        if above { total + (to - last) } else { total }
    }
}
