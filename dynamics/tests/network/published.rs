//! Laws of the published forms: a polytropic gas, a face that sweeps no volume, a delayed flow, the words of a trigger.

use nailnoise_dynamics::network::assembly::*;
use nailnoise_dynamics::network::{Assembly, Numerics, Record, simulate};

use crate::assembly::*;
use crate::close;
use crate::conditions::*;

/// Delay of the gate \[s\].
const DELAY: f64 = 1e-3;
/// Samples per delay.
const PER_DELAY: usize = 100;

fn run(assembly: &Assembly) -> Record {
    let numerics = Numerics {
        relative_tolerance: 1e-9,
        sample_interval: Some(DELAY / PER_DELAY as f64),
        ..Numerics::default()
    };
    let record = simulate(assembly, &numerics).unwrap();
    assert!(record.is_certified(), "{:#?}", record.checks);
    record
}

/// A body that compresses a closed volume.
fn cushion(sweeps: bool) -> Assembly {
    let mut tool = empty("cushion", 5e-3);
    let start = Start::At {
        travel: 0.0,
        speed: -10.0,
    };
    tool.bodies.push(body("piston", 0.2, start));
    tool.volumes.push(volume("gas", 100e-6, 200e3));
    tool.faces.push(Face {
        name: "front".to_owned(),
        gas: Space::Volume(0),
        body: 0,
        against: Base::Ground,
        push: Push::Down,
        area: 1e-3,
        zero: 0.0,
        perimeter: 0.0,
        sweeps,
    });
    tool
}

#[test]
fn a_polytropic_gas_keeps_its_temperature_and_the_power_of_its_volume() {
    let mut tool = cushion(true);
    tool.polytropic = Some(Polytropic {
        exponent: 1.2,
        inflow: 1.1,
        temperature: 290.0,
    });
    let record = run(&tool);
    let [pressure, travel] = ["gas.pressure", "piston.travel"].map(|name| record.get(name).unwrap());
    let volume: Vec<f64> = travel.iter().map(|x| 100e-6 + 1e-3 * x).collect();
    let least = volume.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(least < 0.7 * volume[0], "{least}");
    for (p, v) in pressure.iter().zip(&volume) {
        close("P V^1.2", p * v.powf(1.2), pressure[0] * volume[0].powf(1.2), 1e-7);
    }
    assert!(record.get("gas.temperature").unwrap().iter().all(|t| *t == 290.0));
}

#[test]
fn a_face_that_sweeps_no_volume_pushes_with_a_constant_force() {
    let record = run(&cushion(false));
    let pressure = record.get("gas.pressure").unwrap();
    assert!(pressure.iter().all(|p| *p == pressure[0]));
    let speed = record.get("piston.velocity").unwrap();
    let last = speed.len() - 1;
    let end = last as f64 * DELAY / PER_DELAY as f64;
    close("speed", speed[last], -10.0 + 200.0 / 0.2 * end, 1e-9);
    let travel = record.get("piston.travel").unwrap()[last];
    close("work", record.integral("unswept.front").unwrap(), 200.0 * travel, 1e-9);
}

/// A vessel with a vent behind a channel with a delay.
fn vented(delays_flow: bool, leaves_undelayed: bool) -> Assembly {
    let mut tool = empty("vented", 5.0 * DELAY);
    tool.volumes.push(volume("vessel", 1e-4, 800e3));
    let half = restriction(Opens::Constant { area: 20e-6 }, Coefficient::Constant(0.5));
    tool.passages.push(Passage {
        gate: Some(Gate {
            trigger: 0,
            inverted: false,
            delay: DELAY,
            before: false,
            delays_flow,
            leaves_undelayed,
            also: None,
        }),
        ..passage("vent", Space::Volume(0), Space::Reservoir(0), half)
    });
    tool.triggers.push(Trigger {
        name: "pulled".to_owned(),
        starts: false,
        set: Vec::new(),
        clear: Vec::new(),
        schedule: vec![(DELAY, true)],
    });
    tool
}

#[test]
fn a_delayed_flow_arrives_as_it_entered_one_delay_earlier() {
    let record = run(&vented(true, false));
    let flow = record.get("vent.mass_flow").unwrap();
    let pressure = record.get("vessel.pressure").unwrap();
    let open = 2 * PER_DELAY;
    assert!(flow[..open].iter().all(|flow| *flow == 0.0));
    assert!(pressure[..open].iter().all(|own| *own == pressure[0]));
    // For one delay it is the choked flow of the full vessel, and then that of the vessel one delay earlier.
    let k = (1.4f64 / 287.05 * (1.0f64 / 1.2).powi(6)).sqrt();
    let full = 0.5 * 20e-6 * k * 800e3 / AMBIENT.1.sqrt();
    for flow in &flow[open + 1..3 * PER_DELAY] {
        close("flow", *flow, full, 1e-6);
    }
    let temperature = record.get("vessel.temperature").unwrap();
    for i in 3 * PER_DELAY + 1..flow.len() {
        let [p, t] = [pressure, temperature].map(|history| history[i - PER_DELAY]);
        close("late flow", flow[i], full * (p / 800e3) * (AMBIENT.1 / t).sqrt(), 1e-5);
    }
}

#[test]
fn gas_that_leaves_undelayed_leaves_with_the_trigger_and_without_the_coefficient() {
    let record = run(&vented(false, true));
    let [mass, flow] = ["vessel.mass", "vent.mass_flow"].map(|name| record.get(name).unwrap());
    assert!(mass[..=PER_DELAY].iter().all(|own| *own == mass[0]));
    assert!(flow[..2 * PER_DELAY].iter().all(|flow| *flow == 0.0));
    let interval = DELAY / PER_DELAY as f64;
    for i in 2 * PER_DELAY + 1..flow.len() - 1 {
        let lost = (mass[i - 1] - mass[i + 1]) / (2.0 * interval);
        close("loss", lost, 2.0 * flow[i], 1e-4);
    }
    assert!(record.checks.iter().all(|check| !check.name.contains("mass balance")));
}

#[test]
fn a_trigger_logs_what_it_does_and_events_follow_it() {
    let mut tool = vented(false, false);
    tool.triggers[0].schedule.push((3.0 * DELAY, false));
    for (name, action) in [("on", Action::SwitchesOn), ("off", Action::SwitchesOff)] {
        let block = BlockRef {
            family: Family::Trigger,
            index: 0,
        };
        let word = Word {
            block,
            restriction: 0,
            action,
        };
        tool.events.push(event(name, Edge::Logged(word)));
    }
    let record = run(&tool);
    close("on", record.event("on").unwrap(), DELAY, 1e-9);
    close("off", record.event("off").unwrap(), 3.0 * DELAY, 1e-9);
    let words = record.log.iter().filter(|entry| entry.block == "pulled");
    assert_eq!(
        words.map(|entry| entry.word).collect::<Vec<_>>(),
        ["switches on", "switches off"]
    );
}
