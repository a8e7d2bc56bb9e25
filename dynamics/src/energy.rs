//! Energy balance of a shot.

use serde::Serialize;

/// Energy flow from the trigger pull to the end of the record \[J\].
///
/// ```text
/// gas:         U(0) + supply + wall_heat = U(end) + exhaust + vent + leak + piston_work + valve_work
/// mechanics:   E(0) + piston_work + valve_work + atmosphere + hand + gravity + thrust
///                   = E(end) + piston_friction + valve_friction + magazine_friction + penetration
///                     + nail_impact + nail_left + contacts + wood + hand_damping
/// ```
/// U is the internal energy of the gas, E the kinetic and elastic energy of bodies, springs and contacts. The energies
/// of flows are enthalpies c_p T m at the temperature of their origin, counted from 0 K: a kilogram of air at ambient
/// temperature carries 294 kJ in either direction.
///
/// The published forms of gas law, channel and valve underside do not conserve energy (C-02, C-03, C-06). The flow is
/// still given for them; the residuals show the energy lost.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct EnergyFlow {
    /// Internal energy of the gas in all volumes at the trigger pull.
    pub gas_start: f64,
    /// The same at the end.
    pub gas_end: f64,
    /// Enthalpy inflow from the hose.
    pub supply: f64,
    /// Enthalpy outflow through the exhaust holes.
    pub exhaust: f64,
    /// Enthalpy outflow through the trigger's vent.
    pub vent: f64,
    /// Enthalpy outflow through the rod-guide leak.
    pub leak: f64,
    /// Heat from the walls into the gas.
    pub wall_heat: f64,
    /// Work of the gas on the piston.
    pub piston_work: f64,
    /// Work of the gas on the head valve.
    pub valve_work: f64,
    /// Work of the ambient pressure on the rod.
    pub atmosphere: f64,
    /// Work of the hand's constant force.
    pub hand: f64,
    /// Work of gravity on all bodies.
    pub gravity: f64,
    /// Work of the exhaust's thrust on the tool.
    pub thrust: f64,
    /// Work against the piston's friction.
    pub piston_friction: f64,
    /// Work against the head valve's friction.
    pub valve_friction: f64,
    /// Work against the friction of magazine and guide on the nail.
    pub magazine_friction: f64,
    /// Work of the rod on the wood through the nail.
    pub penetration: f64,
    /// Energy lost in the impact of the rod on the nail; the published form gains energy with the mass of the nail.
    pub nail_impact: f64,
    /// Kinetic energy of the nail when the rod leaves it.
    pub nail_left: f64,
    /// Dissipated in the contacts.
    pub contacts: ContactEnergy,
    /// Work on an external workpiece; 0 if the workpiece is a lumped mass of the cycle.
    pub wood: f64,
    /// Dissipated between hand and tool.
    pub hand_damping: f64,
    /// Kinetic energy of all bodies at the trigger pull.
    pub kinetic_start: f64,
    /// The same at the end.
    pub kinetic_end: f64,
    /// Energy of springs and closed contacts at the trigger pull.
    pub elastic_start: f64,
    /// The same at the end.
    pub elastic_end: f64,
}

/// Energy dissipated in each contact \[J\]: by its dashpot, plus the energy of its spring if it opens while compressed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct ContactEnergy {
    /// Piston on the bumper.
    pub bumper: f64,
    /// Piston on the upper stopper.
    pub stopper: f64,
    /// Head valve on the cap.
    pub cap: f64,
    /// Head valve on its seat.
    pub seat: f64,
    /// Nose on the wood.
    pub nose: f64,
    /// Block on its support.
    pub support: f64,
}

impl ContactEnergy {
    /// Sum over all contacts.
    pub fn total(&self) -> f64 {
        self.bumper + self.stopper + self.cap + self.seat + self.nose + self.support
    }
}

impl EnergyFlow {
    /// Energy dissipated in the mechanics, including the work of penetration \[J\].
    pub fn dissipated(&self) -> f64 {
        self.piston_friction
            + self.valve_friction
            + self.magazine_friction
            + self.penetration
            + self.nail_impact
            + self.nail_left
            + self.contacts.total()
            + self.hand_damping
    }

    /// Residual of the gas balance \[J\].
    pub fn gas_residual(&self) -> f64 {
        self.gas_start + self.supply + self.wall_heat
            - self.exhaust
            - self.vent
            - self.leak
            - self.piston_work
            - self.valve_work
            - self.gas_end
    }

    /// Residual of the mechanical balance \[J\].
    pub fn mechanical_residual(&self) -> f64 {
        let work = self.piston_work + self.valve_work + self.atmosphere + self.hand + self.gravity + self.thrust;
        let stored = self.kinetic_end - self.kinetic_start + self.elastic_end - self.elastic_start;
        work - self.dissipated() - self.wood - stored
    }

    /// Residual of the balance of the whole shot \[J\].
    pub fn residual(&self) -> f64 {
        self.gas_residual() + self.mechanical_residual()
    }
}
