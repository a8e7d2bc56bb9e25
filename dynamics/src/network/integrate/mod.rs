//! Segments between events. Each is a smooth problem solved by diffsol.
//!
//! A step may extend beyond an event, because the right-hand side of a mode is smooth everywhere. The event is then
//! located on the solver's interpolant, the state is evaluated there, and the next segment starts in the new mode.

mod stability;
mod state;
mod trajectory;

use stability::Stability;

use diffsol::matrix::dense_nalgebra_serial::NalgebraMat;
use diffsol::ode_solver::state::StateCommon;
use diffsol::{NalgebraVec, OdeBuilder, OdeSolverMethod, OdeSolverState, OdeSolverStopReason, Vector};

use super::audit::Audit;
use super::drive::Drive;
use super::equations::{Equations, Problem};
use super::error::RunError;
use super::events::Events;
use super::linear::LedgerLu;
use super::mode::Mode;
use super::numerics::Numerics;
use super::plan::Plan;
use super::probe::Need;
use super::rates::Workspace;
use super::record::{Effort, EventTime, LedgerEntry, LogEntry, Parts, Peak, Record, Strike};
use super::record::{peaked, state_columns};
use super::recorder::Recorder;
use super::signals::Signals;
use super::switching::Slots;
use super::tolerances::tolerances;
use super::watch::Watch;
use crate::{Method, WoodMotion};

/// Number of points per step, including its end, where conditions are checked.
const POINTS: usize = 2;
/// Number of steps per second of the record after which a run is abandoned, but at least half a million.
const STEP_LIMIT: usize = 500_000;

/// Whether the next step of an explicit method, after a time and a state, is unstable.
type Stiff<'s> = &'s mut dyn FnMut(f64, &[f64], f64) -> bool;

/// Part of a window that need not be integrated, because the remainder after an event may be too short for a step
/// \[s\].
const SHORTEST: f64 = 1e-12;
/// Number of steps per window of a coupled run after which it is abandoned.
const WINDOW_LIMIT: f64 = 100.0;

/// A run in progress.
pub(crate) struct Run<'p> {
    pub(crate) plan: &'p Plan,
    numerics: &'p Numerics,
    slots: &'p Slots,
    pub(crate) mode: Mode,
    pub(crate) signals: Signals,
    pub(crate) t: f64,
    pub(crate) y: Vec<f64>,
    /// End of the current window of a coupled run.
    window: Option<f64>,
    /// Whether the step is accepted or only a trial.
    recording: bool,
    pub(crate) end: f64,
    /// Whether the record ends at an event that it must not pass.
    pub(crate) cut: bool,
    /// Time of the event that the finish waits for, once known.
    finish_after: Option<f64>,
    pub(crate) w: Workspace,
    events: Events,
    pub(crate) watch: Watch,
    pub(crate) armed: Vec<bool>,
    pub(crate) chatter: Vec<(f64, usize)>,
    recorder: Recorder,
    audit: Audit,
    log: Vec<LogEntry>,
    peaks: Vec<Peak>,
    strikes: Vec<Strike>,
    work: Effort,
    /// Margins at the last point, and points of the current step.
    margin: Vec<f64>,
    right: Vec<f64>,
    heights: [Vec<f64>; POINTS],
    watched: [Vec<f64>; POINTS],
    points: [(f64, Vec<f64>); POINTS],
    /// How far a state must be evaluated for margins and levels.
    need: Need,
    /// Whether the workspace contains the instant at the end of the step.
    fresh: bool,
}

/// Integrates a compiled assembly.
pub(crate) fn integrate(plan: &Plan, numerics: &Numerics) -> Result<Record, RunError> {
    let slots = Slots::new(plan)?;
    let mut run = Run::new(plan, numerics, &slots, None)?;
    let problem = run.problem()?;
    while run.t < run.end {
        run.segment(&problem)?;
    }
    run.finish(&problem)
}

impl<'p> Run<'p> {
    /// A run before its start, on its own workpiece or on an external one at rest.
    pub(crate) fn new(
        plan: &'p Plan,
        numerics: &'p Numerics,
        slots: &'p Slots,
        rest: Option<&WoodMotion>,
    ) -> Result<Self, RunError> {
        let mut origin = plan.start()?;
        if let (Some(driven), Some(rest)) = (&plan.driven, rest) {
            origin.mode.wood = Some(Drive::at_rest(rest, 1.0));
            plan.start_clock(driven, &mut origin.y);
        }
        let mut w = Workspace::new(plan);
        let mut events = Events::new(plan)?;
        let need = slots.need.max(events.need).max(Need::Instant);
        let mut mode = origin.mode;
        let mut margin = vec![0.0; slots.list.len()];
        plan.observe(need, 0.0, &origin.y, &mode, &mut w);
        // Conditions of gates at the start.
        for passage in 0..plan.passages.len() {
            if let Some(switch) = plan.passages[passage].condition {
                mode.switches[switch] = 1;
            }
        }
        slots.margins(plan, &mode, &w, &mut margin);
        for (slot, margin) in slots.list.iter().zip(&mut margin) {
            if let super::switching::Slot::Condition { passage, .. } = slot
                && *margin <= 0.0
                && let Some(switch) = plan.passages[*passage].condition
            {
                mode.switches[switch] = 0;
                *margin = -*margin;
            }
        }
        let mut heights = vec![0.0; events.levels()];
        events.measure(plan, &mode, &w, &mut heights);
        events.begin(heights.clone());
        let mut watch = Watch::new(plan);
        let mut watched = vec![0.0; watch.len()];
        watch.measure(0.0, plan, &mode, &w, &mut watched);
        watch.settle(&watched);
        let armed = margin.iter().map(|m| *m > 0.0).collect();
        let audit = Audit::new(plan, &origin.y, &mode, &w);
        let point = || (0.0, vec![0.0; origin.y.len()]);
        Ok(Self {
            plan,
            numerics,
            slots,
            recorder: Recorder::new(plan, numerics)?,
            mode,
            signals: origin.signals,
            t: 0.0,
            window: None,
            recording: true,
            end: plan.assembly.end,
            cut: false,
            finish_after: None,
            w,
            events,
            watch,
            watched: [watched.clone(), watched],
            armed,
            chatter: vec![(0.0, 0); slots.list.len()],
            audit,
            log: Vec::new(),
            peaks: peaked(plan),
            strikes: Vec::new(),
            work: Effort::default(),
            right: margin.clone(),
            margin,
            heights: [heights.clone(), heights],
            points: [point(), point()],
            need,
            fresh: false,
            y: origin.y,
        })
    }

    pub(crate) fn problem(&self) -> Result<Problem<'p>, RunError> {
        let mut problem = OdeBuilder::<NalgebraMat<f64>>::new()
            .rtol(0.0)
            .atol(tolerances(self.plan, self.numerics.relative_tolerance))
            .build_from_eqn(Equations::new(self.plan, self.mode.clone(), self.w.past.clone()))
            .map_err(|cause| self.failure(&cause))?;
        // No limit, because failures are counted over a complete segment; STEP_LIMIT and the smallest step end a
        // hopeless run.
        problem.ode_options.max_nonlinear_solver_failures = usize::MAX;
        problem.ode_options.min_timestep = 1e-16;
        Ok(problem)
    }

    /// Advances to a given time, for the record or as a trial.
    pub(crate) fn advance(&mut self, problem: &Problem<'p>, to: f64, recording: bool) -> Result<(), RunError> {
        (self.window, self.recording) = (Some(to), recording);
        while !self.is_through() {
            self.segment(problem)?;
        }
        self.t = to;
        Ok(())
    }

    /// Whether the run, or its current window, is complete.
    fn is_through(&self) -> bool {
        match self.window {
            Some(end) => end - self.t <= SHORTEST,
            // An event may lie at the largest number below the end.
            None => self.t >= self.end * (1.0 - 4.0 * f64::EPSILON),
        }
    }

    fn failure(&self, cause: &diffsol::DiffsolError) -> RunError {
        RunError::Integration {
            time: self.t,
            cause: cause.to_string(),
        }
    }

    /// Next time at which the smooth problem must end.
    fn stop_time(&self) -> f64 {
        self.window.unwrap_or(self.end).min(self.signals.next(self.t))
    }

    /// Time that the next steps may reach: the end of the problem, or that of the known past flows.
    fn reach(&self) -> f64 {
        self.stop_time().min(self.t + self.plan.shortest_delay)
    }

    /// Stores the flow that enters delayed passages at an accepted state.
    fn remember(&mut self) {
        if self.plan.shortest_delay < f64::INFINITY {
            let mut rate = vec![0.0; self.y.len()];
            self.plan.rates(self.t, &self.y, &self.mode, &mut self.w, &mut rate);
            self.plan.remember(self.t, &self.y, &rate, &self.mode, &self.w);
        }
    }

    /// Applies all changes of gates that are due.
    fn switch_gates(&mut self) -> Result<(), RunError> {
        self.plan.instant(&self.y, &self.mode, &mut self.w);
        loop {
            let before = self.mode.clone();
            let Some(word) = self.signals.due(self.plan, self.t, &mut self.mode, &self.w)? else {
                return Ok(());
            };
            if self.recording {
                let name = self.plan.assembly.name_of(word.block);
                let states = (&before, &self.y[..]);
                self.audit
                    .cross(self.plan, name, states, (&self.mode, &self.y), &mut self.w);
            }
            self.announce_now(word);
        }
    }

    /// Step size for a first-order start, from its error h^2 |y''|/3.
    fn first_step(&self, problem: &Problem<'p>, second: &[f64]) -> f64 {
        let atol = problem.atol.batch_as_slice(0);
        let sum: f64 = second.iter().zip(atol).map(|(d, atol)| (d / atol) * (d / atol)).sum();
        let norm = (sum / second.len() as f64).sqrt();
        (1.5 / norm).sqrt().clamp(1e-12, 1e-5)
    }

    fn segment(&mut self, problem: &Problem<'p>) -> Result<(), RunError> {
        self.switch_gates()?;
        problem.eqn.set_mode(&self.mode);
        if self.recording {
            self.remember();
        }
        // A window is short enough to be tried in one step by a method that needs no starting procedure.
        if let Some(end) = self.window {
            let first = problem.eqn.rates(self.t, &self.y);
            return self.one_step(problem, first, end - self.t);
        }
        let (first, step) = self.start(problem);
        match self.numerics.method {
            Method::Esdirk34 => self.one_step(problem, first, step),
            Method::Bdf => self.multistep(problem, first, step),
            Method::Switching => {
                let Some(stability) = Stability::new(problem, step) else {
                    return self.multistep(problem, first, step);
                };
                if self.explicit(problem, first, step, stability)? {
                    return Ok(());
                }
                let (first, step) = self.start(problem);
                self.multistep(problem, first, step)
            }
        }
    }

    /// y' at the present state, and the first step of a first-order method; evaluates the Jacobian.
    fn start(&self, problem: &Problem<'p>) -> (Vec<f64>, f64) {
        let [first, second] = problem.eqn.derivatives(self.t, &self.y);
        let step = self.first_step(problem, &second);
        (first, step)
    }

    /// Integrates a segment by an implicit Runge-Kutta method.
    fn one_step(&mut self, problem: &Problem<'p>, first: Vec<f64>, step: f64) -> Result<(), RunError> {
        let solver = problem.esdirk34_solver::<LedgerLu>(self.initial(first, step));
        self.follow(solver.map_err(|cause| self.failure(&cause))?, None)?;
        Ok(())
    }

    /// Integrates a segment by backward differentiation formulas.
    fn multistep(&mut self, problem: &Problem<'p>, first: Vec<f64>, step: f64) -> Result<(), RunError> {
        let solver = problem.bdf_solver::<LedgerLu>(self.initial(first, step));
        self.follow(solver.map_err(|cause| self.failure(&cause))?, None)?;
        Ok(())
    }

    /// Integrates a segment by an explicit Runge-Kutta pair while that is stable; the result is whether it has ended.
    fn explicit(
        &mut self,
        problem: &Problem<'p>,
        first: Vec<f64>,
        step: f64,
        mut stability: Stability,
    ) -> Result<bool, RunError> {
        let start = self.initial(first, Stability::first_step(step));
        let solver = problem.tsit45_solver(start).map_err(|cause| self.failure(&cause))?;
        self.follow(solver, Some(&mut |t, y, h| stability.is_exceeded(problem, t, y, h)))
    }

    /// The present state with its derivative and a first step, for a solver.
    fn initial<S: OdeSolverState<NalgebraVec<f64>>>(&self, first: Vec<f64>, step: f64) -> S {
        let empty = || NalgebraVec::<f64>::zeros(0, Default::default());
        S::new_from_common(StateCommon {
            y: NalgebraVec::from_vec(self.y.clone(), Default::default()),
            h: step,
            dy: NalgebraVec::from_vec(first, Default::default()),
            g: empty(),
            dg: empty(),
            s: empty(),
            ds: empty(),
            sg: empty(),
            dsg: empty(),
            t: self.t,
        })
    }

    /// Integrates to the end of the segment, or to a step after which `stiff` is true of time, state and next step; the
    /// result is whether the segment has ended.
    fn follow<'e, M>(&mut self, mut solver: M, mut stiff: Option<Stiff<'_>>) -> Result<bool, RunError>
    where
        M: OdeSolverMethod<'e, Equations<'p>>,
        'p: 'e,
    {
        let (mut end, mut stop) = (self.stop_time(), self.reach());
        solver.set_stop_time(stop).map_err(|cause| self.failure(&cause))?;
        let mut scratch = NalgebraVec::<f64>::zeros(self.y.len(), Default::default());
        self.plan
            .observe(self.slots.need, self.t, &self.y, &self.mode, &mut self.w);
        self.slots.margins(self.plan, &self.mode, &self.w, &mut self.margin);
        let windows = match (self.window, self.numerics.sample_interval) {
            (Some(_), Some(interval)) => self.plan.assembly.end / interval,
            _ => 0.0,
        };
        let limit = STEP_LIMIT * (self.plan.assembly.end.ceil().max(1.0) as usize) + (WINDOW_LIMIT * windows) as usize;
        loop {
            let reason = match solver.step() {
                Ok(reason) => reason,
                // An explicit method fails where stability requires very short steps.
                Err(_) if stiff.is_some() => return Ok(false),
                Err(cause) => return Err(self.failure(&cause)),
            };
            self.work.steps += 1;
            if self.work.steps > limit {
                return Err(RunError::Integration {
                    time: self.t,
                    cause: format!("{limit} steps were not enough"),
                });
            }
            let (from, to) = (self.t, solver.state().t);
            let mut at = |t: f64, y: &mut [f64]| -> Result<(), RunError> {
                solver
                    .interpolate_inplace(t, &mut scratch)
                    .map_err(|cause| RunError::Integration {
                        time: t,
                        cause: cause.to_string(),
                    })?;
                y.copy_from_slice(scratch.batch_as_slice(0));
                Ok(())
            };
            let stretch = self.stretch(from, to, &mut at)?;
            let (used, mut is_cut, mut event) = (stretch.used, stretch.is_cut, stretch.event);
            if self.recording {
                self.note_levels(from, used, &mut at)?;
            }
            self.note_changes(from, used, &mut at)?;
            let mut t_end = self.points[used - 1].0;
            if self.recording {
                self.schedule(t_end);
                if self.window.is_none() && self.end < t_end {
                    // Samples, peaks and balances of the step end with the record.
                    t_end = self.end;
                    (is_cut, event) = (false, None);
                    self.fresh = false;
                    at(t_end, &mut self.points[used - 1].1)?;
                }
            }
            while self.recording && self.recorder.next_time() < t_end {
                self.fresh = false;
                let time = self.recorder.next_time();
                solver
                    .interpolate_inplace(time, &mut scratch)
                    .map_err(|cause| self.failure(&cause))?;
                let y = scratch.batch_as_slice(0);
                self.recorder.push(self.plan, time, y, &self.mode, &mut self.w);
                self.follow_peaks();
            }
            self.t = t_end;
            self.y.copy_from_slice(&self.points[used - 1].1);
            if self.recording {
                self.accept()?;
            }

            let stopped = reason == OdeSolverStopReason::TstopReached;
            let due = (stopped && stop >= end) || self.signals.is_due(self.t);
            if let Some(slot) = event {
                self.cross(slot)?;
            }
            let ended = is_cut || due || self.is_through();
            let next = solver.state().h;
            if ended || stiff.as_mut().is_some_and(|stiff| stiff(self.t, &self.y, next)) {
                let statistics = solver.get_statistics();
                self.work.rejected += statistics.number_of_error_test_failures;
                self.work.newton_failures += statistics.number_of_nonlinear_solver_fails;
                self.work.newton_iterations += statistics.number_of_nonlinear_solver_iterations;
                self.work.factorisations += statistics.number_of_linear_solver_setups;
                return Ok(ended);
            }
            end = self.stop_time();
            let next = self.reach();
            if (stopped || next < stop) && next > self.t {
                stop = next;
                solver.set_stop_time(stop).map_err(|cause| self.failure(&cause))?;
            }
        }
    }

    /// Ends the record.
    pub(crate) fn finish(mut self, problem: &Problem<'p>) -> Result<Record, RunError> {
        let plan = self.plan;
        // If the end is on the grid, the last sample is exactly at the end.
        if !self.cut && self.recorder.next_time() <= self.t * (1.0 + 4.0 * f64::EPSILON) {
            self.recorder.push(plan, self.t, &self.y, &self.mode, &mut self.w);
        }
        let calls = problem.eqn.calls();
        self.work.evaluations = calls.rates;
        self.work.jacobians = calls.jacobians;
        let times = self.events.times(plan, self.t);
        plan.observe(Need::Forces, self.t, &self.y, &self.mode, &mut self.w);
        let outcome = Events::outcome(plan, &times, &self.mode, &self.w)?;
        let events = plan.assembly.events.iter().zip(times).map(|(event, time)| EventTime {
            name: event.name.clone(),
            description: event.description.clone(),
            time,
        });
        let events = events.collect();
        let checks = self.audit.checks(plan);
        let energies = self.audit.energies(plan, &self.y, &self.mode, &self.w);
        let integrals = plan.ledger.iter().zip(&self.y[plan.states()..]);
        let mut ledger: Vec<LedgerEntry> = integrals
            .map(|(item, value)| LedgerEntry {
                name: item.name.clone(),
                unit: item.unit,
                value: *value,
            })
            .collect();
        ledger.extend(
            energies
                .into_iter()
                .map(|(name, value)| LedgerEntry { name, unit: "J", value }),
        );
        let parts = Parts {
            end: self.t,
            events,
            log: self.log,
            condition_changes: self.events.into_changes(plan),
            state_columns: state_columns(plan),
            outcome,
            ledger,
            peaks: self.peaks,
            strikes: self.strikes,
            checks,
            work: self.work,
        };
        Ok(Record::new(parts, self.recorder))
    }
}
