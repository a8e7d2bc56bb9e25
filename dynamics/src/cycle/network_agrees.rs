//! Checks that the N80CB as a network has the same rates and Jacobian as the fixed cycle, at random states and modes.
#![allow(clippy::unwrap_used)]

use super::history::Past;
use super::mode::{Channel, Contact, Mode, NailState, Penetration};
use super::start::start;
use super::state::*;
use super::system::System;
use crate::common::n80cb;
use crate::n80cb_assembly::n80cb_assembly;
use crate::network::jacobian::Jacobian;
use crate::network::mode::{Mode as Switches, depth, head};
use crate::network::plan::Plan;
use crate::network::rates::Workspace;
use nailnoise_penetration::Dual;

/// Number of bodies in the network; the fixed cycle has the hand as a fifth.
const NETWORK_BODIES: usize = 4;

struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * ((self.0 >> 11) as f64 / (1u64 << 53) as f64)
    }

    fn coin(&mut self) -> bool {
        self.between(0.0, 1.0) < 0.5
    }
}

/// For each state of the network, the index of the state of the fixed cycle.
fn places() -> Vec<usize> {
    let bodies = 0..2 * NETWORK_BODIES;
    bodies.chain(ENERGY..ENERGY + 2 * VOLUMES).collect()
}

/// A state within the travels, with typical pressures and temperatures of a shot.
fn state(system: &System, random: &mut Random) -> State {
    let mut y = start(system, None).unwrap().0;
    let p = &system.p;
    let tool = random.between(-3e-3, 1e-6);
    y[Y_G] += tool;
    y[Y_W] += random.between(-1e-4, 1e-6);
    y[Y_P] = y[Y_G] + random.between(-1e-6, p.piston.stroke);
    y[Y_H] = y[Y_G] + random.between(-1e-8, p.head_valve.lift);
    y[V_P] = random.between(-10.0, 25.0);
    y[V_H] = random.between(-3.0, 3.0);
    y[V_G] = random.between(-2.0, 2.0);
    y[V_W] = random.between(-1.0, 1.0);
    let volume = system.instant(&y).volume;
    for i in 0..VOLUMES {
        let (pressure, temperature) = (random.between(0.9e5, 9e5), random.between(230.0, 380.0));
        y[ENERGY + i] = pressure * volume[i] / (system.air.gamma - 1.0);
        y[MASS + i] = pressure * volume[i] / (system.air.gas_constant * temperature);
    }
    y
}

/// A mode of the fixed cycle and the equivalent mode of the network.
fn mode(system: &System, plan: &Plan, random: &mut Random) -> (Mode, Switches) {
    let mut fixed = start(system, None).unwrap().1;
    let mut network = Switches::new(plan);
    let on = |network: &mut Switches, switch: usize, on: bool| network.switches[switch] = u8::from(on);
    let contacts = ["bumper", "stopper", "cap", "seat", "nose", "support"];
    for (contact, name) in Contact::ALL.into_iter().zip(contacts) {
        fixed.closed[contact as usize] = random.coin();
        let place = plan.assembly.contacts.iter().position(|c| c.name == name).unwrap();
        on(&mut network, plan.contacts[place].switch, fixed.closed(contact));
    }
    fixed.guard = random.coin();
    let guard = plan.assembly.contacts.iter().position(|c| c.name == "guard").unwrap();
    on(&mut network, plan.contacts[guard].switch, fixed.guard);
    let passage = |name: &str| plan.assembly.passages.iter().position(|p| p.name == name).unwrap();
    let opening = |name: &str| plan.passages[passage(name)].restrictions[0].travel().unwrap().switch;
    (fixed.intake, fixed.exhaust, fixed.check_holes) = (random.coin(), random.coin(), random.coin());
    on(&mut network, opening("intake"), fixed.intake);
    on(&mut network, opening("exhaust"), fixed.exhaust);
    on(&mut network, opening("check"), fixed.check_holes);
    fixed.channel = [Channel::Closed, Channel::Venting, Channel::Filling][random.between(0.0, 3.0) as usize];
    on(
        &mut network,
        plan.passages[passage("vent")].gate.unwrap(),
        fixed.channel == Channel::Venting,
    );
    on(
        &mut network,
        plan.passages[passage("fill")].gate.unwrap(),
        fixed.channel == Channel::Filling,
    );
    let nail = &plan.fasteners[0];
    if random.coin() {
        fixed.nail = NailState::Attached;
        network.switches[nail.head] = head::ATTACHED;
    }
    let (deepest, force) = (random.between(0.0, 0.08), random.between(0.0, 3e3));
    (fixed.penetration, network.switches[nail.depth]) = match random.between(0.0, 4.0) as usize {
        0 => (Penetration::Free { deepest, force }, depth::FREE),
        1 => (Penetration::Loading { seated: false }, depth::LOADING),
        2 => (Penetration::Loading { seated: true }, depth::SEATED),
        _ => (Penetration::Unloading { deepest, force }, depth::UNLOADING),
    };
    network.memory[nail.deepest] = deepest;
    network.memory[nail.deepest + 1] = force;
    (fixed, network)
}

/// Asserts that two numbers agree to 1e-12 of the magnitude of their terms.
fn agree(what: &str, a: f64, b: f64, size: f64) {
    assert!((a - b).abs() <= 1e-12 * (a.abs() + size), "{what}: {a} {b}");
}

#[test]
fn rates_and_jacobian_are_those_of_the_fixed_cycle() {
    let system = System::new(&n80cb());
    let plan = Plan::new(&n80cb_assembly(&system.p, 0.1, 5e-3)).unwrap();
    let mut w = Workspace::new(&plan);
    let mut jacobian = Jacobian::new(&plan);
    let mut random = Random(7);
    let places = places();
    for trial in 0..1000 {
        let y = state(&system, &mut random);
        let (fixed, network) = mode(&system, &plan, &mut random);
        let mut own = vec![0.0; plan.size()];
        for (own, place) in own.iter_mut().zip(&places) {
            *own = y[*place];
        }
        let seeded: [Dual<STATES>; SIZE] = std::array::from_fn(|i| {
            let mut slope = [0.0; STATES];
            if i < STATES {
                slope[i] = 1.0;
            }
            Dual { value: y[i], slope }
        });
        let expected = system.rates(&seeded, &fixed, &Past::none());
        let mut rate = vec![0.0; plan.size()];
        plan.rates(0.0, &own, &network, &mut w, &mut rate);
        let forces = w.contact.iter().map(|c| c.force.abs()).sum::<f64>() + w.fastener[0][0].abs() + 1e4;
        plan.jacobian(0.0, &own, &network, &mut w, &mut jacobian);
        for (row, place) in places.iter().enumerate() {
            // Magnitudes: accelerations, powers of a kilowatt, flows of 10 g/s.
            let size = match row {
                row if row < plan.energy() => forces / 0.02,
                row if row < plan.mass() => 1e3,
                _ => 1e-2,
            };
            agree(&format!("{trial}: rate {row}"), rate[row], expected[*place].value, size);
            for (column, from) in places.iter().enumerate() {
                let found = jacobian.values()[column * plan.size() + row];
                let slope = expected[*place].slope[*from];
                // The largest terms of a row and a column bound the cancellation in an entry.
                let whole: f64 = (0..places.len())
                    .map(|k| jacobian.values()[column * plan.size() + k].abs())
                    .filter(|_| row >= 2 * NETWORK_BODIES)
                    .fold(0.0, f64::max);
                let stiff = if row < 2 * NETWORK_BODIES && column < 2 * NETWORK_BODIES {
                    1e12
                } else {
                    whole
                };
                agree(&format!("{trial}: {row} by {column}"), found, slope, stiff);
            }
        }
    }
}
