//! Laws of single blocks: sticking friction, a curved contact, a table of force, the words of the log.

use nailnoise_dynamics::Method;
use nailnoise_dynamics::network::assembly::*;
use nailnoise_dynamics::network::{Assembly, Numerics, Record, simulate};

use crate::assembly::*;
use crate::close;
use crate::conditions::*;

fn sampled(assembly: &Assembly) -> Record {
    let numerics = Numerics {
        relative_tolerance: 1e-9,
        sample_interval: Some(1e-4),
        ..Numerics::default()
    };
    let record = simulate(assembly, &numerics).unwrap();
    assert!(record.is_certified(), "{:#?}", record.checks);
    record
}

fn force(law: ForceLaw) -> Force {
    Force {
        name: "push".to_owned(),
        on: 0,
        against: Base::Ground,
        law,
    }
}

const REST: Start = Start::At {
    travel: 0.0,
    speed: 0.0,
};

/// A sledge of 1 kg that is pushed with a force growing by 100 N/s against 5 N of static and 3 N of sliding friction.
#[test]
fn a_sledge_sticks_until_the_push_exceeds_the_static_friction() {
    let mut sledge = empty("sledge", 0.1);
    sledge.bodies.push(body("sledge", 1.0, REST));
    sledge
        .forces
        .push(force(ForceLaw::Table(vec![[0.0, 0.0], [0.2, 20.0]])));
    sledge.frictions.push(Friction {
        name: "ground_friction".to_owned(),
        on: 0,
        against: Base::Ground,
        static_force: 5.0,
        sliding_force: 3.0,
        viscous: 0.0,
        width: 1e-3,
        stribeck: 1e-6,
        stick: Some((1e6, 1e3)),
    });
    // Its motion is a polynomial, which the method follows with steps too long for the integrals of the audit.
    let numerics = Numerics {
        sample_interval: Some(1e-4),
        ..Numerics::default()
    };
    let record = simulate(&sledge, &numerics).unwrap();
    let slips: Vec<f64> = record
        .log
        .iter()
        .filter(|entry| entry.word == "slips")
        .map(|entry| entry.time)
        .collect();
    assert_eq!(slips.len(), 1);
    // The dashpot's force, c F'/k = 0.1 N, is part of the friction: it slips when the push reaches 5 N.
    close("slips", slips[0], 0.05, 1e-3);
    // v = int (100 t - 3) dt from 0.05 to 0.1 s
    let speed = *record.get("sledge.speed").unwrap().last().unwrap();
    close("speed", speed, 0.375 - 0.15, 1e-3);
    assert!(record.get("sledge.travel").unwrap()[400] < 1e-5, "it holds before");
}

/// A ball of 0.1 kg with 1 m/s on f = k u^1.5: the overlap reaches (5/4 m v^2/k)^(2/5) and the ball leaves with 1 m/s.
#[test]
fn a_curved_contact_stores_the_energy_of_its_law() {
    let mut ball = empty("ball", 4e-3);
    let start = Start::At {
        travel: -0.1e-3,
        speed: 1.0,
    };
    ball.bodies.push(body("ball", 0.1, start));
    ball.contacts.push(Contact {
        exponent: 1.5,
        ..contact("plate", 0, Base::Ground, Stop::Below, 0.0, 1e8, 0.0)
    });
    let record = sampled(&ball);
    let deepest: f64 = (1.25 * 0.1 / 1e8_f64).powf(0.4);
    close("push", record.peak("plate").unwrap(), 1e8 * deepest.powf(1.5), 1e-4);
    close(
        "rebound",
        *record.get("ball.speed").unwrap().last().unwrap(),
        -1.0,
        1e-6,
    );
    let words: Vec<&str> = record.log.iter().map(|entry| entry.word).collect();
    assert_eq!(words, ["closes", "reverses", "opens"]);
}

/// Restitution of a contact after Hunt and Crossley is 1 - a v for small a v.
#[test]
fn a_hysteretic_contact_loses_speed_in_proportion_to_the_impact() {
    let mut ball = empty("ball", 4e-3);
    let start = Start::At {
        travel: -0.1e-3,
        speed: 1.0,
    };
    ball.bodies.push(body("ball", 0.1, start));
    ball.contacts.push(Contact {
        exponent: 1.5,
        damping: ContactDamping::HuntCrossley(0.01),
        ..contact("plate", 0, Base::Ground, Stop::Below, 0.0, 1e8, 0.0)
    });
    let record = sampled(&ball);
    let rebound = -*record.get("ball.speed").unwrap().last().unwrap();
    assert!((rebound - 0.99).abs() < 2e-4, "{rebound}");
    assert!(record.integral("dashpot.plate").unwrap() > 0.0);
}

/// A constant force presses a valve against a stiff cap, from which it rebounds. The coefficient of restitution of a
/// linear contact does not depend on the speed. Flights therefore shorten by a constant factor, even below the step
/// size.
#[test]
fn restitution_is_constant_at_every_tolerance() {
    const LIFT: f64 = 0.1;
    let (mass, stiffness) = (0.034, 3.5e11_f64);
    for tolerance in [1e-4, 1e-5, 1e-6, 1e-7] {
        let mut valve = empty("valve", 8e-3);
        let start = Start::At {
            travel: LIFT - 1e-3,
            speed: 0.0,
        };
        valve.bodies.push(Body {
            gravity: 7.7e3,
            ..body("valve", mass, start)
        });
        let damping = 2.0 * 0.29 * (stiffness * mass).sqrt();
        let cap = contact("cap", 0, Base::Ground, Stop::Below, LIFT, stiffness, damping);
        valve.contacts.push(cap);
        let numerics = Numerics {
            relative_tolerance: tolerance,
            sample_interval: None,
            ..Numerics::default()
        };
        let record = simulate(&valve, &numerics).unwrap();
        let times = |word: &str| -> Vec<f64> {
            let entries = record.log.iter().filter(|entry| entry.word == word);
            entries.map(|entry| entry.time).collect()
        };
        let (closes, opens) = (times("closes"), times("opens"));
        let flights: Vec<f64> = opens.iter().zip(&closes[1..]).map(|(from, to)| to - from).collect();
        assert!((5..12).contains(&flights.len()), "{tolerance}: {flights:?}");
        for pair in flights.windows(2) {
            assert!(pair[1] < 0.6 * pair[0], "{tolerance}: {flights:?}");
        }
    }
}

/// Balls that fall on a damped plate from many heights, where rounding decides which is located first: the contact or
/// the event that ends the record.
#[test]
fn a_record_that_ends_with_a_landing_contains_no_force_of_it() {
    let numerics = |method| Numerics {
        method,
        sample_interval: Some(2e-6),
        ..Numerics::default()
    };
    for (method, k) in [Method::Switching, Method::Bdf, Method::Esdirk34]
        .into_iter()
        .flat_map(|method| (1..=60).map(move |k| (method, f64::from(k))))
    {
        let (height, speed) = (1e-5 * k, 0.05 * k);
        let mut ball = empty("ball", 1.0);
        let start = Start::At { travel: -height, speed };
        ball.bodies.push(Body {
            gravity: 9.81,
            ..body("ball", 0.1, start)
        });
        let plate = contact("plate", 0, Base::Ground, Stop::Below, 0.0, 1e8, 1e3);
        ball.contacts.push(plate);
        let travel = channel(Family::Body, 0, Quantity::Travel);
        ball.events
            .push(event("landing", Edge::Becomes(compare(travel, 0.0, true))));
        ball.finish = Some(Finish {
            event: 0,
            tail: 0.5,
            never_past: Some(0),
        });
        let record = simulate(&ball, &numerics(method)).unwrap();
        let fall = ((speed * speed + 2.0 * 9.81 * height).sqrt() - speed) / 9.81;
        close("end", record.end, fall, 1e-4);
        assert_eq!(record.peak("plate"), Some(0.0), "{method:?} {k}");
        assert!(record.get("plate.force").unwrap().iter().all(|force| *force == 0.0));
    }
}

#[test]
fn a_flow_unchokes_at_the_critical_ratio() {
    let mut vessel = empty("vessel", 0.3);
    vessel.volumes.push(volume("vessel", 1e-3, 800e3));
    vessel
        .passages
        .push(passage("valve", Space::Volume(0), Space::Reservoir(0), constant(20e-6)));
    let record = sampled(&vessel);
    let entry = record.log.iter().find(|entry| entry.word == "unchoked").unwrap();
    let critical = (2.0f64 / 2.4).powf(3.5);
    let pressure = record.get("vessel.pressure").unwrap();
    let sample = (entry.time / 1e-4) as usize;
    assert!(pressure[sample] > 101_325.0 / critical && pressure[sample + 1] < 101_325.0 / critical);
}
