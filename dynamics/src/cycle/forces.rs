//! Forces between the bodies, and the resulting accelerations.

use super::mode::{Contact, Mode, NailState, Penetration};
use super::state::*;
use super::system::{Instant, System};
use nailnoise_penetration::Real;

/// Coefficients of the head valve's closing spring, F(y) in N, y in m (Eq. 4.60, as printed; C-24).
pub(crate) const SPRING: [f64; 9] = [
    4.17, 79_135.7, -7.55e7, 3.56e10, -8.57e12, 1.13e15, -8.28e16, 3.14e18, -4.79e19,
];

/// Largest compression of the closing spring in the range of the published characteristic \[m\] (C-24).
pub(crate) const SPRING_LIMIT: f64 = 5e-3;

/// Forces at a state \[N\], named as in [`crate::Forces`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Forces<S> {
    /// Contact forces, >= 0 except where a dashpot pulls just before the contact opens.
    pub(crate) push: [S; Contact::COUNT],
    /// The dashpot contributions to the contact forces.
    pub(crate) dashpot: [S; Contact::COUNT],
    pub(crate) piston_gas: S,
    pub(crate) valve_gas: S,
    pub(crate) spring: S,
    pub(crate) piston_friction: S,
    pub(crate) valve_friction: S,
    pub(crate) magazine: S,
    pub(crate) penetration: S,
    pub(crate) guard: S,
    pub(crate) hand: S,
    /// The dashpot contribution to the hand force.
    pub(crate) hand_dashpot: S,
}

impl System {
    /// All forces except the exhaust's thrust, thesis Eqs. 4.1 to 4.18 and 4.55 to 4.60 as corrected.
    #[inline]
    pub(crate) fn forces<S: Real>(&self, y: &[S], now: &Instant<S>, mode: &Mode) -> Forces<S> {
        let (p, g) = (&self.p, &self.geometry);
        let zero = S::constant(0.0);
        let gas = &now.gas;
        let piston_gas =
            gas[ABOVE].pressure * g.piston_area - gas[BELOW].pressure * g.ring_area - p.ambient.pressure * g.rod_area;
        let valve_gas = gas[CONTROL].pressure * g.valve_control_area
            - gas[SUPPLY].pressure * g.valve_supply_area
            - gas[ABOVE].pressure * self.underside_area;

        let mut push = [zero; Contact::COUNT];
        let mut dashpot = [zero; Contact::COUNT];
        for contact in Contact::ALL {
            if mode.closed(contact) {
                let spring = self.springs[contact as usize];
                let (u, rate) = self.overlap(contact, mode, y);
                dashpot[contact as usize] = rate * spring.damping;
                push[contact as usize] = u * spring.stiffness + dashpot[contact as usize];
            }
        }
        let guard = if mode.guard {
            (y[Y_G] - mode.seat_motion(y).0 + p.contacts.guard_travel) * self.guard_stiffness
        } else {
            zero
        };
        let (hand, hand_dashpot) = if self.sprung_hand {
            let dashpot = (y[V_M] - y[V_G]) * p.hand.damping;
            ((y[Y_M] - y[Y_G]) * p.hand.stiffness + dashpot, dashpot)
        } else {
            (S::constant(p.hand.force), zero)
        };
        let magazine = if mode.nail == NailState::Attached && p.nail.magazine_friction > 0.0 {
            self.coulomb(p.nail.magazine_friction, now.travel_rate)
        } else {
            zero
        };
        let z = self.depth(mode, y);
        let penetration = match mode.penetration {
            Penetration::Free { .. } => zero,
            Penetration::Loading { seated: false } => {
                let v = y[V_P] - mode.nail_motion(y).1;
                self.envelope.law().evaluate(z, v, mode.impact)
            }
            Penetration::Loading { seated: true } => {
                let v = y[V_P] - mode.nail_motion(y).1;
                self.envelope.head_at(z) + self.envelope.seated(v, mode.impact)
            }
            Penetration::Unloading { deepest, force } => (z - deepest) * p.wood.unloading_stiffness + force,
        };
        let lift = -now.valve + p.head_valve.lift;
        Forces {
            push,
            dashpot,
            piston_gas,
            valve_gas,
            spring: (lift + p.head_valve.spring_preload).polynomial(&SPRING) * p.head_valve.spring_scale,
            piston_friction: self.friction(&p.piston.friction, now.travel_rate),
            valve_friction: self.friction(&p.head_valve.friction, now.valve_rate),
            magazine,
            penetration,
            guard,
            hand,
            hand_dashpot,
        }
    }

    /// Accelerations of piston, head valve, tool, workpiece and hand \[m/s2\]; `thrust` is that of the exhaust on the
    /// tool.
    #[inline]
    pub(crate) fn accelerations<S: Real>(&self, f: &Forces<S>, thrust: S, mode: &Mode) -> [S; BODIES] {
        let (p, g) = (&self.p, &self.geometry);
        let [bumper, stopper, cap, seat, nose, support] = f.push;
        let gravity = p.ambient.gravity;
        // Forces between the tool and its moving parts; down on the parts is positive.
        let on_piston = f.piston_gas - bumper + stopper - f.piston_friction - f.magazine;
        let on_valve = f.valve_gas + f.spring + cap - seat - f.valve_friction;
        [
            (on_piston - f.penetration) * (1.0 / self.moving_mass(mode)) + gravity,
            on_valve * (1.0 / p.head_valve.mass) + gravity,
            (-on_piston - on_valve - nose - f.guard + f.hand + thrust) * (1.0 / p.tool.mass) + gravity,
            match mode.wood {
                None => (f.penetration + nose + f.guard - support) * (1.0 / g.workpiece_mass) + gravity,
                Some(_) => S::constant(0.0),
            },
            if self.sprung_hand {
                (-f.hand + p.hand.force) * (1.0 / p.hand.mass)
            } else {
                S::constant(0.0)
            },
        ]
    }

    /// F_f = [F_d + (F_s - F_d) exp(-(v/v_st)^2)] tanh(v/v_0) + beta v (C-19).
    fn friction<S: Real>(&self, law: &crate::Friction, v: S) -> S {
        let m = &self.p.model;
        let x = v.value();
        let w = x / m.stribeck_velocity;
        // Outside this range, both functions equal their limits to the last digit, so they are not evaluated.
        let stribeck = if w.abs() < 30.0 { (-w * w).exp() } else { 0.0 };
        let fall = (law.static_force - law.sliding_force) * stribeck;
        let level = law.sliding_force + fall;
        let turn = saturating_tanh(x / m.friction_velocity);
        let force = level * turn + law.viscous * x;
        let slope = level * (1.0 - turn * turn) / m.friction_velocity - 2.0 * w / m.stribeck_velocity * fall * turn
            + law.viscous;
        v.chain(force, slope)
    }

    /// F tanh(v/v_0): dry friction with a constant force.
    #[inline]
    fn coulomb<S: Real>(&self, force: f64, v: S) -> S {
        let width = self.p.model.friction_velocity;
        let turn = saturating_tanh(v.value() / width);
        v.chain(force * turn, force * (1.0 - turn * turn) / width)
    }
}

/// tanh x, which equals +-1 to the last digit beyond 20.
#[inline]
fn saturating_tanh(x: f64) -> f64 {
    if x.abs() > 20.0 { x.signum() } else { x.tanh() }
}
