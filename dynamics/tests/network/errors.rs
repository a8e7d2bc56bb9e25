//! Runs that cannot go on name the block, the place and the remedy.

use nailnoise_dynamics::network::assembly::*;
use nailnoise_dynamics::network::{Assembly, Numerics, RunError, simulate};

use crate::assembly::*;
use crate::conditions::*;

fn refused(assembly: &Assembly) -> RunError {
    simulate(assembly, &Numerics::default()).unwrap_err()
}

fn moving(speed: f64) -> Start {
    Start::At { travel: 0.0, speed }
}

fn rest_on(family: Family) -> Start {
    Start::RestOn(BlockRef { family, index: 0 })
}

fn spring(law: SpringLaw, limit: Option<f64>) -> Spring {
    Spring {
        name: "return".to_owned(),
        on: 0,
        against: Base::Ground,
        push: Push::Up,
        free: 0.0,
        preload: 0.0,
        law,
        limit,
        unilateral: false,
        damping: 0.0,
    }
}

#[test]
fn a_volume_that_vanishes_names_the_body_in_it() {
    let mut tool = empty("closed", 0.1);
    tool.bodies.push(body("piston", 2.0, moving(-20.0)));
    tool.volumes.push(volume("cushion", 1e-6, 101_325.0));
    tool.faces.push(Face {
        name: "top".to_owned(),
        gas: Space::Volume(0),
        body: 0,
        against: Base::Ground,
        push: Push::Down,
        area: 1e-3,
        zero: 0.0,
        perimeter: 0.0,
        sweeps: true,
    });
    let error = refused(&tool);
    assert!(
        matches!(&error, RunError::Collapse { volume, .. } if volume == "cushion"),
        "{error}"
    );
    let text = error.to_string();
    assert!(
        text.starts_with("volume \"cushion\" shrinks to ") && text.contains("\"piston\" at -"),
        "{text}"
    );
}

#[test]
fn a_spring_beyond_its_law_is_refused_at_its_stop_and_on_the_way() {
    let mut tool = empty("spring", 0.1);
    tool.bodies.push(body("piston", 0.1, moving(5.0)));
    tool.springs.push(spring(SpringLaw::Linear(1e3), Some(5e-3)));
    let error = refused(&tool);
    assert!(
        matches!(error, RunError::SpringLimit { limit, .. } if limit == 5e-3),
        "{error}"
    );
    tool.contacts
        .push(contact("cap", 0, Base::Ground, Stop::Below, 5.2e-3, 1e6, 0.0));
    let text = refused(&tool).to_string();
    let expected = "spring \"return\": 5.2 mm at the stop \"cap\", its law holds to 5 mm";
    assert!(text.starts_with(expected), "{text}");
}

#[test]
fn a_body_that_nothing_presses_is_not_seated() {
    let mut tool = empty("lifted", 0.1);
    tool.bodies.push(body("tool", 1.0, rest_on(Family::Contact)));
    tool.contacts
        .push(contact("nose", 0, Base::Ground, Stop::Below, 0.0, 1e6, 0.0));
    tool.springs.push(Spring {
        preload: 3e-3,
        ..spring(SpringLaw::Linear(1e3), None)
    });
    let text = refused(&tool).to_string();
    assert!(text.starts_with("nothing presses \"nose\" at rest (-3.0 N)"), "{text}");
    assert!(text.contains("\"tool\" is not seated"), "{text}");
}

/// The force is the load that is missing on the contact, whether another block catches the body or not, and includes
/// what the bodies above it carry.
#[test]
fn the_force_of_a_body_that_is_not_seated_is_its_load() {
    let mut tool = empty("pulled", 0.1);
    tool.gravity = 9.81;
    tool.bodies.push(Body {
        gravity: 9.81,
        ..body("tool", 1.0, rest_on(Family::Contact))
    });
    tool.contacts
        .push(contact("nose", 0, Base::Ground, Stop::Below, 0.0, 1e6, 0.0));
    tool.forces.push(Force {
        name: "pull".to_owned(),
        on: 0,
        against: Base::Ground,
        law: ForceLaw::Constant(-50.0),
    });
    let force = |assembly: &Assembly| match refused(assembly) {
        RunError::NotSeated { contact, body, force } => (contact, body, force),
        other => panic!("{other}"),
    };
    let (contact_name, name, load) = force(&tool);
    assert_eq!((contact_name.as_str(), name.as_str()), ("nose", "tool"));
    assert!((load - (9.81 - 50.0)).abs() < 1e-6, "{load}");
    assert!(refused(&tool).to_string().contains("(-40.2 N)"), "{}", refused(&tool));
    // A weight on top of it adds to its load.
    tool.bodies.push(Body {
        gravity: 9.81,
        start: Start::RestOn(BlockRef {
            family: Family::Contact,
            index: 1,
        }),
        ..body("weight", 2.0, moving(0.0))
    });
    tool.contacts
        .push(contact("plate", 1, Base::Body(0), Stop::Below, 0.0, 1e6, 0.0));
    let (contact_name, _, load) = force(&tool);
    assert_eq!(contact_name, "nose");
    assert!((load - (3.0 * 9.81 - 50.0)).abs() < 1e-6, "{load}");
}

#[test]
fn a_body_that_nothing_carries_finds_no_equilibrium() {
    let mut tool = empty("loose", 0.1);
    tool.bodies.push(body("arm", 1.0, rest_on(Family::Spring)));
    tool.springs.push(spring(SpringLaw::Linear(0.0), None));
    tool.forces.push(Force {
        name: "push".to_owned(),
        on: 0,
        against: Base::Ground,
        law: ForceLaw::Constant(80.0),
    });
    let error = refused(&tool);
    assert!(
        matches!(&error, RunError::NoEquilibrium { body, .. } if body == "arm"),
        "{error}"
    );
}

/// A vessel whose vent a trigger opens and shuts, heard by the trigger itself.
#[test]
fn a_trigger_and_a_gate_that_switch_each_other_are_stopped() {
    let mut tool = empty("loop", 0.1);
    tool.volumes.push(volume("vessel", 1e-3, 800e3));
    tool.passages.push(Passage {
        gate: Some(Gate {
            trigger: 0,
            inverted: false,
            delay: 0.0,
            before: false,
            delays_flow: false,
            leaves_undelayed: false,
            also: None,
        }),
        ..passage("vent", Space::Volume(0), Space::Reservoir(0), constant(1e-6))
    });
    let vent = |action| Word {
        block: BlockRef {
            family: Family::Passage,
            index: 0,
        },
        restriction: 0,
        action,
    };
    tool.triggers.push(Trigger {
        name: "released".to_owned(),
        starts: true,
        set: vec![vent(Action::GateShuts)],
        clear: vec![vent(Action::GateOpens)],
        schedule: vec![(12.3e-3, false)],
    });
    let text = refused(&tool).to_string();
    assert!(
        text.starts_with("\"released\" and \"vent\" switch each other"),
        "{text}"
    );
    assert!(
        text.contains("at 12.3 ms") && text.contains("give open.delay"),
        "{text}"
    );
    // With a delay the two alternate in time.
    tool.end = 20e-3;
    let gate = tool.passages[0].gate.as_mut().unwrap();
    (gate.delay, gate.before) = (1e-3, true);
    let record = simulate(&tool, &Numerics::default()).unwrap();
    assert_eq!(
        record
            .log
            .iter()
            .filter(|entry| entry.word.starts_with("gate "))
            .count(),
        7
    );
}

/// A ball that bounces a nanometre high without loss, at some megahertz.
#[test]
fn a_contact_that_chatters_is_stopped_by_its_name() {
    let mut tool = empty("chatter", 0.1);
    tool.bodies.push(Body {
        weights: Weights {
            position: 1e-8,
            velocity: 1e-4,
        },
        ..body(
            "ball",
            0.1,
            Start::At {
                travel: -1e-9,
                speed: 0.0,
            },
        )
    });
    tool.contacts
        .push(contact("stop", 0, Base::Ground, Stop::Below, 0.0, 1e14, 0.0));
    tool.forces.push(Force {
        name: "push".to_owned(),
        on: 0,
        against: Base::Ground,
        law: ForceLaw::Constant(2000.0),
    });
    let error = refused(&tool);
    assert!(
        matches!(&error, RunError::Chatter { block, .. } if block == "stop"),
        "{error}"
    );
}

#[test]
fn a_series_of_four_restrictions_is_refused() {
    let mut tool = empty("series", 0.1);
    tool.volumes.push(volume("vessel", 1e-3, 800e3));
    let mut pipe = passage("pipe", Space::Volume(0), Space::Reservoir(0), constant(1e-6));
    pipe.restrictions = vec![constant(1e-6); 4];
    tool.passages.push(pipe);
    let error = refused(&tool);
    assert!(
        matches!(&error, RunError::Passage { name, .. } if name == "pipe"),
        "{error}"
    );
}
