//! The cycle as one side of a coupling with external wood.

use super::integrate::{Cycle, Problem, Run};
use super::mode::{Contact, Mode, Penetration};
use super::state::*;
use super::switching::{SLOTS, deepest};
use super::system::System;
use super::wood::DrivenWood;
use crate::coupling::{Answer, Side, Step, couple};
use crate::{CouplingWork, CycleError, Settings, WoodForces, WoodMotion, Workpiece};
use nailnoise_penetration::Dual;

/// The part of a cycle's state that a trial changes.
struct Held {
    mode: Mode,
    t: f64,
    y: State,
    armed: [bool; SLOTS],
    chatter: [(f64, usize); SLOTS],
}

/// Integrates a cycle on external wood.
pub(crate) fn integrate_on<W: Workpiece<Error: From<CycleError>>>(
    system: &System,
    settings: &Settings,
    wood: &mut W,
) -> Result<(Run, CouplingWork), W::Error> {
    let rest = wood.start(super::start::seat_force(system)?)?;
    let cycle = Cycle::new(system, settings, Some(&rest))?;
    let problem = cycle.problem()?;
    let h = settings.sample_interval;
    let mut driven = Driven { cycle, problem };
    let (motion, work) = couple(&mut driven, wood, rest, h)?;
    let Driven { mut cycle, problem } = driven;
    if !cycle.run.landed {
        // Window of the last sample, whose length is practically zero.
        cycle.drive(&motion, &motion, &motion, h);
        cycle.end = work.steps as f64 * h;
    }
    Ok((cycle.finish(&problem), work))
}

/// A cycle on wood that moves as prescribed.
struct Driven<'s> {
    cycle: Cycle<'s>,
    problem: Problem<'s>,
}

impl Driven<'_> {
    /// Integrates a step, for the record or as a trial.
    fn follow(&mut self, step: &Step, recording: bool) -> Result<(), CycleError> {
        let length = step.to - self.cycle.t;
        self.cycle.drive(&step.start, &step.end, &step.free, length);
        self.cycle.advance(&self.problem, step.to, recording)
    }
}

impl Side for Driven<'_> {
    type Error = CycleError;

    fn attempt(&mut self, step: &Step) -> Result<Answer, CycleError> {
        let held = self.cycle.hold();
        self.follow(step, false)?;
        let answer = self.cycle.answer();
        self.cycle.restore(&held);
        Ok(answer)
    }

    fn complete(&mut self, step: &Step) -> Result<(), CycleError> {
        self.follow(step, true)
    }

    fn answer(&mut self) -> Answer {
        self.cycle.answer()
    }

    fn end(&self) -> f64 {
        self.cycle.end
    }

    fn is_cut(&self) -> bool {
        self.cycle.run.landed
    }

    fn disagreement(time: f64, mismatch: f64, limit: f64) -> CycleError {
        CycleError::Coupling { time, mismatch, limit }
    }
}

impl<'s> Cycle<'s> {
    /// Prescribes the motion of the wood over the next window.
    fn drive(&mut self, start: &WoodMotion, end: &WoodMotion, free: &WoodMotion, length: f64) {
        let open = !self.mode.closed(Contact::Nose);
        self.mode.wood = Some(DrivenWood::new(start, end, free, length, open));
        self.y[Y_W] = 0.0;
        self.y[V_W] = 1.0;
    }

    /// Advances the cycle to a given time, for the record or as a trial.
    fn advance(&mut self, problem: &Problem<'s>, to: f64, recording: bool) -> Result<(), CycleError> {
        (self.window, self.recording) = (Some(to), recording);
        while !self.is_through() {
            self.segment(problem)?;
        }
        self.t = to;
        Ok(())
    }

    fn hold(&self) -> Held {
        Held {
            mode: self.mode,
            t: self.t,
            y: self.y,
            armed: self.armed,
            chatter: self.chatter,
        }
    }

    fn restore(&mut self, held: &Held) {
        self.mode = held.mode;
        self.t = held.t;
        self.y = held.y;
        self.armed = held.armed;
        self.chatter = held.chatter;
    }

    /// Forces on the wood at the current state.
    fn answer(&self) -> Answer {
        let (system, mode, y) = (self.system, &self.mode, &self.y);
        let f = system.forces(y, &system.instant(y), mode);
        let nose = Contact::Nose as usize;
        let (stiffness, damping) = if mode.closed[nose] && f.push[nose] > 0.0 {
            (system.springs[nose].stiffness, system.springs[nose].damping)
        } else {
            (0.0, 0.0)
        };
        let guard = if mode.guard { system.guard_stiffness } else { 0.0 };
        let z = Dual {
            value: system.depth(mode, y),
            slope: [1.0, 0.0],
        };
        let v = Dual {
            value: y[V_P] - mode.nail_motion(y).1,
            slope: [0.0, 1.0],
        };
        let [nail, nail_damping] = match mode.penetration {
            Penetration::Free { .. } => [0.0; 2],
            Penetration::Loading { seated: false } => system.envelope.law().evaluate(z, v, mode.impact).slope,
            Penetration::Loading { seated: true } => {
                let shank = system.envelope.seated(v, mode.impact).slope;
                [system.envelope.head_at(z).slope[0], shank[1]]
            }
            Penetration::Unloading { .. } => [system.p.wood.unloading_stiffness, 0.0],
        };
        Answer {
            forces: WoodForces {
                nail: f.penetration,
                depth: deepest(system, mode, y),
                seat: f.push[nose].max(0.0) + f.guard,
            },
            stiffness: [nail, stiffness + guard],
            damping: [nail_damping, damping],
        }
    }
}
