//! The built-in assembly of the N80CB has the constants of the equations that it describes.

use nailnoise_dynamics::network::assembly::{
    Action, Assembly, Base, Coefficient, ContactDamping, Edge, FastenerLaw, ForceLaw, Opens, OutcomeTest, Pick, Space,
    SpringLaw, Start,
};
use nailnoise_dynamics::network::{AssemblyText, FastenerResistance};
use nailnoise_dynamics::{Geometry, Parameters};
use nailnoise_penetration::{HeadLaw, RateLaw, ResistanceLaw};

use crate::common;
use crate::keys::keys;

fn assembly(parameters: &Parameters) -> Assembly {
    let text = AssemblyText::open_design(&[]).unwrap_or_else(|error| panic!("{error}; {}", error.help()));
    let resolved = text
        .resolve(&keys(parameters))
        .unwrap_or_else(|error| panic!("{error}; {}", error.help()));
    resolved.assembly
}

/// Whether two numbers differ by at most one unit in the last place.
fn same(a: f64, b: f64) -> bool {
    a == b || a.next_up() == b || a.next_down() == b
}

fn all_same(pairs: &[(&str, f64, f64)]) {
    for (name, found, expected) in pairs {
        assert!(same(*found, *expected), "{name}: {found:e} is not {expected:e}");
    }
}

macro_rules! named {
    ($list:expr, $name:expr) => {
        $list
            .iter()
            .find(|block| block.name == $name)
            .unwrap_or_else(|| panic!("no {}", $name))
    };
}

#[test]
fn areas_and_masses_are_those_of_the_geometry() {
    let p = common::n80cb();
    let (a, g) = (assembly(&p), Geometry::new(&p));
    let face = |name: &str| {
        a.faces
            .iter()
            .find(|face| face.name == name)
            .map_or(f64::NAN, |face| face.area)
    };
    all_same(&[
        ("A1", face("piston_top"), g.piston_area),
        ("A2", face("piston_ring"), g.ring_area),
        ("Ah1", face("valve_top"), g.valve_control_area),
        ("Ah2", face("valve_outer"), g.valve_supply_area),
        ("Ah3", face("valve_inner"), g.valve_cylinder_area),
        ("M_w", named!(a.bodies, "workpiece").mass, g.workpiece_mass),
        ("M_n", a.fasteners[0].mass, g.nail_mass),
        ("y_pbin", a.fasteners[0].head_at, g.head_gap),
        ("y_pbp", a.fasteners[0].tip_at, g.tip_gap),
    ]);
    let rod = face("piston_rod");
    assert!(
        (rod - g.rod_area).abs() < 4.0 * f64::EPSILON * g.piston_area,
        "{rod} is not {}",
        g.rod_area
    );
}

#[test]
fn stiffnesses_and_dashpots_are_those_of_the_contacts() {
    let p = common::n80cb();
    let (a, g, c) = (assembly(&p), Geometry::new(&p), &p.contacts);
    let dashpot = |name: &str| match a
        .contacts
        .iter()
        .find(|contact| contact.name == name)
        .map(|c| c.damping)
    {
        Some(ContactDamping::Dashpot(damping)) => damping,
        _ => f64::NAN,
    };
    let of = |zeta: f64, stiffness: f64, mass: f64| 2.0 * zeta * (stiffness * mass).sqrt();
    all_same(&[
        ("bumper", dashpot("bumper"), c.bumper_damping),
        (
            "cap",
            dashpot("cap"),
            of(c.valve_damping_ratio, c.cap_stiffness, p.head_valve.mass),
        ),
        (
            "seat",
            dashpot("seat"),
            of(c.valve_damping_ratio, c.seat_stiffness, p.head_valve.mass),
        ),
        (
            "nose",
            dashpot("nose"),
            of(c.nose_damping_ratio, c.nose_stiffness, p.tool.mass),
        ),
        ("guard", dashpot("guard"), 0.0),
        ("support", dashpot("support"), g.support_damping),
        (
            "k_esg",
            named!(a.contacts, "guard").stiffness,
            c.guard_stiffness * c.nose_stiffness / (c.guard_stiffness + c.nose_stiffness),
        ),
        ("k_ws", named!(a.contacts, "support").stiffness, p.support.stiffness),
        ("y_msg", named!(a.contacts, "guard").at, -c.guard_travel),
    ]);
}

#[test]
fn passages_have_their_areas_coefficients_and_delays() {
    let mut p = common::n80cb();
    // All passages but the leak have their own coefficients.
    (p.chambers.check_hole_coefficient, p.chambers.return_hole_coefficient) = (0.61, 0.62);
    (p.chambers.leak_coefficient, p.supply.hose_coefficient) = (0.0, 0.63);
    let (a, g) = (assembly(&p), Geometry::new(&p));
    let constant = |name: &str| {
        let passage = a
            .passages
            .iter()
            .find(|passage| passage.name == name)
            .unwrap_or_else(|| panic!("no {name}"));
        let last = &passage.restrictions[passage.restrictions.len() - 1];
        match (&last.opens, &last.coefficient) {
            (Opens::Constant { area } | Opens::Holes { area, .. }, Coefficient::Constant(c)) => (*area, *c),
            other => panic!("{name}: {other:?}"),
        }
    };
    let cd = p.chambers.discharge_coefficient;
    all_same(&[
        ("A_ma", constant("exhaust").0, g.exhaust_area),
        ("C_d", constant("exhaust").1, p.exhaust.coefficient(&p.chambers)),
        ("C_d of the check", constant("check").1, 0.61),
        ("C_d of the foot", constant("foot").1, 0.62),
        ("C_d of the leak", constant("leak").1, cd),
        ("C_d of the hose", constant("refill").1, 0.63),
        ("A_1r", constant("check").0, p.chambers.check_hole_area),
        ("A_2r", constant("foot").0, p.chambers.return_hole_area),
        ("A_lk2", constant("leak").0, p.chambers.leak_area),
        ("A_sup", constant("refill").0, p.supply.hose_area),
        ("phi_out", constant("vent").1, g.attenuation_vent),
        ("phi_in", constant("fill").1, g.attenuation_fill),
    ]);
    for (name, inverted) in [("vent", true), ("fill", false)] {
        let passage = a.passages.iter().find(|passage| passage.name == name);
        let gate = passage.and_then(|passage| passage.gate.as_ref());
        let gate = gate.unwrap_or_else(|| panic!("{name} has no gate"));
        assert!(same(gate.delay, g.channel_delay), "{name}: {}", gate.delay);
        assert_eq!((gate.inverted, gate.before, gate.trigger), (inverted, false, 0));
    }
    let seat = |opens: &Opens| match *opens {
        Opens::Seat {
            at, diameter, angle, ..
        } => [at, diameter, angle],
        _ => [f64::NAN; 3],
    };
    let v = &p.head_valve;
    let intake = named!(a.passages, "intake");
    assert_eq!(
        seat(&intake.restrictions[0].opens),
        [v.lift - v.intake_lap, p.piston.bore, v.intake_angle]
    );
    let exhaust = named!(a.passages, "exhaust");
    let expected = [v.lift - v.exhaust_lap, v.exhaust_seat_diameter, v.exhaust_angle];
    assert_eq!(seat(&exhaust.restrictions[0].opens), expected);
    assert_eq!((exhaust.from, exhaust.to), (Space::Volume(0), Space::Reservoir(0)));
}

#[test]
fn the_nail_meets_the_wood_of_the_keys() {
    let mut p = common::n80cb();
    p.nail.legs = 2;
    p.nail.coating = 0.7;
    p.wood.rate = RateLaw::Speed;
    p.wood.head_law = HeadLaw::Yields;
    p.wood.penetration_law = ResistanceLaw::Constant;
    (p.wood.ring_amplitude, p.wood.ring_width, p.wood.ring_seed) = (0.2, 3.5e-3, 7);
    let a = assembly(&p);
    let nail = &a.fasteners[0];
    let FastenerLaw::Wood(law) = &nail.law else {
        panic!("{:?}", nail.law)
    };
    // Properties that a constant law does not use.
    let mut expected = p.wood.clone();
    expected.quasi_static.head_stiffness_scale = 1.0;
    expected.quasi_static.unloading_stiffness = 1.0;
    (expected.quasi_static.speed_term, expected.quasi_static.slenderness_term) = (0.0, 0.0);
    expected.shear_speed = law.wood.shear_speed;
    assert_eq!(law.wood, expected);
    assert_eq!((law.legs, law.table.is_some(), law.fit.is_some()), (2, false, false));
    let w = &p.wood;
    all_same(&[
        ("D", law.diameter, p.nail.diameter),
        ("D_h", law.head_diameter, p.nail.head_diameter),
        ("M_p", law.driving_mass, p.piston.mass),
        ("phi", law.friction_share, p.friction_share),
        ("q", law.coating, 0.7),
        (
            "k_h",
            nail.seated.head_stiffness,
            w.head_stiffness_scale * w.hardness_modulus,
        ),
        ("k_u", nail.seated.unloading, w.unloading_stiffness),
    ]);
    assert!(nail.impact && !nail.reversible);
    let (own, old) = (law.envelope(nail), p.penetration_envelope());
    for depth in [0.01, 0.5, 0.999, 1.1].map(|part| part * p.nail.length) {
        assert_eq!(own.force(depth), old.force(depth), "{depth}");
    }
}

#[test]
fn keys_of_laws_that_are_not_chosen_are_not_used() {
    let used = |p: &Parameters| {
        let text = AssemblyText::open_design(&[]).unwrap_or_else(|error| panic!("{error}"));
        let resolved = text.resolve(&keys(p)).unwrap_or_else(|error| panic!("{error}"));
        resolved.keys
    };
    let mut p = common::n80cb();
    let others = [
        "wood.crushing_rate",
        "wood.head_yield_scale",
        "model.polytropic",
        "wood.penetration_force",
    ];
    let found = used(&p);
    assert!(others.iter().all(|key| !found.contains(*key)), "{found:?}");
    assert!(found.contains("wood.speed_term") && found.contains("wood.rate") && found.contains("model.gas"));
    p.wood.rate = RateLaw::Speed;
    p.wood.head_law = HeadLaw::Yields;
    p.wood.penetration_law = ResistanceLaw::Constant;
    p.model.gas = nailnoise_dynamics::Form::Published;
    let found = used(&p);
    assert!(others.iter().all(|key| found.contains(*key)), "{found:?}");
    assert!(!found.contains("wood.speed_term"));
}

#[test]
fn bodies_volumes_and_contacts_keep_the_order_of_the_states() {
    let a = assembly(&common::n80cb());
    let names = |list: Vec<&String>| list.into_iter().map(String::as_str).collect::<Vec<_>>().join(" ");
    assert_eq!(
        names(a.bodies.iter().map(|b| &b.name).collect()),
        "piston head_valve tool workpiece"
    );
    assert_eq!(
        names(a.volumes.iter().map(|b| &b.name).collect()),
        "above_piston below_piston return_volume above_valve supply"
    );
    assert_eq!(
        names(a.contacts.iter().map(|b| &b.name).collect()),
        "bumper stopper cap seat nose guard support"
    );
    let events = names(a.events.iter().map(|b| &b.name).collect());
    assert!(
        events.starts_with("t0 t1 t2") && events.contains("t12 t13 t14"),
        "{events}"
    );
    assert_eq!(a.bodies[0].parent, Base::Body(2));
    assert!(matches!(a.bodies[2].start, Start::RestOn(block) if a.contacts[block.index].name == "nose"));
}

#[test]
fn a_sprung_hand_is_a_body_and_a_force_otherwise() {
    let mut p = common::n80cb();
    p.hand.mass = 0.0;
    let names = |a: &Assembly| a.forces.iter().map(|force| force.name.clone()).collect::<Vec<_>>();
    let fixed = assembly(&p);
    assert_eq!(
        (fixed.bodies.len(), fixed.springs.len(), names(&fixed)),
        (4, 1, vec!["hand".to_owned()])
    );
    assert!(matches!(fixed.forces[0].law, ForceLaw::Constant(force) if force == p.hand.force));
    p.hand.mass = 3.0;
    p.exhaust.thrust_share = 0.5;
    let sprung = assembly(&p);
    let expected = vec!["push".to_owned(), "thrust".to_owned()];
    assert_eq!(
        (sprung.bodies.len(), sprung.springs.len(), names(&sprung)),
        (5, 2, expected)
    );
    assert_eq!(sprung.bodies[4].gravity, 0.0);
}

#[test]
fn switches_of_the_model_and_the_release_act() {
    let mut p = common::n80cb();
    assert_eq!(assembly(&p).triggers[0].schedule, []);
    p.trigger.release_after = 0.05;
    assert_eq!(assembly(&p).triggers[0].schedule, [(0.05, true)]);
    p.head_valve.spring_scale = 0.9;
    let SpringLaw::Polynomial(law) = assembly(&p).springs.swap_remove(0).law else {
        panic!("no polynomial")
    };
    assert!(same(law[1], 0.9 * 79_135.7));
    assert_eq!(assembly(&p).passages[1].restrictions.len(), 2);
    p.muffler_area = Some(120e-6);
    assert!(matches!(assembly(&p).passages[1].restrictions[2].opens, Opens::Constant { area } if area == 120e-6));
    p.model.refill = nailnoise_dynamics::Form::Published;
    assert!(!assembly(&p).passages.iter().any(|passage| passage.name == "refill"));
}

#[test]
fn published_forms_are_fields_of_blocks() {
    let a = assembly(&common::n80cb().published_all());
    let m = common::n80cb().model;
    let gas = a.polytropic.unwrap_or_else(|| panic!("no polytropic gas"));
    assert_eq!((gas.exponent, gas.inflow), (m.polytropic, m.polytropic_inflow));
    assert!(!a.faces.iter().any(|face| face.name == "valve_inner"));
    assert!(!named!(a.faces, "valve_outer").sweeps && named!(a.faces, "valve_top").sweeps);
    assert!(
        a.contacts
            .iter()
            .all(|contact| contact.may_pull || contact.name == "guard")
    );
    for name in ["intake", "exhaust", "leak", "vent", "fill"] {
        assert!(named!(a.passages, name).one_way, "{name}");
    }
    assert!(!a.passages.iter().any(|passage| passage.name == "refill"));
    let out = Some(m.polytropic_outflow);
    assert_eq!(named!(a.passages, "exhaust").exponents, [out, None]);
    assert_eq!(named!(a.passages, "intake").exponents, [None, out]);
    for (name, leaves) in [("vent", false), ("fill", true)] {
        let gate = named!(a.passages, name).gate.as_ref();
        let gate = gate.unwrap_or_else(|| panic!("{name} has no gate"));
        assert_eq!((gate.delays_flow, gate.leaves_undelayed), (true, leaves), "{name}");
    }
    assert!(a.fasteners[0].reversible && !a.fasteners[0].impact);
    let corrected = assembly(&common::n80cb());
    assert!(corrected.polytropic.is_none() && corrected.faces.iter().all(|face| face.sweeps));
}

#[test]
fn events_triggers_and_outcomes_refer_to_what_they_name() {
    let a = assembly(&common::n80cb());
    let event = |name: &str| a.events.iter().position(|event| event.name == name);
    let t11 = &a.events[event("t11").unwrap_or_default()];
    assert_eq!((t11.after, t11.until, t11.lasting), (event("t10"), event("t14"), 2e-3));
    assert!(matches!(t11.edge, Edge::Is(_)));
    let t14 = &a.events[event("t14").unwrap_or_default()];
    assert_eq!((t14.pick, t14.before), (Pick::Last, event("t15")));
    let word = a.triggers[0].set[0];
    assert_eq!(
        (a.contacts[word.block.index].name.as_str(), word.action),
        ("guard", Action::Opens)
    );
    assert_eq!(
        a.outcomes[0].test,
        OutcomeTest::Missing(event("t3").unwrap_or_default())
    );
    assert!(matches!(a.outcomes[1].test, OutcomeTest::AtEnd(_)));
    let finish = a.finish.unwrap_or_else(|| panic!("no finish"));
    assert_eq!(
        (Some(finish.event), finish.never_past),
        (event("t18"), event("landing"))
    );
}

/// Shank, tip and head of the nail at rest and at speed, with the law of the keys and that of the assembly.
#[test]
fn the_parts_of_the_nails_resistance_follow_its_speed() {
    let mut p = common::n80cb();
    p.wood.rate = RateLaw::Speed;
    let (envelope, a) = (p.penetration_envelope(), assembly(&p));
    let resistance = FastenerResistance::of(&a.fasteners[0]);
    let parts = |depth: f64, speed: f64| {
        let own = resistance.parts(depth, speed, p.friction_share);
        let of_keys = envelope.parts(depth, speed, envelope.usual_impact());
        for (own, of_keys) in own.iter().zip(of_keys) {
            assert!(
                (own - of_keys).abs() <= 1e-9 * of_keys.abs(),
                "{depth} m, {speed} m/s: {own} N, {of_keys} N"
            );
        }
        own
    };
    for depth in [
        1e-4,
        0.01,
        0.03,
        0.5 * p.nail.length,
        p.nail.length,
        p.nail.length + 1e-3,
    ] {
        let [rest, fast] = [0.0, 20.0].map(|speed| parts(depth, speed));
        assert!(fast[0] < rest[0] && fast[1] > rest[1], "{rest:?} {fast:?}");
    }
}
