//! The right-hand side: rates of states and integrals.

use std::f64::consts::PI;

use super::flows::{ChannelFlow, Flows};
use super::history::Past;
use super::mode::{Contact, Mode};
use super::state::*;
use super::system::System;
use crate::Form;
use nailnoise_penetration::Real;

impl System {
    /// dy/dt of states and integrals.
    pub(crate) fn rates<S: Real>(&self, y: &[S], mode: &Mode, past: &Past) -> [S; SIZE] {
        let now = self.instant(y);
        let f = self.forces(y, &now, mode);
        let flows = self.flows(&now, mode, past);
        let thrust = flows.exhaust.thrust;
        let (p, g) = (&self.p, &self.geometry);
        let (travel, travel_rate, valve_rate) = (now.travel, now.travel_rate, now.valve_rate);
        let gas = &now.gas;
        let mut rate = [S::constant(0.0); SIZE];
        for (body, acceleration) in self.accelerations(&f, thrust, mode).into_iter().enumerate() {
            rate[2 * body] = y[2 * body + 1];
            rate[2 * body + 1] = acceleration;
        }

        // Flow carries the enthalpy of the volume it comes from.
        let cp = self.air.cp;
        let ta = p.ambient.temperature;
        let from = |flow: S, source: S, target: S| if flow.value() >= 0.0 { flow * source } else { flow * target } * cp;
        let t = gas.map(|gas| gas.temperature);
        let outside = S::constant(ta);
        let exhaust_h = from(flows.exhaust.mass, t[ABOVE], outside);
        let intake_h = from(flows.intake, t[SUPPLY], t[ABOVE]);
        let check_h = flows.check * t[ABOVE] * cp;
        let foot_h = from(flows.foot, t[BELOW], t[RETURN]);
        let leak_h = from(flows.leak, t[BELOW], outside);
        let hose_h = flows.hose * (cp * ta);
        let ChannelFlow { vent, fill, drain } = flows.channel;

        let c = &p.chambers;
        let bore = PI * p.piston.bore;
        let wall = [
            travel * bore + c.wall_above_piston,
            (-travel + p.piston.stroke) * bore + c.wall_below_piston,
            S::constant(c.wall_return),
            S::constant(c.wall_above_valve),
            S::constant(c.wall_supply),
        ];
        let heat: [S; VOLUMES] = std::array::from_fn(|i| wall[i] * (-t[i] + ta) * c.wall_heat_transfer);
        let growth = [
            travel_rate * g.piston_area - valve_rate * self.sweep[0],
            -travel_rate * g.ring_area,
            S::constant(0.0),
            valve_rate * g.valve_control_area,
            -valve_rate * self.sweep[1],
        ];
        let work: [S; VOLUMES] = std::array::from_fn(|i| gas[i].pressure * growth[i]);
        let inflow_h = [
            intake_h - exhaust_h - check_h,
            -foot_h - leak_h,
            check_h + foot_h,
            fill.enthalpy - vent.enthalpy,
            hose_h - intake_h - drain.enthalpy,
        ];
        let inflow = [
            flows.intake - flows.exhaust.mass - flows.check,
            -flows.foot - flows.leak,
            flows.check + flows.foot,
            fill.mass - vent.mass,
            flows.hose - flows.intake - drain.mass,
        ];
        let sum = |terms: [S; VOLUMES]| terms[0] + terms[1] + terms[2] + terms[3] + terms[4];
        for i in 0..VOLUMES {
            rate[ENERGY + i] = inflow_h[i] + heat[i] - work[i];
            rate[MASS + i] = inflow[i];
        }
        if p.model.gas == Form::Published {
            let polytropic = self.polytropic_energy(&flows, &work);
            rate[ENERGY..ENERGY + VOLUMES].copy_from_slice(&polytropic);
        }
        rate[EXHAUST_MASS] = flows.exhaust.mass;
        rate[VENT_MASS] = vent.mass;
        rate[LEAK_MASS] = flows.leak;
        rate[SUPPLY_MASS] = flows.hose;
        rate[EXHAUST_ENTHALPY] = exhaust_h;
        rate[VENT_ENTHALPY] = vent.enthalpy;
        rate[LEAK_ENTHALPY] = leak_h;
        rate[SUPPLY_ENTHALPY] = hose_h;
        rate[HEAT] = sum(heat);
        rate[GAS_WORK] = sum(work);
        // The valve's underside has its own share of the work on volume 1.
        rate[PISTON_WORK] = (f.piston_gas + p.ambient.pressure * g.rod_area) * travel_rate;
        rate[PISTON_FRICTION] = f.piston_friction * travel_rate;
        rate[VALVE_FRICTION] = f.valve_friction * valve_rate;
        rate[MAGAZINE_FRICTION] = f.magazine * travel_rate;
        rate[PENETRATION] = f.penetration * (y[V_P] - mode.nail_motion(y).1);
        for contact in Contact::ALL {
            if mode.closed(contact) {
                let i = contact as usize;
                rate[DASHPOTS + i] = f.dashpot[i] * self.overlap(contact, mode, y).1;
            }
        }
        let seat = f.push[Contact::Nose as usize] + f.guard;
        if self.sprung_hand {
            rate[HAND_DASHPOT] = f.hand_dashpot * (y[V_M] - y[V_G]);
        }
        rate[THRUST_WORK] = thrust * y[V_G];
        let mut mass = self.moving_mass(mode) + p.head_valve.mass + p.tool.mass;
        if mode.wood.is_some() {
            // With external wood, the bodies of the cycle rest on the wood itself.
            rate[SUPPORT_IMPULSE] = f.penetration + seat;
            rate[WOOD_WORK] = f.penetration * mode.nail_motion(y).1 + seat * mode.seat_motion(y).1;
        } else {
            rate[SUPPORT_IMPULSE] = f.push[Contact::Support as usize];
            mass += g.workpiece_mass;
        }
        let weight = mass * p.ambient.gravity;
        rate[OUTER_IMPULSE] = thrust + (p.hand.force + weight);
        rate
    }

    /// dU/dt of the published gas law, for the state U = P V/(gamma - 1) (C-02).
    ///
    /// ```text
    /// P' = R T_a/V (alpha_in sum(in) - alpha_o sum(out)) - alpha P V'/V
    /// ```
    /// with alpha_o = alpha_out from 1 to the atmosphere or back into ext and from 2 to the atmosphere, alpha_in for
    /// every other outflow.
    fn polytropic_energy<S: Real>(&self, flows: &Flows<S>, work: &[S; VOLUMES]) -> [S; VOLUMES] {
        let m = &self.p.model;
        let (inward, outward) = (m.polytropic_inflow, m.polytropic_outflow);
        // The amounts that a flow removes from its source and adds to its destination, depending on its direction.
        let weigh = |flow: S, forth: f64, back: f64| {
            if flow.value() >= 0.0 {
                (flow * forth, flow * inward)
            } else {
                (flow * inward, flow * back)
            }
        };
        let exhaust = weigh(flows.exhaust.mass, outward, inward).0;
        let intake = weigh(flows.intake, inward, outward);
        let check = weigh(flows.check, inward, inward);
        let foot = weigh(flows.foot, inward, inward);
        let leak = weigh(flows.leak, outward, inward).0;
        let ChannelFlow { vent, fill, drain } = flows.channel;
        let growth = [
            intake.1 - exhaust - check.0,
            -foot.0 - leak,
            check.1 + foot.1,
            (fill.mass - vent.mass) * inward,
            (flows.hose - drain.mass) * inward - intake.0,
        ];
        let rt = self.air.gas_constant * self.p.ambient.temperature;
        let scale = 1.0 / (self.air.gamma - 1.0);
        std::array::from_fn(|i| (growth[i] * rt - work[i] * (m.polytropic - 1.0)) * scale)
    }
}
