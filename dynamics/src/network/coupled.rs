//! The network as one side of a coupling with an external workpiece.

use super::drive::{Drive, Driven};
use super::equations::Problem;
use super::error::RunError;
use super::integrate::Run;
use super::mode::Mode;
use super::numerics::Numerics;
use super::plan::Plan;
use super::probe::Need;
use super::rates::Workspace;
use super::record::Record;
use super::signals::Signals;
use super::switching::Slots;
use super::watch::Watch;
use crate::coupling::{Answer, Side, Step, couple};
use crate::{CouplingWork, WoodForces, Workpiece};
use nailnoise_penetration::Dual;

/// Number of trials for the position of rest; more than one is needed only for a tool that also rests on another body.
const REST_TRIALS: usize = 20;
/// Difference of the force on the workpiece at rest that may remain, as a fraction of it.
const AT_REST: f64 = 1e-9;

/// The part of a run's state that a trial changes.
struct Held {
    mode: Mode,
    signals: Signals,
    watch: Watch,
    t: f64,
    y: Vec<f64>,
    armed: Vec<bool>,
    chatter: Vec<(f64, usize)>,
}

/// Integrates a plan with a driven body.
pub(crate) fn integrate_on<W: Workpiece<Error: From<RunError>>>(
    mut plan: Plan,
    driven: Driven,
    numerics: &Numerics,
    wood: &mut W,
) -> Result<(Record, CouplingWork), W::Error> {
    let interval = numerics.sample_interval.ok_or(RunError::Value {
        name: "sample_interval",
        value: f64::INFINITY,
        rule: "the step of the coupling with the workpiece",
    })?;
    let mut seat = plan.force_at_rest(&driven)?;
    let mut rest = wood.start(seat)?;
    for _ in 0..REST_TRIALS {
        plan.place_wood(&driven, rest.seat[0]);
        let force = plan.force_at_rest(&driven)?;
        if (force - seat).abs() <= AT_REST * seat.abs() {
            break;
        }
        seat = force;
        rest = wood.start(seat)?;
    }
    let slots = Slots::new(&plan)?;
    let run = Run::new(&plan, numerics, &slots, Some(&rest))?;
    let problem = run.problem()?;
    let mut cycle = Cycle { run, problem, driven };
    let (motion, work) = couple(&mut cycle, wood, rest, interval)?;
    if !cycle.run.cut {
        // Window of the last sample, whose length is practically zero.
        let drive = Drive::at_rest(&motion, interval);
        cycle.drive(drive);
        cycle.run.end = work.steps as f64 * interval;
    }
    let Cycle { run, problem, .. } = cycle;
    Ok((run.finish(&problem)?, work))
}

impl Plan {
    /// Force of all other bodies on the driven body at the start \[N\].
    fn force_at_rest(&self, driven: &Driven) -> Result<f64, RunError> {
        let origin = self.start()?;
        let mut w = Workspace::new(self);
        self.observe(Need::Forces, 0.0, &origin.y, &origin.mode, &mut w);
        Ok(w.force[driven.body] + w.force[self.grip()])
    }
}

/// A run on a workpiece that moves as prescribed.
struct Cycle<'p> {
    run: Run<'p>,
    problem: Problem<'p>,
    driven: Driven,
}

impl Cycle<'_> {
    /// Prescribes the motion of the workpiece over the next window.
    fn drive(&mut self, drive: Drive) {
        let Run { plan, mode, y, .. } = &mut self.run;
        mode.wood = Some(drive);
        for contact in &plan.contacts {
            if let Some([open, caught]) = contact.landing {
                mode.switches[open] = u8::from(!mode.is_on(contact.switch));
                mode.switches[caught] = 0;
            }
        }
        plan.start_clock(&self.driven, y);
    }

    /// Integrates a step, for the record or as a trial.
    fn follow(&mut self, step: &Step, recording: bool) -> Result<(), RunError> {
        self.drive(Drive::new(step, step.to - self.run.t));
        self.run.advance(&self.problem, step.to, recording)
    }

    fn hold(&self) -> Held {
        let run = &self.run;
        Held {
            mode: run.mode.clone(),
            signals: run.signals.clone(),
            watch: run.watch.clone(),
            t: run.t,
            y: run.y.clone(),
            armed: run.armed.clone(),
            chatter: run.chatter.clone(),
        }
    }

    fn restore(&mut self, held: Held) {
        let run = &mut self.run;
        run.mode = held.mode;
        run.signals = held.signals;
        run.watch = held.watch;
        run.t = held.t;
        run.y = held.y;
        run.armed = held.armed;
        run.chatter = held.chatter;
    }
}

impl Side for Cycle<'_> {
    type Error = RunError;

    fn attempt(&mut self, step: &Step) -> Result<Answer, RunError> {
        let held = self.hold();
        self.follow(step, false)?;
        let answer = self.answer();
        self.restore(held);
        Ok(answer)
    }

    fn complete(&mut self, step: &Step) -> Result<(), RunError> {
        self.follow(step, true)
    }

    fn answer(&mut self) -> Answer {
        let Run {
            plan, mode, t, y, w, ..
        } = &mut self.run;
        plan.observe(Need::Forces, *t, y, mode, w);
        let (seat, grip) = (self.driven.body, plan.grip());
        let mut force = w.force[seat];
        let (mut stiffness, mut damping) = ([0.0; 2], [0.0; 2]);
        plan.pair_elements(mode, w, &mut |element| {
            for (body, place) in [(grip, 0), (seat, 1)] {
                if element.pair.on == body || element.pair.against == body {
                    stiffness[place] -= element.force.slope[0];
                    damping[place] -= element.force.slope[1];
                }
            }
        });
        // A contact that caught its body within the step stays closed to its end, but does not pull.
        for (contact, push) in plan.contacts.iter().zip(&w.contact) {
            if contact.landing.is_some() && mode.is_on(contact.switch) && push.force <= 0.0 {
                let on = if contact.pair.on == seat { -1.0 } else { 1.0 };
                force -= on * contact.side * push.force;
                let [x, v] = [w.travel(contact.pair), w.speed(contact.pair)];
                let (u, rate) = contact.overlap(x, v);
                let along = |value: f64, place: usize| Dual {
                    value,
                    slope: std::array::from_fn(|i| if i == place { 1.0 } else { 0.0 }),
                };
                let [by_overlap, by_rate]: [f64; 2] = contact.push(along(u, 0), along(rate, 1)).force.slope;
                stiffness[1] -= by_overlap;
                damping[1] -= by_rate;
            }
        }
        let depth = plan.fasteners.iter().position(|own| own.work.against == grip);
        Answer {
            forces: WoodForces {
                nail: w.force[grip],
                depth: depth.map_or(0.0, |fastener| plan.deepest(fastener, mode, w)),
                seat: force,
            },
            stiffness,
            damping,
        }
    }

    fn end(&self) -> f64 {
        self.run.end
    }

    fn is_cut(&self) -> bool {
        self.run.cut
    }

    fn disagreement(time: f64, mismatch: f64, limit: f64) -> RunError {
        RunError::Coupling { time, mismatch, limit }
    }
}
