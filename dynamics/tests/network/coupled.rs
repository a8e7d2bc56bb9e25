//! Coupling with an external workpiece: a mass on a spring in another solver
//! in place of the lumped one.

use std::sync::LazyLock;

use nailnoise_dynamics::network::assembly::*;
use nailnoise_dynamics::network::{Assembly, AssemblyText, Numerics, Record, RunError, simulate, simulate_on};
use nailnoise_dynamics::{Compliance, CouplingWork, Settings, WoodForces, WoodMotion, Workpiece};

use crate::common::n80cb;
use crate::conditions::contact;
use crate::mass::{Mass, n80cb_block};
use crate::n80cb_assembly::n80cb_assembly;

/// Index of the body on which a tool works.
fn workpiece(assembly: &Assembly) -> usize {
    assembly
        .bodies
        .iter()
        .position(|body| body.name == "workpiece")
        .unwrap()
}

/// A tool on a mass, with the work that the mass received \[J\].
struct Coupled {
    record: Record,
    work: CouplingWork,
    received: f64,
}

fn coupled(assembly: &Assembly, mass: Mass<RunError>, interval: f64) -> Coupled {
    let numerics = Numerics {
        sample_interval: Some(interval),
        ..Numerics::default()
    };
    coupled_with(assembly, mass, &numerics)
}

fn coupled_with(assembly: &Assembly, mut mass: Mass<RunError>, numerics: &Numerics) -> Coupled {
    let (record, work) = simulate_on(assembly, numerics, workpiece(assembly), &mut mass).unwrap();
    Coupled {
        record,
        work,
        received: mass.work,
    }
}

/// The lumped workpiece of an assembly on its support, in another solver.
fn lumped(assembly: &Assembly, interval: f64) -> Mass<RunError> {
    let body = workpiece(assembly);
    let support = assembly.contacts.iter().find(|own| own.name == "support").unwrap();
    let ContactDamping::Dashpot(damping) = support.damping else {
        panic!("{support:?}")
    };
    let own = &assembly.bodies[body];
    Mass::new(own.mass, [support.stiffness, damping], own.gravity, interval)
}

fn n80cb_tool() -> Assembly {
    let settings = Settings::default();
    n80cb_assembly(&n80cb(), settings.end, settings.tail)
}

fn stapler() -> Assembly {
    let text = AssemblyText::built_in("stapler").unwrap().unwrap();
    text.resolve(&std::collections::BTreeMap::new()).unwrap().assembly
}

static N80CB: LazyLock<Coupled> = LazyLock::new(|| {
    let interval = Settings::default().sample_interval;
    coupled(&n80cb_tool(), n80cb_block(&n80cb(), interval), interval)
});

static STAPLER: LazyLock<Coupled> = LazyLock::new(|| {
    let tool = stapler();
    coupled(&tool, lumped(&tool, 4e-6), 4e-6)
});

#[test]
fn the_work_of_the_coupling_is_that_of_the_workpiece() {
    let Coupled { record, received, .. } = &*N80CB;
    let done = record.integral("coupling.workpiece").unwrap();
    assert!((done - received).abs() < 1e-4 * received, "{done} {received} J");
    assert!(record.is_certified(), "{:#?}", record.checks);
    let of_stapler = STAPLER.record.integral("coupling.workpiece").unwrap();
    let size = STAPLER.record.integral("work.piston").unwrap();
    assert!(
        (of_stapler - STAPLER.received).abs() < 1e-4 * size,
        "{of_stapler} {} J of {size} J",
        STAPLER.received
    );
}

#[test]
fn both_sides_agree_on_their_forces_in_few_trials() {
    for Coupled { work, .. } in [&*N80CB, &*STAPLER] {
        assert!(work.mismatch < 1e-5 && work.unsettled == 0, "{work:?}");
        assert!(work.trials < 2 * work.steps, "{work:?}");
    }
}

#[test]
fn an_external_mass_on_a_spring_gives_the_assembly_with_its_lumped_workpiece() {
    let n80cb: &[&str] = &["support", "nose", "bumper"];
    for (tool, coupled, peaks) in [
        (n80cb_tool(), &*N80CB, n80cb),
        (stapler(), &*STAPLER, &["staple", "bumper"]),
    ] {
        let one_way = simulate(&tool, &Numerics::default()).unwrap();
        for (one, two) in one_way.events.iter().zip(&coupled.record.events) {
            assert_eq!(one.time.is_some(), two.time.is_some(), "{} of {}", one.name, tool.name);
            let apart = one.time.zip(two.time).map_or(0.0, |(one, two)| (one - two).abs());
            // The stapler bounces on the workpiece before its piston is back. Each landing within a step changes the
            // impulse on the workpiece by up to half the step times the force with which the dashpot begins.
            let limit = if one.name == "returned" { 20e-6 } else { 2e-6 };
            assert!(apart < limit, "{} of {} is {apart:e} s off", one.name, tool.name);
        }
        assert_eq!(one_way.outcome, coupled.record.outcome);
        assert!(coupled.record.is_certified(), "{:#?}", coupled.record.checks);
        for block in peaks {
            let (one, two) = (one_way.peak(block).unwrap(), coupled.record.peak(block).unwrap());
            assert!(
                (one - two).abs() < 2e-3 * one,
                "{block} of {}: {one} {two} N",
                tool.name
            );
        }
    }
}

#[test]
fn a_quarter_of_the_step_reduces_the_error_to_less_than_a_quarter() {
    let tool = n80cb_tool();
    // The error of the coupling alone: that of the integration is a hundredth of the default's.
    let numerics = Numerics {
        relative_tolerance: 1e-2 * Numerics::default().relative_tolerance,
        ..Numerics::default()
    };
    let lumped_t9 = simulate(&tool, &numerics).unwrap().event("t9").unwrap();
    let distance = |interval: f64| {
        let numerics = Numerics {
            sample_interval: Some(interval),
            ..numerics
        };
        let found = coupled_with(&tool, n80cb_block(&n80cb(), interval), &numerics);
        (found.record.event("t9").unwrap() - lumped_t9).abs()
    };
    let (coarse, fine) = (distance(32e-6), distance(8e-6));
    assert!(fine < 0.25 * coarse, "{coarse:e} {fine:e}");
}

/// A workpiece that retreats from a small force and returns under a large one.
struct Discontinuous;

impl Workpiece for Discontinuous {
    type Error = RunError;

    fn start(&mut self, _seat: f64) -> Result<WoodMotion, RunError> {
        Ok(WoodMotion::default())
    }

    fn compliance(&self, _depth: f64) -> Compliance {
        Compliance::default()
    }

    fn trial(&mut self, forces: &WoodForces) -> Result<WoodMotion, RunError> {
        // No force agrees with this motion.
        let position = if forces.seat < 50.0 { -1e-5 } else { 1e-3 };
        Ok(WoodMotion {
            seat: [position, 0.0],
            nail: [position, 0.0],
            support: 0.0,
        })
    }

    fn accept(&mut self, forces: &WoodForces) -> Result<WoodMotion, RunError> {
        self.trial(forces)
    }
}

fn refused(assembly: &Assembly, body: usize, numerics: &Numerics) -> RunError {
    simulate_on(assembly, numerics, body, &mut Discontinuous).unwrap_err()
}

#[test]
fn a_workpiece_without_a_consistent_force_is_an_error() {
    let tool = n80cb_tool();
    let found = refused(&tool, workpiece(&tool), &Numerics::default());
    assert!(matches!(found, RunError::Coupling { .. }), "{found}");
}

#[test]
fn bodies_that_no_structure_can_replace_are_refused_by_name() {
    let tool = n80cb_tool();
    for (body, name) in [(0, "piston"), (1, "head_valve"), (99, "")] {
        let found = refused(&tool, body, &Numerics::default());
        assert!(
            matches!(&found, RunError::Workpiece { body, .. } if body == name),
            "{found}"
        );
    }
    let mut driver = stapler();
    driver.bodies[0].parent = Base::Ground;
    let text = refused(&driver, 0, &Numerics::default()).to_string();
    assert!(text.contains("\"piston\" drives a fastener"), "{text}");
    let unsampled = Numerics {
        sample_interval: None,
        ..Numerics::default()
    };
    let found = refused(&tool, workpiece(&tool), &unsampled);
    assert!(
        matches!(
            found,
            RunError::Value {
                name: "sample_interval",
                ..
            }
        ),
        "{found}"
    );
}

/// A block of 1 kg on a workpiece that a spring ties to the ground: the workpiece and its support are the mass's.
#[test]
fn a_tool_that_a_spring_also_holds_to_the_ground_finds_its_rest() {
    let mut tool = crate::assembly::empty("held", 2e-3);
    tool.gravity = 9.81;
    let rest = |family, index| Start::RestOn(BlockRef { family, index });
    for (name, mass, start) in [
        ("block", 1.0, rest(Family::Contact, 0)),
        ("workpiece", 2.0, rest(Family::Spring, 0)),
    ] {
        tool.bodies.push(Body {
            gravity: 9.81,
            ..crate::assembly::body(name, mass, start)
        });
    }
    tool.contacts
        .push(contact("nose", 0, Base::Body(1), Stop::Below, 0.0, 1e6, 10.0));
    for (name, on, stiffness) in [("support", 1, 1e5), ("strap", 0, 2e4)] {
        tool.springs.push(Spring {
            name: name.to_owned(),
            on,
            against: Base::Ground,
            push: Push::Up,
            free: 0.0,
            preload: 0.0,
            law: SpringLaw::Linear(stiffness),
            limit: None,
            unilateral: false,
            damping: 0.0,
        });
    }
    let found = coupled(&tool, Mass::new(2.0, [1e5, 0.0], 9.81, 4e-6), 4e-6);
    // k_s y_w = (m_w + m) g - k_b y and k_n (y - y_w) = m g - k_b y
    let (weight, all) = (9.81, 3.0 * 9.81);
    let block = (weight / 1e6 + all / 1e5) / (1.0 + 2e4 / 1e6 + 2e4 / 1e5);
    let support = all - 2e4 * block;
    for (name, expected) in [
        ("block.position", block),
        ("workpiece.position", support / 1e5),
        ("support.force", -support),
    ] {
        let history = found.record.get(name).unwrap();
        let last = history.len() - 1;
        for value in [history[0], history[last]] {
            assert!((value / expected - 1.0).abs() < 1e-6, "{name}: {value} {expected}");
        }
    }
}
