//! Closed forms: a vessel that empties, two vessels, a gas spring, a bumper.

use nailnoise_dynamics::network::assembly::*;
use nailnoise_dynamics::network::{Assembly, Numerics, simulate};

use crate::assembly::*;
use crate::conditions::*;
use crate::{close, run};

const VESSEL: Space = Space::Volume(0);
const OUTSIDE: Space = Space::Reservoir(0);

/// 1 l at 800 kPa that empties through C A = 20 mm2, with the times to 300 and 110 kPa.
fn blow_gun(isothermal: bool) -> Assembly {
    let mut gun = empty("blow gun", 0.6);
    gun.volumes.push(Volume {
        isothermal,
        ..volume("vessel", 1e-3, 800e3)
    });
    gun.passages.push(passage("valve", VESSEL, OUTSIDE, constant(20e-6)));
    for (name, pressure) in [("half", 300e3), ("empty", 110e3)] {
        let condition = at_most(channel(Family::Volume, 0, Quantity::Pressure), pressure);
        gun.events.push(event(name, Edge::Becomes(condition)));
    }
    gun
}

#[test]
fn a_vessel_without_heat_empties_by_the_isentropic_law() {
    let record = run(&blow_gun(false), 1e-10);
    close("300 kPa", record.event("half").unwrap(), 0.189_309_726_663_923_9, 1e-8);
    close("110 kPa", record.event("empty").unwrap(), 0.432_458_184_713_603_1, 1e-8);
}

#[test]
fn a_vessel_at_one_temperature_empties_exponentially() {
    let record = run(&blow_gun(true), 1e-11);
    close("300 kPa", record.event("half").unwrap(), 0.246_899_044_878_577_1, 1e-8);
    close("110 kPa", record.event("empty").unwrap(), 0.520_872_110_273_865_9, 1e-8);
}

#[test]
fn two_vessels_come_to_one_pressure_each_at_its_temperature() {
    let mut pair = empty("vessels", 3.0);
    pair.volumes.push(volume("first", 1e-3, 800e3));
    pair.volumes.push(Volume {
        temperature: 350.0,
        ..volume("second", 2e-3, 101_325.0)
    });
    pair.passages
        .push(passage("pipe", VESSEL, Space::Volume(1), constant(20e-6)));
    for (name, family, index, quantity) in [
        ("p1", Family::Volume, 0, Quantity::Pressure),
        ("p2", Family::Volume, 1, Quantity::Pressure),
        ("t1", Family::Volume, 0, Quantity::Temperature),
        ("t2", Family::Volume, 1, Quantity::Temperature),
        ("m1", Family::Volume, 0, Quantity::Mass),
    ] {
        pair.sensors.push(Sensor {
            name: name.to_owned(),
            value: channel(family, index, quantity),
            unit: String::new(),
        });
    }
    let numerics = Numerics {
        relative_tolerance: 1e-10,
        sample_interval: Some(0.1),
        ..Default::default()
    };
    let record = simulate(&pair, &numerics).unwrap();
    assert!(record.is_certified(), "{:#?}", record.checks);
    let last = |name: &str| *record.get(name).unwrap().last().unwrap();
    for (name, expected) in [
        ("p1", 334_216.666_666_666_7),
        ("p2", 334_216.666_666_666_7),
        ("t1", 228.447_549_168_278_1),
        ("t2", 362.296_939_987_819_15),
        ("m1", 0.005_096_641_063_559_253),
    ] {
        close(name, last(name), expected, 1e-9);
    }
}

/// 0.5 kg on 1000 mm2 between 100 cm3 at 1200 kPa and 600 kPa, from rest.
#[test]
fn a_gas_spring_turns_where_its_energy_is_back() {
    let mut spring = empty("gas spring", 0.07);
    let constant = Reservoir {
        name: "other side".to_owned(),
        pressure: 600e3,
        temperature: AMBIENT.1,
    };
    spring.reservoirs.push(constant);
    spring.volumes.push(volume("gas", 100e-6, 1200e3));
    let start = Start::At {
        travel: 0.0,
        speed: 0.0,
    };
    spring.bodies.push(body("piston", 0.5, start));
    let face = |name: &str, gas, push| Face {
        name: name.to_owned(),
        gas,
        body: 0,
        against: Base::Ground,
        push,
        area: 1000e-6,
        zero: 0.0,
        perimeter: 0.0,
        sweeps: true,
    };
    spring.faces.push(face("front", Space::Volume(0), Push::Down));
    spring.faces.push(face("back", Space::Reservoir(1), Push::Up));
    let speed = || channel(Family::Body, 0, Quantity::Speed);
    spring.events.push(event("turns", Edge::Becomes(at_most(speed(), 0.0))));
    let mut back = event("back", Edge::Becomes(compare(speed(), 0.0, true)));
    back.after = Some(0);
    spring.events.push(back);
    let numerics = Numerics {
        relative_tolerance: 1e-10,
        sample_interval: Some(0.031_669_013_933_536_96),
        ..Default::default()
    };
    let record = simulate(&spring, &numerics).unwrap();
    assert!(record.is_certified(), "{:#?}", record.checks);
    close(
        "half a period",
        record.event("turns").unwrap(),
        0.031_669_013_933_536_96,
        1e-8,
    );
    close("period", record.event("back").unwrap(), 0.063_338_027_867_073_92, 1e-8);
    close(
        "amplitude",
        record.get("piston.travel").unwrap()[1],
        0.157_502_468_606_746_22,
        1e-8,
    );
}

/// 131 g at 10 m/s onto 980 N/mm with 265 N s/m.
#[test]
fn a_bumper_gives_back_what_its_dashpot_leaves() {
    let mut bumper = empty("bumper", 2e-3);
    bumper.bodies.push(body(
        "piston",
        0.131,
        Start::At {
            travel: -1e-3,
            speed: 10.0,
        },
    ));
    bumper
        .contacts
        .push(contact("bumper", 0, Base::Ground, Stop::Below, 0.0, 980e3, 265.0));
    for (name, action) in [("hits", Action::Closes), ("leaves", Action::Opens)] {
        let word = Word {
            block: BlockRef {
                family: Family::Contact,
                index: 0,
            },
            restriction: 0,
            action,
        };
        bumper.events.push(event(name, Edge::Logged(word)));
    }
    let numerics = Numerics {
        relative_tolerance: 1e-10,
        sample_interval: Some(2e-3),
        ..Default::default()
    };
    let record = simulate(&bumper, &numerics).unwrap();
    assert!(record.is_certified(), "{:#?}", record.checks);
    let time = record.event("leaves").unwrap() - record.event("hits").unwrap();
    close("contact", time, 0.938_127_719_690_546_7e-3, 1e-7);
    let rebound = -record.get("piston.speed").unwrap().last().unwrap();
    close("rebound", rebound, 3.871_784_271_469_028, 1e-8);
    close(
        "dashpot",
        record.integral("dashpot.bumper").unwrap(),
        5.031_004_773_620_664,
        1e-8,
    );
    close(
        "spring",
        record.integral("lost.bumper").unwrap(),
        0.537_103_495_745_268,
        1e-7,
    );
}
