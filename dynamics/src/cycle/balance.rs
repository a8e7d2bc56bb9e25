//! Conservation: mass, gas energy, momentum and the whole shot's energy.

use super::mode::{Contact, Mode, NailState};
use super::state::*;
use super::system::{SPRING, System};
use crate::{Check, Form};

/// Residuals followed through the run.
#[derive(Debug, Clone)]
pub(crate) struct Balance {
    start_mass: f64,
    start_gas: f64,
    start_shot: f64,
    momentum: f64,
    /// Energy taken out of the balance at events: rod-nail impact, springs let go, the nail's weight.
    released: f64,
    worst_mass: f64,
    worst_gas: f64,
    worst_shot: f64,
    worst_momentum: f64,
}

fn total_mass(y: &State) -> f64 {
    y[MASS..MASS + VOLUMES].iter().sum::<f64>() + y[EXHAUST_MASS] + y[VENT_MASS] + y[LEAK_MASS] - y[SUPPLY_MASS]
}

fn outflow(y: &State) -> f64 {
    y[EXHAUST_ENTHALPY] + y[VENT_ENTHALPY] + y[LEAK_ENTHALPY] - y[SUPPLY_ENTHALPY] - y[HEAT]
}

fn gas_energy(y: &State) -> f64 {
    y[ENERGY..ENERGY + VOLUMES].iter().sum::<f64>() + outflow(y) + y[GAS_WORK]
}

/// Energy of the bodies, springs and closed contacts, in gravity, under hand and ambient pressure on the rod.
fn stored(system: &System, mode: &Mode, y: &State) -> f64 {
    let (p, g) = (&system.p, &system.geometry);
    let masses = [
        system.moving_mass(mode),
        p.head_valve.mass,
        p.tool.mass,
        g.workpiece_mass,
    ];
    let mut energy = p.ambient.pressure * g.rod_area * (y[Y_P] - y[Y_G]) - p.hand.force * y[Y_G];
    for (body, mass) in masses.iter().enumerate() {
        let (position, velocity) = (y[2 * body], y[2 * body + 1]);
        energy += mass * (0.5 * velocity * velocity - p.ambient.gravity * position);
    }
    for contact in Contact::ALL {
        if mode.closed(contact) {
            let u = system.overlap(contact, y).0;
            energy += 0.5 * system.pads[contact as usize].stiffness * u * u;
        }
    }
    if mode.guard {
        let u = y[Y_G] - y[Y_W] + p.contacts.guard_travel;
        energy += 0.5 * system.guard_stiffness * u * u;
    }
    // Integral of the spring's characteristic over its compression.
    let x = p.head_valve.lift - (y[Y_H] - y[Y_G]) + p.head_valve.spring_preload;
    energy
        + SPRING
            .iter()
            .enumerate()
            .rev()
            .fold(0.0, |sum, (i, c)| sum * x + c / (i as f64 + 1.0))
            * x
}

fn dissipated(y: &State) -> f64 {
    y[PISTON_FRICTION] + y[VALVE_FRICTION] + y[PENETRATION] + y[DASHPOTS..DASHPOTS + Contact::COUNT].iter().sum::<f64>()
}

fn shot_energy(system: &System, mode: &Mode, y: &State) -> f64 {
    let gas = y[ENERGY..ENERGY + VOLUMES].iter().sum::<f64>();
    gas + outflow(y) + stored(system, mode, y) + dissipated(y)
}

/// Momentum of the four bodies less the impulse on them from outside.
fn momentum(system: &System, mode: &Mode, y: &State) -> f64 {
    let p = &system.p;
    let bodies = system.moving_mass(mode) * y[V_P]
        + p.head_valve.mass * y[V_H]
        + p.tool.mass * y[V_G]
        + system.geometry.workpiece_mass * y[V_W];
    bodies + y[SUPPORT_IMPULSE] - y[OUTER_IMPULSE]
}

impl Balance {
    pub(crate) fn new(system: &System, mode: &Mode, y: &State) -> Self {
        Self {
            start_mass: total_mass(y),
            start_gas: gas_energy(y),
            start_shot: shot_energy(system, mode, y),
            momentum: momentum(system, mode, y),
            released: 0.0,
            worst_mass: 0.0,
            worst_gas: 0.0,
            worst_shot: 0.0,
            worst_momentum: 0.0,
        }
    }

    /// Follows the residuals at the end of a step.
    pub(crate) fn follow(&mut self, system: &System, mode: &Mode, y: &State) {
        let worst = |worst: &mut f64, residual: f64| *worst = worst.max(residual.abs());
        worst(&mut self.worst_mass, total_mass(y) - self.start_mass);
        worst(&mut self.worst_gas, gas_energy(y) - self.start_gas);
        worst(
            &mut self.worst_shot,
            shot_energy(system, mode, y) + self.released - self.start_shot,
        );
        worst(&mut self.worst_momentum, momentum(system, mode, y) - self.momentum);
    }

    /// Takes up an event that changed mode and state.
    pub(crate) fn cross(&mut self, system: &System, before: (&Mode, &State), after: (&Mode, &State)) {
        self.released += shot_energy(system, before.0, before.1) - shot_energy(system, after.0, after.1);
        if before.0.nail != after.0.nail
            && (after.0.nail == NailState::Left || system.p.model.impact == Form::Published)
        {
            // The nail stays behind with the momentum it has, nothing to within the location of v_p = 0; in the
            // published form it has come from nowhere with 6 % of the piston's.
            self.momentum += momentum(system, after.0, after.1) - momentum(system, before.0, before.1);
        }
    }

    /// The balances that the forms in use obey: published gas law, channel and valve underside break some (C-02, C-03,
    /// C-06).
    pub(crate) fn checks(&self, system: &System) -> Vec<Check> {
        let check = |name, value: f64, limit: f64| Check {
            name,
            value,
            limit,
            ok: value <= limit,
        };
        let m = &system.p.model;
        let holds = |forms: &[Form]| forms.iter().all(|form| *form == Form::Corrected);
        let mut checks = Vec::new();
        if holds(&[m.channel]) {
            checks.push(check("mass balance [kg]", self.worst_mass, 1e-12));
        }
        if holds(&[m.channel, m.gas]) {
            checks.push(check("gas energy balance [J]", self.worst_gas, 1e-6));
        }
        if holds(&[m.channel, m.gas, m.valve_underside]) {
            checks.push(check("whole-shot energy balance [J]", self.worst_shot, 1e-3));
        }
        checks.push(check("momentum balance [N s]", self.worst_momentum, 1e-9));
        checks
    }
}
