//! The cycle coupled to wood whose motion another solver computes.
//!
//! Both sides advance with the same step h. Over a step, the motion of the wood follows cubics that end at
//!
//! ```text
//! w = w_free + C F,    F = F(w)
//! ```
//! where F are the cycle's forces at the end of the step. The left equation is the response of the structure. The right
//! one is the cycle integrated over the step for this motion of the wood, with all its events located. The forces are
//! found by Newton's method for F - F(w_free + C F) = 0 with
//!
//! ```text
//! dF/dw = -(k_n + k_e)  and  -dE/dz,   dF/dw' = -c_n
//! ```
//! of the contacts that are closed at the end. The neglected term, the motion of the bodies within a step, is of order
//! k h^2/M, about a thousandth. Two or three trials therefore suffice, however stiff the contacts are relative to the
//! wood.

use super::integrate::{Cycle, Problem, Run};
use super::mode::{Contact, Mode, Penetration};
use super::state::*;
use super::switching::{SLOTS, deepest};
use super::system::System;
use super::wood::DrivenWood;
use crate::{CouplingWork, CycleError, Settings, WoodForces, WoodMotion, Workpiece};
use nailnoise_penetration::Dual;

/// Tolerance on the difference between the forces of both sides, as a fraction of the largest force so far.
const AGREEMENT: f64 = 1e-9;
/// Number of trials after which forces that keep jumping are accepted as they are.
const TRIALS: usize = 40;
/// Number of trials after which Newton steps are halved.
const DAMPED: usize = 12;
/// Jump of a force that may remain in a step, as a fraction of the largest force so far; when the tip meets the wood,
/// the force jumps to 1 % of its final value.
const JUMP: f64 = 0.05;

/// Forces on the wood at a state, with -dF/dw and -dF/dw' at the nail and the seat.
#[derive(Debug, Clone, Copy)]
struct Answer {
    forces: WoodForces,
    stiffness: [f64; 2],
    damping: [f64; 2],
}

/// The part of a cycle's state that a trial changes.
struct Held {
    mode: Mode,
    t: f64,
    y: State,
    armed: [bool; SLOTS],
    chatter: [(f64, usize); SLOTS],
}

/// Integrates a cycle on external wood.
pub(crate) fn integrate_on<W: Workpiece>(
    system: &System,
    settings: &Settings,
    wood: &mut W,
) -> Result<(Run, CouplingWork), W::Error> {
    let rest = wood.start(super::start::seat_force(system)?)?;
    let mut cycle = Cycle::new(system, settings, Some(&rest))?;
    let problem = cycle.problem()?;
    let mut work = CouplingWork::default();
    let mut motion = rest;
    let mut forces = [cycle.answer().forces; 2];
    let mut largest = forces[1].seat;
    let h = settings.sample_interval;
    while work.steps as f64 * h < cycle.end * (1.0 - 4.0 * f64::EPSILON) {
        let to = (work.steps + 1) as f64 * h;
        let guess = WoodForces {
            nail: (2.0 * forces[1].nail - forces[0].nail).max(0.0),
            depth: (2.0 * forces[1].depth - forces[0].depth).max(0.0),
            seat: (2.0 * forces[1].seat - forces[0].seat).max(0.0),
        };
        let found = cycle.agree(&problem, wood, &motion, (guess, to), largest, &mut work)?;
        cycle.drive(&motion, &found.end, &found.free, to - cycle.t);
        cycle.advance(&problem, to, true)?;
        if cycle.run.landed {
            break;
        }
        motion = wood.accept(&found.forces)?;
        forces = [forces[1], found.forces];
        largest = largest.max(found.forces.seat).max(found.forces.nail);
        work.steps += 1;
    }
    if !cycle.run.landed {
        // Window of the last sample, whose length is practically zero.
        cycle.drive(&motion, &motion, &motion, h);
        cycle.end = work.steps as f64 * h;
    }
    Ok((cycle.finish(&problem), work))
}

/// Forces at the end of a step, and the corresponding motions.
struct Agreed {
    forces: WoodForces,
    end: WoodMotion,
    free: WoodMotion,
}

impl<'s> Cycle<'s> {
    /// Finds the forces at the end of the step to `to`, starting from a guess.
    fn agree<W: Workpiece>(
        &mut self,
        problem: &Problem<'s>,
        wood: &mut W,
        motion: &WoodMotion,
        (guess, to): (WoodForces, f64),
        largest: f64,
        work: &mut CouplingWork,
    ) -> Result<Agreed, W::Error> {
        let held = self.hold();
        let length = to - self.t;
        let mut forces = guess;
        let mut trial = 0;
        loop {
            trial += 1;
            let end = wood.trial(&forces)?;
            let compliance = wood.compliance(forces.depth);
            let given = [forces.nail, forces.seat];
            // Both motions without these forces.
            let free = |end: [f64; 2], row: usize| {
                let part = |c: &[[f64; 2]; 2]| c[row][0] * given[0] + c[row][1] * given[1];
                [end[0] - part(&compliance.position), end[1] - part(&compliance.velocity)]
            };
            let free = WoodMotion {
                nail: free(end.nail, 0),
                seat: free(end.seat, 1),
                ..end
            };
            self.drive(motion, &end, &free, length);
            self.advance(problem, to, false)?;
            let answer = self.answer();
            self.restore(&held);
            work.trials += 1;
            let rest = [answer.forces.nail - forces.nail, answer.forces.seat - forces.seat];
            let mismatch = rest[0].abs().max(rest[1].abs());
            let settled = mismatch <= AGREEMENT * largest;
            if settled || trial >= TRIALS {
                if mismatch > JUMP * largest {
                    let (time, limit) = (to, JUMP * largest);
                    return Err(CycleError::Coupling { time, mismatch, limit }.into());
                }
                work.unsettled += usize::from(!settled);
                work.mismatch = work.mismatch.max(mismatch);
                let forces = answer.forces;
                return Ok(Agreed { forces, end, free });
            }
            // (1 + K C) dF = rest
            let matrix: [[f64; 2]; 2] = std::array::from_fn(|i| {
                std::array::from_fn(|j| {
                    let own = if i == j { 1.0 } else { 0.0 };
                    own + answer.stiffness[i] * compliance.position[i][j]
                        + answer.damping[i] * compliance.velocity[i][j]
                })
            });
            let [[a, b], [c, d]] = matrix;
            let scale = if trial < DAMPED { 1.0 } else { 0.5 } / (a * d - b * c);
            forces.nail += scale * (d * rest[0] - b * rest[1]);
            forces.seat += scale * (a * rest[1] - c * rest[0]);
            forces.depth = answer.forces.depth;
        }
    }

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
