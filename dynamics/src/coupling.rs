//! A cycle coupled to wood. Another solver computes the motion of the wood.
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

use nailnoise_penetration::Real;

use crate::{CouplingWork, WoodForces, WoodMotion, Workpiece};

/// Tolerance on the difference between the forces of both sides, as a fraction of the largest force so far.
const AGREEMENT: f64 = 1e-9;
/// Number of trials after which forces that continue to jump are accepted unchanged.
const TRIALS: usize = 40;
/// Number of trials after which Newton steps are halved.
const DAMPED: usize = 12;
/// Jump of a force that may remain in a step, as a fraction of the largest force so far. When the tip meets the wood,
/// the force jumps to 1 % of its final value.
const JUMP: f64 = 0.05;

/// Forces on the wood at a state, with -dF/dw and -dF/dw' at the nail and the seat.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Answer {
    pub(crate) forces: WoodForces,
    pub(crate) stiffness: [f64; 2],
    pub(crate) damping: [f64; 2],
}

/// The wood over one step: its motion at the start, at the end, and at the end without the forces there.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Step {
    pub(crate) start: WoodMotion,
    pub(crate) end: WoodMotion,
    pub(crate) free: WoodMotion,
    /// Time of its end \[s\].
    pub(crate) to: f64,
}

/// A cycle whose wood moves as prescribed, step by step.
pub(crate) trait Side {
    /// Error of the cycle.
    type Error;

    /// Forces at the end of a step. The cycle remains at the start of the step.
    fn attempt(&mut self, step: &Step) -> Result<Answer, Self::Error>;

    /// Completes a step.
    fn complete(&mut self, step: &Step) -> Result<(), Self::Error>;

    /// Forces at the present state.
    fn answer(&mut self) -> Answer;

    /// End of the record, as far as known \[s\].
    fn end(&self) -> f64;

    /// Whether an event ends the record at the present step.
    fn is_cut(&self) -> bool;

    /// The error for forces that do not agree at a time \[s\]: their difference, and the largest allowed \[N\].
    fn disagreement(time: f64, mismatch: f64, limit: f64) -> Self::Error;
}

/// Advances a cycle and the wood together, from rest in steps of `h` to the end of the record. Returns the motion of
/// the wood at the end.
pub(crate) fn couple<S: Side, W: Workpiece>(
    cycle: &mut S,
    wood: &mut W,
    rest: WoodMotion,
    h: f64,
) -> Result<(WoodMotion, CouplingWork), W::Error>
where
    W::Error: From<S::Error>,
{
    let mut work = CouplingWork::default();
    let mut motion = rest;
    let mut forces = [cycle.answer().forces; 2];
    let mut largest = forces[1].seat;
    while work.steps as f64 * h < cycle.end() * (1.0 - 4.0 * f64::EPSILON) {
        let to = (work.steps + 1) as f64 * h;
        let guess = WoodForces {
            nail: (2.0 * forces[1].nail - forces[0].nail).max(0.0),
            depth: (2.0 * forces[1].depth - forces[0].depth).max(0.0),
            seat: (2.0 * forces[1].seat - forces[0].seat).max(0.0),
        };
        let (agreed, step) = agree(cycle, wood, &motion, (guess, to), largest, &mut work)?;
        cycle.complete(&step)?;
        if cycle.is_cut() {
            break;
        }
        motion = wood.accept(&agreed)?;
        forces = [forces[1], agreed];
        largest = largest.max(agreed.seat).max(agreed.nail);
        work.steps += 1;
    }
    Ok((motion, work))
}

/// Finds the forces at the end of the step to `to`, starting from a guess.
fn agree<S: Side, W: Workpiece>(
    cycle: &mut S,
    wood: &mut W,
    start: &WoodMotion,
    (guess, to): (WoodForces, f64),
    largest: f64,
    work: &mut CouplingWork,
) -> Result<(WoodForces, Step), W::Error>
where
    W::Error: From<S::Error>,
{
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
        let step = Step {
            start: *start,
            end,
            free,
            to,
        };
        let answer = cycle.attempt(&step)?;
        work.trials += 1;
        let rest = [answer.forces.nail - forces.nail, answer.forces.seat - forces.seat];
        let mismatch = rest[0].abs().max(rest[1].abs());
        let settled = mismatch <= AGREEMENT * largest;
        if settled || trial >= TRIALS {
            if mismatch > JUMP * largest {
                return Err(S::disagreement(to, mismatch, JUMP * largest).into());
            }
            work.unsettled += usize::from(!settled);
            work.mismatch = work.mismatch.max(mismatch);
            return Ok((answer.forces, step));
        }
        // (1 + K C) dF = rest
        let matrix: [[f64; 2]; 2] = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let own = if i == j { 1.0 } else { 0.0 };
                own + answer.stiffness[i] * compliance.position[i][j] + answer.damping[i] * compliance.velocity[i][j]
            })
        });
        let [[a, b], [c, d]] = matrix;
        let scale = if trial < DAMPED { 1.0 } else { 0.5 } / (a * d - b * c);
        forces.nail += scale * (d * rest[0] - b * rest[1]);
        forces.seat += scale * (a * rest[1] - c * rest[0]);
        forces.depth = answer.forces.depth;
    }
}

/// A cubic through position and velocity at both ends of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cubic([f64; 4]);

impl Cubic {
    /// w(s) = w_0 + v_0 s + (3 D - 2 v_0 - v_1) s^2/h + (v_0 + v_1 - 2 D) s^3/h^2 with D = (w_1 - w_0)/h.
    pub(crate) fn new(start: [f64; 2], end: [f64; 2], h: f64) -> Self {
        let mean = (end[0] - start[0]) / h;
        Self([
            start[0],
            start[1],
            (3.0 * mean - 2.0 * start[1] - end[1]) / h,
            (start[1] + end[1] - 2.0 * mean) / (h * h),
        ])
    }

    /// Position and velocity a time after the start of the step.
    #[inline]
    pub(crate) fn at<S: Real>(&self, clock: S) -> (S, S) {
        let c = &self.0;
        (clock.polynomial(c), clock.polynomial(&[c[1], 2.0 * c[2], 3.0 * c[3]]))
    }

    /// Acceleration a time after the start of the step.
    #[inline]
    pub(crate) fn acceleration(&self, clock: f64) -> f64 {
        2.0 * self.0[2] + 6.0 * self.0[3] * clock
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_meets_both_ends() {
        let (start, end, h) = ([1.0, -2.0], [1.5, 3.0], 0.25);
        let cubic = Cubic::new(start, end, h);
        for (clock, [position, velocity]) in [(0.0, start), (h, end)] {
            let found = cubic.at(clock);
            assert!((found.0 - position).abs() < 1e-14 && (found.1 - velocity).abs() < 1e-13);
        }
    }
}
