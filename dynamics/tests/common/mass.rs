//! An external workpiece with a known motion: a mass on a spring.

use std::marker::PhantomData;

use nailnoise_dynamics::{Compliance, Geometry, Parameters, WoodForces, WoodMotion, Workpiece};

/// A mass on a one-sided spring and dashpot, integrated in small steps with forces that are linear over each step of
/// the cycle, by the classical method of Runge and Kutta.
pub(crate) struct Mass<E> {
    mass: f64,
    stiffness: f64,
    damping: f64,
    gravity: f64,
    step: f64,
    /// Position, velocity and force at the start of the present step.
    state: [f64; 2],
    force: f64,
    /// Work done on it by the cycle.
    pub(crate) work: f64,
    error: PhantomData<E>,
}

const SUBSTEPS: usize = 8;

impl<E> Mass<E> {
    /// A mass on a support of stiffness and damping, for steps of `step`.
    pub(crate) fn new(mass: f64, [stiffness, damping]: [f64; 2], gravity: f64, step: f64) -> Self {
        Self {
            mass,
            stiffness,
            damping,
            gravity,
            step,
            state: [0.0; 2],
            force: 0.0,
            work: 0.0,
            error: PhantomData,
        }
    }

    fn support(&self, [y, v]: [f64; 2]) -> f64 {
        if y > 0.0 {
            (self.stiffness * y + self.damping * v).max(0.0)
        } else {
            0.0
        }
    }

    fn motion(&self, state: [f64; 2]) -> WoodMotion {
        WoodMotion {
            seat: state,
            nail: state,
            support: self.support(state),
        }
    }

    /// State at the end of the step, and the work of the forces.
    fn follow(&self, force: f64) -> ([f64; 2], f64) {
        let (mut state, mut work) = (self.state, 0.0);
        let h = self.step / SUBSTEPS as f64;
        for k in 0..SUBSTEPS {
            let applied = |s: f64| self.force + (force - self.force) * s;
            let rate = |[y, v]: [f64; 2], s: f64| [v, (applied(s) - self.support([y, v])) / self.mass + self.gravity];
            let s = k as f64 / SUBSTEPS as f64;
            let ds = 1.0 / SUBSTEPS as f64;
            let along = |a: [f64; 2], b: [f64; 2], x: f64| [a[0] + x * b[0], a[1] + x * b[1]];
            let k1 = rate(state, s);
            let k2 = rate(along(state, k1, 0.5 * h), s + 0.5 * ds);
            let k3 = rate(along(state, k2, 0.5 * h), s + 0.5 * ds);
            let k4 = rate(along(state, k3, h), s + ds);
            let next = [0, 1].map(|i| state[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
            work += 0.5 * (applied(s) + applied(s + ds)) * (next[0] - state[0]);
            state = next;
        }
        (state, work)
    }
}

impl<E> Workpiece for Mass<E> {
    type Error = E;

    fn start(&mut self, seat: f64) -> Result<WoodMotion, E> {
        self.force = seat;
        self.state = [(seat + self.mass * self.gravity) / self.stiffness, 0.0];
        Ok(self.motion(self.state))
    }

    fn compliance(&self, _depth: f64) -> Compliance {
        let h = self.step;
        Compliance {
            position: [[h * h / (6.0 * self.mass); 2]; 2],
            velocity: [[h / (2.0 * self.mass); 2]; 2],
        }
    }

    fn trial(&mut self, forces: &WoodForces) -> Result<WoodMotion, E> {
        Ok(self.motion(self.follow(forces.nail + forces.seat).0))
    }

    fn accept(&mut self, forces: &WoodForces) -> Result<WoodMotion, E> {
        let (state, work) = self.follow(forces.nail + forces.seat);
        self.state = state;
        self.work += work;
        self.force = forces.nail + forces.seat;
        Ok(self.motion(state))
    }
}

/// The lumped block of the N80CB on its support.
pub(crate) fn n80cb_block<E>(p: &Parameters, step: f64) -> Mass<E> {
    let geometry = Geometry::new(p);
    let support = [p.support.stiffness, geometry.support_damping];
    Mass::new(geometry.workpiece_mass, support, p.ambient.gravity, step)
}
