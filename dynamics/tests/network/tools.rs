//! The built-in tools against the values of an independent integration and of measurements.

use std::collections::BTreeMap;

use nailnoise_dynamics::network::assembly::*;
use nailnoise_dynamics::network::{Assembly, AssemblyText, BUILT_IN, KeyValue, Numerics, Record, simulate};

use crate::assembly::{body, empty, volume};
use crate::common::n80cb;
use crate::conditions::{channel, compare, contact, event};
use crate::{close, n80cb_assembly, run};

/// A built-in assembly with its own keys, or those of the base design.
fn built_in(name: &str) -> Assembly {
    let text = AssemblyText::built_in(name).unwrap().unwrap();
    let keys: BTreeMap<String, KeyValue> = if name.starts_with("n80cb") {
        n80cb_assembly::keys::keys(&n80cb())
    } else {
        BTreeMap::new()
    };
    text.resolve(&keys).unwrap().assembly
}

fn sampled(assembly: &Assembly, interval: f64) -> Record {
    let numerics = Numerics {
        relative_tolerance: 1e-9,
        sample_interval: Some(interval),
        ..Numerics::default()
    };
    simulate(assembly, &numerics).unwrap()
}

/// Value of a channel at a time, linear between its samples.
fn at(record: &Record, channel: &str, time: f64) -> f64 {
    let position = time / record.interval.unwrap();
    let (left, part) = (position as usize, position.fract());
    let values = record.get(channel).unwrap();
    values[left] + part * (values[left + 1] - values[left])
}

#[test]
fn all_built_in_tools_run_with_everything_conserved() {
    // The plunger of the spring gun closes its tube at the end of its stroke, which ends a run with an error.
    for (name, _) in BUILT_IN.iter().filter(|(name, _)| *name != "air_gun_spring") {
        let record = run(&built_in(name), 1e-7);
        assert!(record.end > 0.0, "{name}");
    }
}

#[test]
fn a_gas_spring_nailer_strikes_and_is_lifted_at_the_times_of_an_independent_integration() {
    let mut tool = built_in("gas_spring_nailer");
    tool.ledger = Ledger::Full;
    let record = sampled(&tool, 10e-6);
    assert!(record.is_certified(), "{:#?}", record.checks);
    for (name, expected, tolerance) in [
        ("t0", 0.005, 1e-12),
        ("strike", 0.007_931_118_056_575_1, 1e-8),
        ("stop", 0.010_746_686_646_366_075, 1e-7),
        ("bumper_hit", 0.010_383_705_085_897_33, 1e-7),
        ("lifted", 0.376_814_767_478_899_6, 1e-6),
    ] {
        let found = record.event(name).unwrap();
        println!("{name} {found} {expected} {:e}", found - expected);
        assert!(
            (found - expected).abs() < tolerance,
            "{name}: {found} instead of {expected}"
        );
    }
    close("strike", record.strikes[0].before, 21.837_577_734_834_568, 1e-7);
    close("driver", record.strikes[0].after, 21.642_792_601_421_77, 1e-7);
    // Peaks of the other integration are those of its steps.
    close("bumper", record.peak("bumper").unwrap(), 5_245.151_823_667_247, 1e-3);
    close("nail", record.peak("nail").unwrap(), 1_355.295_418_903_701, 1e-3);
    let peak = |name: &str| record.get(name).unwrap().iter().copied().fold(0.0, f64::max);
    close("breather", peak("breather.mass_flow"), 0.021_181_327_836_486_328, 1e-4);
    close("below", peak("below.pressure"), 114_182.722_830_110_52, 1e-5);
    for (name, expected) in [
        ("friction.seal", 3.012_234_044_477_838),
        ("work.lifter", 59.807_795_957_640_99),
        ("penetration.nail", 31.663_800_784_215_06),
        ("dashpot.bumper", 16.448_575_507_328_663),
        ("lost.latch", 0.073_032_798_961_103_62),
        ("lost.bumper", 1.175_436_358_445_976),
    ] {
        close(name, record.integral(name).unwrap(), expected, 1e-3);
    }
}

/// Piston of the gas-spring nailer alone: no friction, no wall, no tool that gives way.
#[test]
fn a_gas_spring_gives_its_work_to_the_piston() {
    let tool = built_in("gas_spring_nailer");
    let piston = tool.bodies.iter().find(|body| body.name == "piston").unwrap();
    let gas = &tool.volumes[0];
    let mut alone = empty("gas spring", 12e-3);
    let stopper = Start::RestOn(BlockRef {
        family: Family::Contact,
        index: 0,
    });
    alone.bodies.push(body("piston", piston.mass, stopper));
    alone.volumes.push(volume("gas", gas.dead, gas.pressure));
    for (face, gas) in tool.faces.iter().zip([Space::Volume(0), Space::Reservoir(0)]) {
        alone.faces.push(Face {
            gas,
            body: 0,
            against: Base::Ground,
            perimeter: 0.0,
            sweeps: true,
            zero: 0.0,
            ..face.clone()
        });
    }
    alone
        .contacts
        .push(contact("stopper", 0, Base::Ground, Stop::Above, -0.5e-3, 2e6, 0.0));
    alone.triggers = tool.triggers[..1].to_vec();
    alone.triggers[0].set.clear();
    alone.holds.push(Hold {
        on: 0,
        against: Base::Ground,
        ..tool.holds[0].clone()
    });
    let travel = channel(Family::Body, 0, Quantity::Travel);
    let there = compare(travel, 35e-3, true);
    alone.events.push(event("strike", Edge::Becomes(there)));
    let record = sampled(&alone, 1e-6);
    assert!(record.is_certified(), "{:#?}", record.checks);
    close(
        "latch",
        record.get("piston.travel").unwrap()[0],
        0.000_170_722_267_210_049_63,
        1e-9,
    );
    let time = record.event("strike").unwrap();
    close("speed", at(&record, "piston.speed", time), 22.399_703_590_341_53, 1e-7);
    close("gas", at(&record, "gas.pressure", time), 962_152.967_220_914_6, 1e-7);
}

#[test]
fn a_valve_air_gun_shoots_as_measured_where_it_was_fitted() {
    // Gauge pressures of 30 and 60 psi; the second is the measured speed that the valve's diameter was fitted to.
    for (gauge, expected) in [(206.84e3, 21.64), (413.69e3, 48.331)] {
        let mut gun = built_in("air_gun_valve");
        gun.volumes[0].pressure = 101.35e3 + gauge;
        let record = sampled(&gun, 1e-6);
        let speed = at(&record, "projectile.speed", record.event("muzzle").unwrap());
        assert!((speed - expected).abs() < 0.01, "{gauge} Pa: {speed} m/s");
    }
}

/// A nail that the wood pushes back moves with the projectile. By the rule of the nailing cycle, the projectile leaves
/// it at the reversal and takes all of the force.
#[test]
fn a_projectile_rebounds_with_the_mass_of_a_nail_that_is_pushed_against_it() {
    let mut rig = built_in("impact_rig");
    rig.end = 35e-3;
    let gravity = rig.gravity;
    let (projectile, nail) = (rig.bodies[1].mass, rig.fasteners[0].mass);
    let unloading = rig.fasteners[0].seated.unloading;
    let mut rebounds = [(true, projectile + nail), (false, projectile)].map(|(unloaded, mass)| {
        rig.fasteners[0].leaves_unloaded = unloaded;
        let record = sampled(&rig, 1e-6);
        let force = record.peak("nail").unwrap();
        let swing = force * force / (unloading * mass) - 2.0 * gravity * force / unloading;
        let velocity = record.get("projectile.velocity").unwrap();
        let rebound = -velocity.iter().copied().fold(0.0, f64::min);
        assert!(
            (rebound / swing.sqrt() - 1.0).abs() < 1e-4,
            "{rebound} {}",
            swing.sqrt()
        );
        assert!(record.is_certified(), "{:?}", record.checks);
        rebound
    });
    rebounds.sort_by(f64::total_cmp);
    assert!(rebounds[1] > 1.02 * rebounds[0], "{rebounds:?}");
}
