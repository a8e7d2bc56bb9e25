//! Coupling with an external workpiece: a mass on a spring in another solver must give the lumped cycle.
use std::sync::LazyLock;

use nailnoise_dynamics::{
    Compliance, CouplingWork, CycleError, CycleRecord, Settings, WoodForces, WoodMotion, Workpiece, simulate,
    simulate_on,
};

use crate::BASE;
use crate::common::n80cb;
use crate::mass::{Mass, n80cb_block};

/// Largest difference of the event times. Each must occur in both or in none.
fn apart(a: &CycleRecord, b: &CycleRecord) -> (usize, f64) {
    let mut worst = (0, 0.0);
    for (k, (a, b)) in a
        .figures
        .events
        .to_array()
        .into_iter()
        .zip(b.figures.events.to_array())
        .enumerate()
    {
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
    let mut mass: Mass<CycleError> = n80cb_block(&parameters, settings.sample_interval);
    let (record, work) = simulate_on(&parameters, &settings, &mut mass).unwrap();
    (record, work, mass.work)
});

#[test]
fn an_external_mass_on_a_spring_gives_the_lumped_cycle() {
    let coupled = &COUPLED.0;
    let (event, difference) = apart(&BASE, coupled);
    assert!(difference < 2e-6, "t{event} is {difference:e} s off");
    assert!(coupled.is_certified(), "{:?}", coupled.figures.checks);
    let depths = (BASE.figures.summary.penetration, coupled.figures.summary.penetration);
    assert!((depths.0 - depths.1).abs() < 2e-7, "{depths:?}");
    assert_eq!(BASE.figures.outcome, coupled.figures.outcome);
}

#[test]
fn the_work_of_the_cycle_is_the_work_that_the_external_mass_receives() {
    let (coupled, _, received) = &*COUPLED;
    let done = coupled.figures.energy.wood;
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
    // The error of the coupling alone: the integration of both contributes a hundredth of the default's.
    let settings = Settings {
        relative_tolerance: 1e-2 * Settings::default().relative_tolerance,
        ..Settings::default()
    };
    let lumped = simulate(&parameters, &settings).unwrap();
    let distance = |sample_interval: f64| {
        let settings = Settings {
            sample_interval,
            ..settings.clone()
        };
        let mut mass: Mass<CycleError> = n80cb_block(&parameters, sample_interval);
        let (coupled, _) = simulate_on(&parameters, &settings, &mut mass).unwrap();
        // The end of the drive; later events depend on rebounds.
        let (a, b) = (lumped.figures.events.to_array(), coupled.figures.events.to_array());
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
