//! Segments between events, each of which is a smooth problem solved by diffsol.
//!
//! A step may extend beyond an event, because the right-hand side of a mode is smooth everywhere. The event is then
//! located on the solver's interpolant, the state is evaluated there, and the next segment starts in the new mode.
//! Events are located here instead of by the solver's root finder, because they have a direction, need arming after a
//! restart, and must also be found between the ends of steps.

use diffsol::{
    NalgebraVec, OdeBuilder, OdeSolverMethod, OdeSolverProblem, OdeSolverState, OdeSolverStopReason, Vector,
    matrix::dense_nalgebra_serial::NalgebraMat, ode_solver::state::StateCommon,
};

use super::balance::Balance;
use super::block_lu::BlockLu;
use super::equations::Equations;
use super::event_functions::{LEVELS, Log, heights};
use super::locate::locate;
use super::mode::{Channel, Contact, Mode};
use super::recorder::Recorder;
use super::start::start;
use super::state::*;
use super::switching::{SLOTS, cross, entry, event_tolerances, is_impact, margins, slot_name};
use super::system::System;
use super::tolerances::tolerances;
use crate::{Crossing, CycleError, Form, Method, Settings, WoodMotion, Work};

/// Number of points per step, including its end, at which conditions are checked.
const POINTS: usize = 2;
/// Number of changes of one condition within [`CHATTER_WINDOW`] that counts as chatter; a contact at 200 kHz makes 400.
const CHATTER_CHANGES: usize = 2000;
const CHATTER_WINDOW: f64 = 1e-3;
/// Part of a window that need not be integrated, because the remainder after an event may be too short for a step
/// \[s\].
const SHORTEST: f64 = 1e-12;
/// Number of steps after which a run is abandoned.
const STEP_LIMIT: usize = 500_000;
/// Fraction of V_02 left below the piston at which a dry fire is declared.
const DRY_FIRE: f64 = 1e-3;

pub(crate) type Problem<'s> = OdeSolverProblem<Equations<'s>>;

/// Everything that a run provides for the record.
pub(crate) struct Run {
    pub(crate) recorder: Recorder,
    pub(crate) log: Log,
    pub(crate) balance: Balance,
    pub(crate) work: Work,
    pub(crate) end: f64,
    pub(crate) last: State,
    pub(crate) last_mode: Mode,
    /// Piston speed before and after the rod hits the nail.
    pub(crate) impact: Option<(f64, f64)>,
    /// Number of contact closings, indexed by [`Contact`]; the initial contact of the seat is not counted.
    pub(crate) closings: [usize; Contact::COUNT],
    /// Whether the tool came back down onto the wood, which ends the record.
    pub(crate) landed: bool,
}

/// A cycle in progress.
pub(crate) struct Cycle<'s> {
    pub(crate) system: &'s System,
    settings: &'s Settings,
    pub(crate) mode: Mode,
    pub(crate) t: f64,
    pub(crate) y: State,
    /// End of the current window of a coupled run.
    pub(crate) window: Option<f64>,
    /// Whether the step is accepted or only a trial.
    pub(crate) recording: bool,
    /// Times at which the channel switches.
    venting: f64,
    filling: Option<f64>,
    /// Time at which the operator releases the trigger valve; none if only the rising tool does.
    release: Option<f64>,
    pub(crate) end: f64,
    /// t16, once it has occurred.
    home: Option<f64>,
    /// Number of log entries already processed.
    read: usize,
    heights: [f64; LEVELS],
    pub(crate) armed: [bool; SLOTS],
    event_tolerances: [f64; SLOTS],
    pub(crate) chatter: [(f64, usize); SLOTS],
    pub(crate) run: Run,
}

/// A step up to the first condition that becomes false.
struct Stretch {
    /// Times and states at which conditions are checked; the last one used is the end.
    points: [(f64, State); POINTS],
    used: usize,
    /// Time of the event that ends it, and the slot.
    event: Option<(f64, usize)>,
    /// Margins at its end; those at the end of the step if an event cut it back.
    margin: [f64; SLOTS],
}

/// Integrates a cycle.
pub(crate) fn integrate(system: &System, settings: &Settings) -> Result<Run, CycleError> {
    let mut cycle = Cycle::new(system, settings, None)?;
    let problem = cycle.problem()?;
    while cycle.t < cycle.end {
        cycle.segment(&problem)?;
    }
    Ok(cycle.finish(&problem))
}

impl<'s> Cycle<'s> {
    /// A cycle before the trigger pull, on its own lumped workpiece or on an external one at rest.
    pub(crate) fn new(
        system: &'s System,
        settings: &'s Settings,
        rest: Option<&WoodMotion>,
    ) -> Result<Self, CycleError> {
        let (y, mode) = start(system, rest)?;
        let release = Some(system.p.trigger.release_after).filter(|release| *release > 0.0);
        let mut cycle = Self {
            system,
            settings,
            mode,
            t: 0.0,
            y,
            window: None,
            recording: true,
            venting: system.geometry.channel_delay,
            filling: release.map(|release| release + system.geometry.channel_delay),
            release,
            end: settings.end,
            home: None,
            read: 0,
            heights: heights(system, &mode, &y),
            armed: margins(system, &mode, &y).map(|m| m > 0.0),
            event_tolerances: event_tolerances(system),
            chatter: [(0.0, 0); SLOTS],
            run: Run {
                recorder: Recorder::new(settings.sample_interval),
                log: Log::new(system),
                balance: Balance::new(system, &mode, &y),
                work: Work::default(),
                end: 0.0,
                last: y,
                last_mode: mode,
                impact: None,
                closings: [0; Contact::COUNT],
                landed: false,
            },
        };
        cycle.run.recorder.reserve(settings.end);
        cycle.run.log.push((system, &mode), Crossing::Trigger, 0.0, true, &y);
        Ok(cycle)
    }

    /// Ends the record.
    pub(crate) fn finish(mut self, problem: &Problem<'s>) -> Run {
        // If the end is on the grid, the last sample is exactly at the end.
        let (t, y, mode) = (self.t, self.y, self.mode);
        let recorder = &mut self.run.recorder;
        if !self.run.landed && recorder.next_time() <= t * (1.0 + 4.0 * f64::EPSILON) {
            recorder.push(self.system, &mode, &problem.eqn.past(t), &y);
        }
        let calls = problem.eqn.calls();
        self.run.work.evaluations = calls.rates;
        self.run.work.jacobians = calls.jacobians;
        self.run.end = t;
        self.run.last = y;
        self.run.last_mode = mode;
        self.run
    }

    pub(crate) fn problem(&self) -> Result<Problem<'s>, CycleError> {
        let mut problem = OdeBuilder::<NalgebraMat<f64>>::new()
            .rtol(0.0)
            .atol(tolerances(self.system, &self.mode, self.settings.relative_tolerance))
            .build_from_eqn(Equations::new(self.system, self.mode))
            .map_err(|cause| self.failure(&cause))?;
        // No limit, because failures are counted over a complete segment; STEP_LIMIT and the smallest step end a
        // hopeless run.
        problem.ode_options.max_nonlinear_solver_failures = usize::MAX;
        problem.ode_options.min_timestep = 1e-16;
        Ok(problem)
    }

    fn failure(&self, cause: &diffsol::DiffsolError) -> CycleError {
        CycleError::Integration {
            time: self.t,
            cause: cause.to_string(),
        }
    }

    /// Next time at which the smooth problem must end.
    fn stop_time(&self) -> f64 {
        let mut stop = self.window.unwrap_or(self.end);
        if self.mode.channel == Channel::Closed {
            stop = stop.min(self.venting);
        }
        if let Some(filling) = self.filling
            && self.mode.channel != Channel::Filling
        {
            stop = stop.min(filling);
        }
        if let Some(release) = self.release
            && !self.mode.released
        {
            stop = stop.min(release);
        }
        if self.system.p.model.delay == Form::Published {
            // No step may reach beyond the history, which ends one delay ahead.
            stop = stop.min(self.t + self.system.geometry.channel_delay);
        }
        stop
    }

    /// Whether the run, or its current window, is complete.
    pub(crate) fn is_through(&self) -> bool {
        match self.window {
            Some(end) => end - self.t <= SHORTEST,
            None => self.t >= self.end,
        }
    }

    /// Whether the operator releases the trigger now, or the channel switches.
    fn is_due(&self) -> bool {
        let reached = |due: f64| self.t >= due - 1e-13;
        if !self.mode.released && self.release.is_some_and(reached) {
            return true;
        }
        (self.mode.channel == Channel::Closed && reached(self.venting))
            || (self.mode.channel != Channel::Filling && self.filling.is_some_and(reached))
    }

    /// Releases the trigger and switches the channel if due.
    fn switch_channel(&mut self) {
        let before = self.mode.channel;
        let reached = |t: f64, due: f64| t >= due - 1e-13;
        if !self.mode.released && self.release.is_some_and(|due| reached(self.t, due)) {
            self.mode.released = true;
            if self.recording {
                self.run
                    .log
                    .push((self.system, &self.mode), Crossing::Trigger, self.t, false, &self.y);
            }
        }
        if self.filling.is_some_and(|due| reached(self.t, due)) {
            self.mode.channel = Channel::Filling;
        } else if self.mode.channel == Channel::Closed && reached(self.t, self.venting) {
            self.mode.channel = Channel::Venting;
        }
        let open = |channel| match channel {
            Channel::Closed => None,
            Channel::Venting => Some(Crossing::Vent),
            Channel::Filling => Some(Crossing::Fill),
        };
        if before != self.mode.channel && self.recording {
            for (crossing, rising) in [(open(before), false), (open(self.mode.channel), true)] {
                if let Some(crossing) = crossing {
                    self.run
                        .log
                        .push((self.system, &self.mode), crossing, self.t, rising, &self.y);
                }
            }
        }
    }

    /// Step size for a first-order start, from its error h^2 |y''|/3.
    fn first_step(&self, problem: &Problem<'s>, second: &State) -> f64 {
        if let Some(end) = self.window {
            // A window is short enough to be tried in one step by a method that needs no starting procedure.
            return end - self.t;
        }
        let atol = problem.atol.batch_as_slice(0);
        let sum: f64 = second.iter().zip(atol).map(|(d, atol)| (d / atol) * (d / atol)).sum();
        let norm = (sum / SIZE as f64).sqrt();
        (1.5 / norm).sqrt().clamp(1e-12, 1e-5)
    }

    pub(crate) fn segment(&mut self, problem: &Problem<'s>) -> Result<(), CycleError> {
        self.switch_channel();
        problem.eqn.set_mode(self.mode);
        if self.recording {
            problem.eqn.remember(self.t, &self.y);
        }
        let (first, second) = problem.eqn.derivatives(self.t, &self.y);
        let empty = || NalgebraVec::<f64>::zeros(0, Default::default());
        let common = StateCommon {
            y: NalgebraVec::from_vec(self.y.to_vec(), Default::default()),
            dy: NalgebraVec::from_vec(first.to_vec(), Default::default()),
            g: empty(),
            dg: empty(),
            s: empty(),
            ds: empty(),
            sg: empty(),
            dsg: empty(),
            t: self.t,
            h: self.first_step(problem, &second),
        };
        let method = if self.window.is_some() {
            Method::Esdirk34
        } else {
            self.settings.method
        };
        match method {
            Method::Bdf => {
                let solver = problem.bdf_solver::<BlockLu>(OdeSolverState::new_from_common(common));
                self.follow(solver.map_err(|cause| self.failure(&cause))?)
            }
            Method::Esdirk34 => {
                let solver = problem.esdirk34_solver::<BlockLu>(OdeSolverState::new_from_common(common));
                self.follow(solver.map_err(|cause| self.failure(&cause))?)
            }
        }
    }

    /// Integrates to the end of the segment.
    fn follow<'p, M>(&mut self, mut solver: M) -> Result<(), CycleError>
    where
        M: OdeSolverMethod<'p, Equations<'s>>,
        's: 'p,
    {
        let equations = &solver.problem().eqn;
        let mut stop = self.stop_time();
        solver.set_stop_time(stop).map_err(|cause| self.failure(&cause))?;
        let mut scratch = NalgebraVec::<f64>::zeros(SIZE, Default::default());
        let mut margin = margins(self.system, &self.mode, &self.y);
        loop {
            let reason = solver.step().map_err(|cause| self.failure(&cause))?;
            self.run.work.steps += 1;
            if self.run.work.steps > STEP_LIMIT {
                return Err(CycleError::Integration {
                    time: self.t,
                    cause: format!("{STEP_LIMIT} steps were not enough"),
                });
            }
            let (from, to) = (self.t, solver.state().t);
            let interpolate = |t: f64, y: &mut NalgebraVec<f64>| {
                let failure = |cause: diffsol::DiffsolError| CycleError::Integration {
                    time: t,
                    cause: cause.to_string(),
                };
                solver.interpolate_inplace(t, y).map_err(failure)
            };
            let mut at = |t: f64| -> Result<State, CycleError> {
                interpolate(t, &mut scratch)?;
                let mut y = [0.0; SIZE];
                y.copy_from_slice(scratch.batch_as_slice(0));
                Ok(y)
            };

            let stretch = self.stretch(from, to, &margin, &mut at)?;
            let (t_end, y_end) = stretch.points[stretch.used - 1];
            if self.recording {
                self.note_levels(from, &stretch.points[..stretch.used], &mut at)?;
                while self.run.recorder.next_time() < t_end {
                    let time = self.run.recorder.next_time();
                    interpolate(time, &mut scratch)?;
                    let y = scratch.batch_as_slice(0);
                    self.run
                        .recorder
                        .push(self.system, &self.mode, &equations.past(time), y);
                }
            }

            self.t = t_end;
            self.y = y_end;
            margin = stretch.margin;
            if self.recording {
                equations.remember(self.t, &self.y);
                self.run.recorder.follow(self.system, &self.mode, &self.y);
                self.run.balance.follow(self.system, &self.mode, &self.y);
                self.guard()?;
                self.schedule();
            }

            let stopped = reason == OdeSolverStopReason::TstopReached;
            let done = stretch.event.is_some() || (stopped && self.is_due()) || self.is_through();
            if let Some((_, slot)) = stretch.event {
                self.cross(slot)?;
            }
            if done {
                let statistics = solver.get_statistics();
                let work = &mut self.run.work;
                work.rejected += statistics.number_of_error_test_failures;
                work.newton_failures += statistics.number_of_nonlinear_solver_fails;
                work.newton_iterations += statistics.number_of_nonlinear_solver_iterations;
                work.factorisations += statistics.number_of_linear_solver_setups;
                return Ok(());
            }
            let next = self.stop_time();
            if (stopped || next < stop) && next > self.t {
                stop = next;
                solver.set_stop_time(stop).map_err(|cause| self.failure(&cause))?;
            }
        }
    }

    /// The step from `from` to `to`, up to the first condition that becomes false; `margin` contains the margins at its
    /// start.
    fn stretch(
        &mut self,
        from: f64,
        to: f64,
        margin: &[f64; SLOTS],
        at: &mut impl FnMut(f64) -> Result<State, CycleError>,
    ) -> Result<Stretch, CycleError> {
        let mut stretch = Stretch {
            points: [(to, self.y); POINTS],
            used: POINTS,
            event: None,
            margin: *margin,
        };
        for (k, point) in stretch.points.iter_mut().enumerate() {
            let t = if k + 1 == POINTS {
                to
            } else {
                from + (to - from) * (k + 1) as f64 / POINTS as f64
            };
            *point = (t, at(t)?);
        }
        let mut left = from;
        for k in 0..POINTS {
            let (t, y) = &stretch.points[k];
            let right = margins(self.system, &self.mode, y);
            for (slot, (before, after)) in stretch.margin.into_iter().zip(right).enumerate() {
                if after > self.event_tolerances[slot] {
                    self.armed[slot] = true;
                } else if after <= 0.0 && (self.armed[slot] || before <= 0.0) {
                    let time = if before > 0.0 {
                        let f = |t: f64| Ok(margins(self.system, &self.mode, &at(t)?)[slot]);
                        locate(left, *t, before, after, f)?
                    } else {
                        left
                    };
                    if stretch.event.is_none_or(|(earliest, _)| time < earliest) {
                        stretch.event = Some((time, slot));
                    }
                }
            }
            (left, stretch.margin) = (*t, right);
            if let Some((time, _)) = stretch.event {
                stretch.points[k] = (time, at(time)?);
                stretch.used = k + 1;
                break;
            }
        }
        Ok(stretch)
    }

    /// Records when the trajectory from `from` through `points` crosses the levels that define t0..t18.
    fn note_levels(
        &mut self,
        from: f64,
        points: &[(f64, State)],
        at: &mut impl FnMut(f64) -> Result<State, CycleError>,
    ) -> Result<(), CycleError> {
        let logged = self.run.log.len();
        let mut left = from;
        for (t, y) in points {
            let now = heights(self.system, &self.mode, y);
            for (index, (before, after)) in self.heights.into_iter().zip(now).enumerate() {
                if (before > 0.0) != (after > 0.0) {
                    let f = |t: f64| Ok(heights(self.system, &self.mode, &at(t)?)[index]);
                    let time = locate(left, *t, before, after, f)?;
                    self.run
                        .log
                        .level((self.system, &self.mode), index, time, after > 0.0, &at(time)?);
                }
            }
            self.run.log.follow(&now);
            (left, self.heights) = (*t, now);
        }
        self.run.log.sort_from(logged);
        Ok(())
    }

    /// Applies the event of `slot` at the current time.
    fn cross(&mut self, slot: usize) -> Result<(), CycleError> {
        let (window, count) = &mut self.chatter[slot];
        if self.t - *window > CHATTER_WINDOW {
            (*window, *count) = (self.t, 0);
        }
        *count += 1;
        if *count > CHATTER_CHANGES {
            let contact = slot_name(slot);
            return Err(CycleError::Chatter {
                contact,
                count: *count,
                window: CHATTER_WINDOW,
                time: self.t,
            });
        }
        let before = (self.mode, self.y);
        let impact = is_impact(slot, &self.mode);
        cross(self.system, slot, &mut self.mode, &mut self.y);
        if impact && let Some(law) = self.system.envelope.law().fitted() {
            let [lowest, highest] = law.impacts();
            let speed = self.mode.impact;
            if !(lowest..=highest).contains(&speed) {
                return Err(CycleError::BeyondFit { speed, lowest, highest });
            }
        }
        if self.recording {
            self.note_crossing(slot, impact, &before);
        }
        let margin = margins(self.system, &self.mode, &self.y);
        for (other, armed) in self.armed.iter_mut().enumerate() {
            *armed = margin[other] > self.event_tolerances[other] || (other != slot && *armed);
        }
        Ok(())
    }

    /// Records the effect of the event of `slot` on the state `before`.
    fn note_crossing(&mut self, slot: usize, impact: bool, before: &(Mode, State)) {
        self.run
            .balance
            .cross(self.system, slot, (&before.0, &before.1), (&self.mode, &self.y));
        if let Some((crossing, rising)) = entry(slot, &before.0, &self.mode) {
            self.run
                .log
                .push((self.system, &self.mode), crossing, self.t, rising, &self.y);
        }
        if self.mode.released && !before.0.released {
            self.run
                .log
                .push((self.system, &self.mode), Crossing::Trigger, self.t, false, &self.y);
        }
        if impact {
            self.run.impact = Some((before.1[V_P], self.y[V_P]));
        }
        if slot < Contact::COUNT && self.mode.closed[slot] {
            self.run.closings[slot] += 1;
        }
        self.run.work.events += 1;
    }

    /// Ends the run where the model becomes invalid.
    fn guard(&self) -> Result<(), CycleError> {
        let now = self.system.instant(&self.y);
        let c = &self.system.p.chambers;
        if now.volume[BELOW] < DRY_FIRE * c.below_piston {
            return Err(CycleError::DryFire {
                time: self.t,
                compression: now.travel - self.system.p.piston.stroke,
                available: c.below_piston / self.system.geometry.ring_area,
            });
        }
        for (i, name) in VOLUME_NAMES.iter().enumerate() {
            let (size, mass) = (now.volume[i], self.y[MASS + i]);
            // The published gas law does not relate the gas to the mass that has flowed in and out (C-02).
            let massless = mass <= 0.0 && self.system.p.model.gas == Form::Corrected;
            if !(size > 0.0 && !massless && self.y[ENERGY + i] > 0.0) {
                return Err(CycleError::Collapse {
                    volume: name,
                    time: self.t,
                    size,
                    mass,
                });
            }
        }
        Ok(())
    }

    /// Updates the schedule from the log so far: release of the trigger, landing, end of the record.
    fn schedule(&mut self) {
        let log = &self.run.log;
        if log.len() > self.read {
            self.read = log.len();
            // A tool that has not risen by the guard's travel cannot land, whoever releases its trigger.
            let risen = log.first(Crossing::Guard, false, 0.0);
            if let Some(risen) = risen {
                let by_guard = risen + self.system.geometry.channel_delay;
                self.filling = Some(self.filling.map_or(by_guard, |filling| filling.min(by_guard)));
            }
            if let Some(landing) = risen.and_then(|risen| log.first(Crossing::Landing, true, risen)) {
                self.end = self.end.min(landing);
                self.run.landed = true;
            }
            self.home = log.back_home();
        }
        if let Some(t18) = self.home.and_then(|t16| log.rest(t16, self.t)) {
            self.end = self.end.min((t18 + self.settings.tail).max(self.t));
        }
    }
}
