//! Constants of a cycle, and the properties of a state without forces and flows: kinematics, volumes, gas.

use super::gas::{Air, Gas};
use super::mode::{Contact, Mode, NailState};
use super::state::*;
use crate::{Form, Geometry, Parameters};
use nailnoise_penetration::Envelope;
use nailnoise_penetration::Real;

/// Spring and dashpot of a contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SpringDashpot {
    pub(crate) stiffness: f64,
    pub(crate) damping: f64,
}

/// All constants of a cycle.
#[derive(Debug, Clone)]
pub(crate) struct System {
    pub(crate) p: Parameters,
    pub(crate) geometry: Geometry,
    pub(crate) air: Air,
    /// Contacts, indexed by [`Contact`].
    pub(crate) springs: [SpringDashpot; Contact::COUNT],
    /// k_esg = k_sg k_wsn/(k_sg + k_wsn) (C-12).
    pub(crate) guard_stiffness: f64,
    /// A_h3 as far as P_1 acts on it; zero in the published form (C-06).
    pub(crate) underside_area: f64,
    /// Areas with which the valve sweeps the volume above the piston and the supply side; zero in the published form
    /// (C-07).
    pub(crate) sweep: [f64; 2],
    pub(crate) envelope: Envelope,
    /// C_d A of the check-ring holes, return holes, leak, hose and exhaust holes \[m2\].
    pub(crate) check_area: f64,
    pub(crate) return_area: f64,
    pub(crate) leak_area: f64,
    pub(crate) hose_area: f64,
    pub(crate) exhaust_area: f64,
    pub(crate) vent_area: f64,
    pub(crate) fill_area: f64,
    /// Sine and cosine of the seats' angles.
    pub(crate) intake_angle: (f64, f64),
    pub(crate) exhaust_angle: (f64, f64),
    /// Whether the hand is a mass on a spring instead of only a force.
    pub(crate) sprung_hand: bool,
}

/// Kinematics and gas state.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Instant<S> {
    pub(crate) travel: S,
    pub(crate) travel_rate: S,
    /// y_hr.
    pub(crate) valve: S,
    pub(crate) valve_rate: S,
    pub(crate) volume: [S; VOLUMES],
    pub(crate) gas: [Gas<S>; VOLUMES],
}

impl System {
    pub(crate) fn new(p: &Parameters) -> Self {
        let geometry = Geometry::new(p);
        let air = Air::new(
            p.ambient.gas_constant,
            p.ambient.heat_capacity_ratio,
            p.model.orifice_linear,
        );
        let c = &p.contacts;
        let ratio = |zeta: f64, k: f64, mass: f64| SpringDashpot {
            stiffness: k,
            damping: 2.0 * zeta * (k * mass).sqrt(),
        };
        let springs = [
            SpringDashpot {
                stiffness: c.bumper_stiffness,
                damping: c.bumper_damping,
            },
            SpringDashpot {
                stiffness: c.stopper_stiffness,
                damping: c.stopper_damping,
            },
            ratio(c.valve_damping_ratio, c.cap_stiffness, p.head_valve.mass),
            ratio(c.valve_damping_ratio, c.seat_stiffness, p.head_valve.mass),
            ratio(c.nose_damping_ratio, c.nose_stiffness, p.tool.mass),
            SpringDashpot {
                stiffness: p.support.stiffness,
                damping: geometry.support_damping,
            },
        ];
        let cd = p.chambers.discharge_coefficient;
        let underside = p.model.valve_underside == Form::Corrected;
        let refill = p.model.refill == Form::Corrected;
        Self {
            guard_stiffness: c.guard_stiffness * c.nose_stiffness / (c.guard_stiffness + c.nose_stiffness),
            underside_area: if underside { geometry.valve_cylinder_area } else { 0.0 },
            sweep: if underside {
                [geometry.valve_cylinder_area, geometry.valve_supply_area]
            } else {
                [0.0; 2]
            },
            envelope: p.penetration_envelope(),
            check_area: cd * p.chambers.check_hole_area,
            return_area: cd * p.chambers.return_hole_area,
            leak_area: cd * p.chambers.leak_area,
            hose_area: if refill { cd * p.supply.hose_area } else { 0.0 },
            exhaust_area: geometry.exhaust_area,
            vent_area: p.trigger.vent_area * geometry.attenuation_vent,
            fill_area: p.trigger.fill_area * geometry.attenuation_fill,
            intake_angle: p.head_valve.intake_angle.sin_cos(),
            exhaust_angle: p.head_valve.exhaust_angle.sin_cos(),
            sprung_hand: p.hand.mass > 0.0,
            springs,
            air,
            geometry,
            p: p.clone(),
        }
    }

    /// Depth of the nail's tip, z = y_p - y_w - y_pbp.
    pub(crate) fn depth<S: Real>(&self, mode: &Mode, y: &[S]) -> S {
        y[Y_P] - mode.nail_motion(y).0 - self.geometry.tip_gap
    }

    /// Overlap of a contact and its rate.
    #[inline]
    pub(crate) fn overlap<S: Real>(&self, contact: Contact, mode: &Mode, y: &[S]) -> (S, S) {
        match contact {
            Contact::Bumper => (y[Y_P] - y[Y_G] - self.p.piston.stroke, y[V_P] - y[V_G]),
            Contact::Stopper => (y[Y_G] - y[Y_P], y[V_G] - y[V_P]),
            Contact::Cap => (y[Y_G] - y[Y_H], y[V_G] - y[V_H]),
            Contact::Seat => (y[Y_H] - y[Y_G] - self.p.head_valve.lift, y[V_H] - y[V_G]),
            Contact::Nose => {
                let (position, velocity) = mode.seat_motion(y);
                (y[Y_G] - position, y[V_G] - velocity)
            }
            Contact::Support => (y[Y_W], y[V_W]),
        }
    }

    /// M_t, the mass that moves with the piston.
    pub(crate) fn moving_mass(&self, mode: &Mode) -> f64 {
        match mode.nail {
            NailState::Attached => self.p.piston.mass + self.geometry.nail_mass,
            NailState::Waiting | NailState::Left => self.p.piston.mass,
        }
    }

    /// Kinematics, volumes, pressures and temperatures.
    #[inline]
    pub(crate) fn instant<S: Real>(&self, y: &[S]) -> Instant<S> {
        let (p, g) = (&self.p, &self.geometry);
        let travel = y[Y_P] - y[Y_G];
        let valve = y[Y_H] - y[Y_G];
        let lift = -valve + p.head_valve.lift;
        let c = &p.chambers;
        let volume = [
            travel * g.piston_area + lift * self.sweep[0] + c.above_piston,
            (-travel + p.piston.stroke) * g.ring_area + c.below_piston,
            S::constant(c.return_volume),
            valve * g.valve_control_area + c.above_valve,
            lift * self.sweep[1] + c.supply_volume,
        ];
        let gas = std::array::from_fn(|i| {
            let (u, m, v) = (y[ENERGY + i], y[MASS + i], volume[i]);
            Gas {
                pressure: u * v.recip() * (self.air.gamma - 1.0),
                temperature: match p.model.gas {
                    Form::Corrected => u * m.recip() * ((self.air.gamma - 1.0) / self.air.gas_constant),
                    Form::Published => S::constant(p.ambient.temperature),
                },
            }
        });
        Instant {
            travel,
            travel_rate: y[V_P] - y[V_G],
            valve,
            valve_rate: y[V_H] - y[V_G],
            volume,
            gas,
        }
    }
}
