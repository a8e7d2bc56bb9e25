//! Coupling with an external workpiece: a mass on a spring in another solver must give the lumped cycle.
use std::sync::LazyLock;

use nailnoise_dynamics::{
    Compliance, CouplingWork, CycleError, CycleRecord, Geometry, Parameters, Settings, WoodForces, WoodMotion,
    Workpiece, simulate_on,
};

use crate::BASE;
use crate::common::n80cb;

/// A mass on a one-sided spring and dashpot, integrated in small steps with forces that are linear over each step of
/// the cycle: velocity Verlet with the dashpot implicit.
struct Mass {
    mass: f64,
    stiffness: f64,
    damping: f64,
    gravity: f64,
    step: f64,
    /// Position, velocity and force at the start of the present step.
    state: [f64; 2],
    force: f64,
    /// Work done on it by the cycle.
    work: f64,
}

const SUBSTEPS: usize = 8;

impl Mass {
    fn new(p: &Parameters, step: f64) -> Self {
        let geometry = Geometry::new(p);
        Self {
            mass: geometry.workpiece_mass,
            stiffness: p.support.stiffness,
            damping: geometry.support_damping,
            gravity: p.ambient.gravity,
            step,
            state: [0.0; 2],
            force: 0.0,
            work: 0.0,
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

impl Workpiece for Mass {
    type Error = CycleError;

    fn start(&mut self, seat: f64) -> Result<WoodMotion, CycleError> {
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

    fn trial(&mut self, forces: &WoodForces) -> Result<WoodMotion, CycleError> {
        Ok(self.motion(self.follow(forces.nail + forces.seat).0))
    }

    fn accept(&mut self, forces: &WoodForces) -> Result<WoodMotion, CycleError> {
        let (state, work) = self.follow(forces.nail + forces.seat);
        self.state = state;
        self.work += work;
        self.force = forces.nail + forces.seat;
        Ok(self.motion(state))
    }
}

/// Largest difference of the event times. Each must occur in both or in none.
fn apart(a: &CycleRecord, b: &CycleRecord) -> (usize, f64) {
    let mut worst = (0, 0.0);
    for (k, (a, b)) in a.events.to_array().into_iter().zip(b.events.to_array()).enumerate() {
        assert_eq!(a.is_some(), b.is_some(), "t{k}");
        let difference = a.zip(b).map_or(0.0, |(a, b)| (a - b).abs());
        if difference > worst.1 {
            worst = (k, difference);
        }
    }
    worst
}

/// The coupled cycle at the default settings, with its work and the work \[J\] that the mass received.
static COUPLED: LazyLock<(CycleRecord, CouplingWork, f64)> = LazyLock::new(|| {
    let (parameters, settings) = (n80cb(), Settings::default());
    let mut mass = Mass::new(&parameters, settings.sample_interval);
    let (record, work) = simulate_on(&parameters, &settings, &mut mass).unwrap();
    (record, work, mass.work)
});

#[test]
fn an_external_mass_on_a_spring_gives_the_lumped_cycle() {
    let coupled = &COUPLED.0;
    let (event, difference) = apart(&BASE, coupled);
    assert!(difference < 2e-6, "t{event} is {difference:e} s off");
    assert!(coupled.is_certified(), "{:?}", coupled.checks);
    let depths = (BASE.summary.penetration, coupled.summary.penetration);
    assert!((depths.0 - depths.1).abs() < 2e-7, "{depths:?}");
    assert_eq!(BASE.outcome, coupled.outcome);
}

#[test]
fn the_work_of_the_cycle_is_the_work_that_the_external_mass_receives() {
    let (coupled, _, received) = &*COUPLED;
    let done = coupled.energy.wood;
    assert!((done - received).abs() < 1e-4 * received, "{done} {received} J");
}

#[test]
fn cycle_and_external_mass_agree_on_their_forces_in_few_trials() {
    let work = &COUPLED.1;
    assert!(work.mismatch < 1e-5 && work.unsettled == 0, "{work:?}");
    assert!(work.trials < 2 * work.steps, "{work:?}");
}

#[test]
fn a_quarter_of_the_step_reduces_the_error_to_less_than_a_quarter() {
    let parameters = n80cb();
    let distance = |sample_interval: f64| {
        let settings = Settings {
            sample_interval,
            ..Settings::default()
        };
        let mut mass = Mass::new(&parameters, sample_interval);
        let (coupled, _) = simulate_on(&parameters, &settings, &mut mass).unwrap();
        // The end of the drive; later events depend on rebounds.
        let (a, b) = (BASE.events.to_array(), coupled.events.to_array());
        (a[9].unwrap() - b[9].unwrap()).abs()
    };
    let (coarse, fine) = (distance(32e-6), distance(8e-6));
    assert!(fine < 0.25 * coarse, "{coarse:e} {fine:e}");
}

/// A workpiece that retreats from a small force and returns under a large one.
struct Discontinuous(WoodMotion);

impl Workpiece for Discontinuous {
    type Error = CycleError;

    fn start(&mut self, _seat: f64) -> Result<WoodMotion, CycleError> {
        Ok(self.0)
    }

    fn compliance(&self, _depth: f64) -> Compliance {
        Compliance::default()
    }

    fn trial(&mut self, forces: &WoodForces) -> Result<WoodMotion, CycleError> {
        // No force agrees with this motion.
        let position = if forces.seat < 50.0 { -1e-5 } else { 1e-3 };
        Ok(WoodMotion {
            seat: [position, 0.0],
            nail: [position, 0.0],
            support: 0.0,
        })
    }

    fn accept(&mut self, forces: &WoodForces) -> Result<WoodMotion, CycleError> {
        self.trial(forces)
    }
}

#[test]
fn a_workpiece_without_a_consistent_force_is_an_error() {
    let found = simulate_on(
        &n80cb(),
        &Settings::default(),
        &mut Discontinuous(WoodMotion::default()),
    );
    assert!(matches!(found, Err(CycleError::Coupling { .. })), "{:?}", found.err());
}
