//! Conservation: mass, gas energy, momentum and the whole shot's energy.

use nailnoise_quantities::Check;

use super::forces::SPRING;
use super::mode::{Contact, Mode, NailState};
use super::state::*;
use super::switching::is_nail;
use super::system::System;
use crate::{ContactEnergy, EnergyFlow, Form};

/// Largest residual of the energy balance of the complete shot \[J\], and as a fraction of the initial gas energy
/// \[-\].
const SHOT_LIMIT: f64 = 1e-3;
const SHOT_PART: f64 = 1e-6;

/// Balance residuals tracked during the run.
#[derive(Debug, Clone)]
pub(crate) struct Balance {
    start_mass: f64,
    start: Stock,
    momentum: f64,
    /// Energy removed from bodies and springs at events: per contact, at the impact of the rod on the nail, and with
    /// the nail left behind.
    released: [f64; Contact::COUNT],
    nail_impact: f64,
    nail_left: f64,
    /// Change in gravitational work due to the nail's weight when the nail joins or leaves the rod.
    fall_jump: f64,
    worst_mass: f64,
    worst_gas: f64,
    worst_shot: f64,
    worst_momentum: f64,
}

/// Energies, and the potentials of conservative external forces.
#[derive(Debug, Clone, Copy)]
struct Stock {
    gas: f64,
    kinetic: f64,
    elastic: f64,
    /// Work that gravity, the ambient pressure on the rod and the hand force would do from the origin to this state.
    gravity: f64,
    atmosphere: f64,
    hand: f64,
}

impl Stock {
    fn new(system: &System, mode: &Mode, y: &State) -> Self {
        let (p, g) = (&system.p, &system.geometry);
        let mut kinetic = 0.0;
        let mut gravity = 0.0;
        for (body, mass) in masses(system, mode).into_iter().enumerate() {
            let velocity = y[2 * body + 1];
            kinetic += 0.5 * mass * velocity * velocity;
            // The hand's push excludes its weight, which the arm carries.
            if body != Y_M / 2 {
                gravity += mass * p.ambient.gravity * y[2 * body];
            }
        }
        let pushed = if system.sprung_hand { y[Y_M] } else { y[Y_G] };
        Self {
            gas: y[ENERGY..ENERGY + VOLUMES].iter().sum(),
            kinetic,
            elastic: elastic(system, mode, y),
            gravity,
            atmosphere: -p.ambient.pressure * g.rod_area * (y[Y_P] - y[Y_G]),
            hand: p.hand.force * pushed,
        }
    }
}

fn masses(system: &System, mode: &Mode) -> [f64; BODIES] {
    let p = &system.p;
    [
        system.moving_mass(mode),
        p.head_valve.mass,
        p.tool.mass,
        if mode.wood.is_some() {
            0.0
        } else {
            system.geometry.workpiece_mass
        },
        p.hand.mass,
    ]
}

/// Energy of springs and closed contacts.
fn elastic(system: &System, mode: &Mode, y: &State) -> f64 {
    let p = &system.p;
    let mut energy = 0.0;
    for contact in Contact::ALL {
        if mode.closed(contact) {
            let u = system.overlap(contact, mode, y).0;
            energy += 0.5 * system.springs[contact as usize].stiffness * u * u;
        }
    }
    if mode.guard {
        let u = y[Y_G] - mode.seat_motion(y).0 + p.contacts.guard_travel;
        energy += 0.5 * system.guard_stiffness * u * u;
    }
    if system.sprung_hand {
        let u = y[Y_M] - y[Y_G];
        energy += 0.5 * p.hand.stiffness * u * u;
    }
    // Integral of the closing spring's characteristic over its compression.
    let x = p.head_valve.lift - (y[Y_H] - y[Y_G]) + p.head_valve.spring_preload;
    energy
        + p.head_valve.spring_scale
            * SPRING
                .iter()
                .enumerate()
                .rev()
                .fold(0.0, |sum, (i, c)| sum * x + c / (i as f64 + 1.0))
            * x
}

fn total_mass(y: &State) -> f64 {
    y[MASS..MASS + VOLUMES].iter().sum::<f64>() + y[EXHAUST_MASS] + y[VENT_MASS] + y[LEAK_MASS] - y[SUPPLY_MASS]
}

/// Momentum of the bodies minus the impulse of external forces.
fn momentum(system: &System, mode: &Mode, y: &State) -> f64 {
    let bodies: f64 = masses(system, mode)
        .iter()
        .enumerate()
        .map(|(body, mass)| mass * y[2 * body + 1])
        .sum();
    bodies + y[SUPPORT_IMPULSE] - y[OUTER_IMPULSE]
}

impl Balance {
    pub(crate) fn new(system: &System, mode: &Mode, y: &State) -> Self {
        Self {
            start_mass: total_mass(y),
            start: Stock::new(system, mode, y),
            momentum: momentum(system, mode, y),
            released: [0.0; Contact::COUNT],
            nail_impact: 0.0,
            nail_left: 0.0,
            fall_jump: 0.0,
            worst_mass: 0.0,
            worst_gas: 0.0,
            worst_shot: 0.0,
            worst_momentum: 0.0,
        }
    }

    /// Updates the residuals at the end of a step.
    pub(crate) fn follow(&mut self, system: &System, mode: &Mode, y: &State) {
        let worst = |worst: &mut f64, residual: f64| *worst = worst.max(residual.abs());
        let flow = self.energy(system, mode, y);
        worst(&mut self.worst_mass, total_mass(y) - self.start_mass);
        worst(&mut self.worst_gas, flow.gas_residual());
        worst(&mut self.worst_shot, flow.residual());
        worst(&mut self.worst_momentum, momentum(system, mode, y) - self.momentum);
    }

    /// Accounts for the event of `slot`, which changed mode and state.
    pub(crate) fn cross(&mut self, system: &System, slot: usize, before: (&Mode, &State), after: (&Mode, &State)) {
        let (old, new) = (
            Stock::new(system, before.0, before.1),
            Stock::new(system, after.0, after.1),
        );
        let lost = old.kinetic + old.elastic - new.kinetic - new.elastic;
        self.fall_jump += old.gravity - new.gravity;
        if slot < Contact::COUNT {
            self.released[slot] += lost;
        } else if is_nail(slot) && after.0.nail == NailState::Attached {
            self.nail_impact += lost;
        } else if is_nail(slot) {
            self.nail_left += lost;
        }
        if before.0.nail != after.0.nail
            && (after.0.nail == NailState::Left || system.p.model.impact == Form::Published)
        {
            // The nail keeps its momentum when left behind, which is zero within the accuracy of locating v_p = 0; in
            // the published form, it has gained 6 % of the piston's momentum from nowhere.
            self.momentum += momentum(system, after.0, after.1) - momentum(system, before.0, before.1);
        }
    }

    /// The energy flow up to a state.
    pub(crate) fn energy(&self, system: &System, mode: &Mode, y: &State) -> EnergyFlow {
        let (start, now) = (&self.start, Stock::new(system, mode, y));
        let contact = |contact: Contact| y[DASHPOTS + contact as usize] + self.released[contact as usize];
        EnergyFlow {
            gas_start: start.gas,
            gas_end: now.gas,
            supply: y[SUPPLY_ENTHALPY],
            exhaust: y[EXHAUST_ENTHALPY],
            vent: y[VENT_ENTHALPY],
            leak: y[LEAK_ENTHALPY],
            wall_heat: y[HEAT],
            piston_work: y[PISTON_WORK],
            valve_work: y[GAS_WORK] - y[PISTON_WORK],
            atmosphere: now.atmosphere - start.atmosphere,
            hand: now.hand - start.hand,
            gravity: now.gravity - start.gravity + self.fall_jump,
            thrust: y[THRUST_WORK],
            piston_friction: y[PISTON_FRICTION],
            valve_friction: y[VALVE_FRICTION],
            magazine_friction: y[MAGAZINE_FRICTION],
            penetration: y[PENETRATION],
            nail_impact: self.nail_impact,
            nail_left: self.nail_left,
            contacts: ContactEnergy {
                bumper: contact(Contact::Bumper),
                stopper: contact(Contact::Stopper),
                cap: contact(Contact::Cap),
                seat: contact(Contact::Seat),
                nose: contact(Contact::Nose),
                support: if mode.wood.is_some() {
                    0.0
                } else {
                    contact(Contact::Support)
                },
            },
            wood: if mode.wood.is_some() { y[WOOD_WORK] } else { 0.0 },
            hand_damping: y[HAND_DASHPOT],
            kinetic_start: start.kinetic,
            kinetic_end: now.kinetic,
            elastic_start: start.elastic,
            elastic_end: now.elastic,
        }
    }

    /// The balances that the chosen forms satisfy; the published gas law, channel and valve underside violate some of
    /// them (C-02, C-03, C-06).
    pub(crate) fn checks(&self, system: &System) -> Vec<Check> {
        let m = &system.p.model;
        let holds = |forms: &[Form]| forms.iter().all(|form| *form == Form::Corrected);
        let mut checks = Vec::new();
        if holds(&[m.channel]) {
            checks.push(Check::at_most("mass balance [kg]", self.worst_mass, 1e-12));
        }
        if holds(&[m.channel, m.gas]) {
            checks.push(Check::at_most("gas energy balance [J]", self.worst_gas, 1e-6));
        }
        if holds(&[m.channel, m.gas, m.valve_underside]) {
            checks.push(Check::at_most(
                "whole-shot energy balance [J]",
                self.worst_shot,
                SHOT_LIMIT,
            ));
            checks.push(Check::at_most(
                "whole-shot energy balance, part of the gas energy at the start [-]",
                self.worst_shot / self.start.gas,
                SHOT_PART,
            ));
        }
        checks.push(Check::at_most("momentum balance [N s]", self.worst_momentum, 1e-9));
        checks
    }
}
