//! The model's equations for a fixed mode.

use std::f64::consts::PI;

use super::gas::{Air, Gas};
use super::history::{Past, Stream};
use super::mode::{Channel, Contact, Mode, NailState, Penetration};
use super::real::Real;
use super::state::*;
use crate::prf::Envelope;
use crate::{Form, Geometry, Parameters};

/// Coefficients of the head valve's closing spring, F(y) in N, y in m (Eq. 4.60, as printed; C-24).
pub(crate) const SPRING: [f64; 9] = [
    4.17, 79_135.7, -7.55e7, 3.56e10, -8.57e12, 1.13e15, -8.28e16, 3.14e18, -4.79e19,
];

/// Largest compression of the closing spring the published characteristic holds for \[m\] (C-24).
pub(crate) const SPRING_LIMIT: f64 = 5e-3;

/// Coefficients of the intake's flow coefficient C_f(P_d/P_u) and the range of the ratio (Eq. 4.35).
const POPPET: [f64; 4] = [1.1, -0.71, 0.49, -0.14];
const POPPET_RANGE: (f64, f64) = (0.390, 0.913);

/// Spring and dashpot of a contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pad {
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
    pub(crate) pads: [Pad; Contact::COUNT],
    /// k_esg = k_sg k_wsn/(k_sg + k_wsn) (C-12).
    pub(crate) guard_stiffness: f64,
    /// A_h3 as far as P_1 acts on it, zero in the published form (C-06).
    pub(crate) underside_area: f64,
    /// Areas by which the valve sweeps the volume above the piston and the supply side, zero in the published form
    /// (C-07).
    sweep: [f64; 2],
    pub(crate) envelope: Envelope,
    /// C_d A of check-ring holes, return holes, leak, hose and exhaust holes \[m2\].
    check_area: f64,
    return_area: f64,
    leak_area: f64,
    hose_area: f64,
    exhaust_area: f64,
    vent_area: f64,
    fill_area: f64,
    /// Sine and cosine of the seats' angles.
    intake_angle: (f64, f64),
    exhaust_angle: (f64, f64),
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

/// Flow through the trigger's channel: out of h to the atmosphere, into h, and out of ext.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ChannelFlow<S> {
    pub(crate) vent: Stream<S>,
    fill: Stream<S>,
    drain: Stream<S>,
}

/// Forces, flows and accelerations.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Evaluation<S> {
    pub(crate) instant: Instant<S>,
    pub(crate) acceleration: [S; 4],
    /// Contact pushes, >= 0 except where a dashpot pulls just before the contact opens.
    pub(crate) push: [S; Contact::COUNT],
    /// The dashpots' parts of the pushes.
    dashpot: [S; Contact::COUNT],
    pub(crate) piston_gas: S,
    pub(crate) valve_gas: S,
    pub(crate) spring: S,
    pub(crate) piston_friction: S,
    pub(crate) valve_friction: S,
    pub(crate) penetration: S,
    pub(crate) guard: S,
    /// Flow 1 -> exhaust, ext -> 1, 1 -> r, 2 -> r, 2 -> atmosphere, through the trigger's channel, hose -> ext.
    pub(crate) exhaust: S,
    pub(crate) intake: S,
    check: S,
    foot: S,
    pub(crate) leak: S,
    pub(crate) channel: ChannelFlow<S>,
    pub(crate) hose: S,
    /// P_m.
    pub(crate) plenum: S,
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
        let ratio = |zeta: f64, k: f64, mass: f64| Pad {
            stiffness: k,
            damping: 2.0 * zeta * (k * mass).sqrt(),
        };
        let pads = [
            Pad {
                stiffness: c.bumper_stiffness,
                damping: c.bumper_damping,
            },
            Pad {
                stiffness: c.stopper_stiffness,
                damping: c.stopper_damping,
            },
            ratio(c.valve_damping_ratio, c.cap_stiffness, p.head_valve.mass),
            ratio(c.valve_damping_ratio, c.seat_stiffness, p.head_valve.mass),
            ratio(c.nose_damping_ratio, c.nose_stiffness, p.tool.mass),
            Pad {
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
            envelope: Envelope::new(p),
            check_area: cd * p.chambers.check_hole_area,
            return_area: cd * p.chambers.return_hole_area,
            leak_area: cd * p.chambers.leak_area,
            hose_area: if refill { cd * p.supply.hose_area } else { 0.0 },
            exhaust_area: geometry.exhaust_area,
            vent_area: p.trigger.vent_area * geometry.attenuation_vent,
            fill_area: p.trigger.fill_area * geometry.attenuation_fill,
            intake_angle: p.head_valve.intake_angle.sin_cos(),
            exhaust_angle: p.head_valve.exhaust_angle.sin_cos(),
            pads,
            air,
            geometry,
            p: p.clone(),
        }
    }

    /// Depth of the nail's tip, z = y_p - y_w - y_pbp.
    pub(crate) fn depth<S: Real>(&self, y: &[S]) -> S {
        y[Y_P] - y[Y_W] - self.p.nail.tip_gap
    }

    /// Overlap of a contact and its rate.
    pub(crate) fn overlap<S: Real>(&self, contact: Contact, y: &[S]) -> (S, S) {
        match contact {
            Contact::Bumper => (y[Y_P] - y[Y_G] - self.p.piston.stroke, y[V_P] - y[V_G]),
            Contact::Stopper => (y[Y_G] - y[Y_P], y[V_G] - y[V_P]),
            Contact::Cap => (y[Y_G] - y[Y_H], y[V_G] - y[V_H]),
            Contact::Seat => (y[Y_H] - y[Y_G] - self.p.head_valve.lift, y[V_H] - y[V_G]),
            Contact::Nose => (y[Y_G] - y[Y_W], y[V_G] - y[V_W]),
            Contact::Support => (y[Y_W], y[V_W]),
        }
    }

    /// M_t, mass that moves with the piston.
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

    /// All forces and flows at a state \[N, kg/s\], thesis Eqs. 4.1 to 4.60 as corrected.
    pub(crate) fn evaluate<S: Real>(&self, y: &[S], mode: &Mode, past: &Past) -> Evaluation<S> {
        let (p, g) = (&self.p, &self.geometry);
        let air = &self.air;
        let instant = self.instant(y);
        let Instant {
            travel_rate,
            valve,
            valve_rate,
            gas,
            ..
        } = instant;
        let lift = -valve + p.head_valve.lift;
        let zero = S::constant(0.0);
        let ambient = Gas {
            pressure: S::constant(p.ambient.pressure),
            temperature: S::constant(p.ambient.temperature),
        };

        let piston_gas =
            gas[ABOVE].pressure * g.piston_area - gas[BELOW].pressure * g.ring_area - p.ambient.pressure * g.rod_area;
        let valve_gas = gas[CONTROL].pressure * g.valve_control_area
            - gas[SUPPLY].pressure * g.valve_supply_area
            - gas[ABOVE].pressure * self.underside_area;

        let mut push = [zero; Contact::COUNT];
        let mut dashpot = [zero; Contact::COUNT];
        for contact in Contact::ALL {
            if mode.closed(contact) {
                let pad = self.pads[contact as usize];
                let (u, rate) = self.overlap(contact, y);
                dashpot[contact as usize] = rate * pad.damping;
                push[contact as usize] = u * pad.stiffness + dashpot[contact as usize];
            }
        }
        let [bumper, stopper, cap, seat, nose, support] = push;

        let gap = y[Y_G] - y[Y_W];
        let guard = if mode.guard {
            (gap + p.contacts.guard_travel) * self.guard_stiffness
        } else {
            zero
        };
        let spring = (lift + p.head_valve.spring_preload).polynomial(&SPRING);
        let piston_friction = self.friction(&p.piston.friction, travel_rate);
        let valve_friction = self.friction(&p.head_valve.friction, valve_rate);

        let z = self.depth(y);
        let penetration = match mode.penetration {
            Penetration::Free { .. } => zero,
            Penetration::Loading { seated: false } => self.envelope.curve().evaluate(z),
            Penetration::Loading { seated: true } => {
                (z - p.nail.length) * self.envelope.head_stiffness() + self.envelope.seated()
            }
            Penetration::Unloading { deepest, force } => (z - deepest) * p.wood.unloading_stiffness + force,
        };

        let moving = self.moving_mass(mode);
        let gravity = p.ambient.gravity;
        // Forces between the body and its moving parts, down on the parts.
        let on_piston = piston_gas - bumper + stopper - piston_friction;
        let on_valve = valve_gas + spring + cap - seat - valve_friction;
        let acceleration = [
            (on_piston - penetration) * (1.0 / moving) + gravity,
            on_valve * (1.0 / p.head_valve.mass) + gravity,
            (-on_piston - on_valve - nose - guard + p.hand.force) * (1.0 / p.tool.mass) + gravity,
            (penetration + nose + guard - support) * (1.0 / g.workpiece_mass) + gravity,
        ];

        let intake = if mode.intake {
            self.intake_flow(lift - p.head_valve.intake_lap, gas[SUPPLY], gas[ABOVE])
        } else {
            zero
        };
        let (exhaust, plenum) = if mode.exhaust {
            self.exhaust_flow(-lift + p.head_valve.exhaust_lap, gas[ABOVE], ambient)
        } else {
            (zero, ambient.pressure)
        };
        let check = if mode.check_holes && gas[ABOVE].pressure.value() > gas[RETURN].pressure.value() {
            air.flow(S::constant(self.check_area), gas[ABOVE], gas[RETURN].pressure)
        } else {
            zero
        };
        let foot = air.exchange(self.return_area, gas[BELOW], gas[RETURN]);
        // Published, nothing flows in from the atmosphere and the intake has one way.
        let both_ways = p.model.intake == Form::Corrected;
        let outward = |flow: S| if both_ways || flow.value() > 0.0 { flow } else { zero };
        let (intake, exhaust) = (outward(intake), outward(exhaust));
        let leak = if self.leak_area > 0.0 {
            outward(air.exchange(self.leak_area, gas[BELOW], ambient))
        } else {
            zero
        };
        let mut channel = ChannelFlow {
            vent: Stream::still(),
            fill: Stream::still(),
            drain: Stream::still(),
        };
        if p.model.delay == Form::Corrected {
            match mode.channel {
                Channel::Closed => {}
                Channel::Venting => channel.vent = self.stream(&gas, false),
                Channel::Filling => channel.fill = self.stream(&gas, true),
            }
        } else {
            match mode.channel {
                Channel::Closed => {}
                Channel::Venting => channel.vent = past.vent.lift(),
                Channel::Filling => channel.fill = past.fill.lift(),
            }
        }
        channel.drain = match p.model.channel {
            Form::Corrected => channel.fill,
            // Neither delayed nor attenuated (C-03).
            Form::Published if mode.released => self.stream(&gas, true).scaled(1.0 / self.geometry.attenuation_fill),
            Form::Published => Stream::still(),
        };
        let hose = if self.hose_area > 0.0 && gas[SUPPLY].pressure.value() < p.supply.pressure {
            let source = Gas {
                pressure: S::constant(p.supply.pressure),
                ..ambient
            };
            air.flow(S::constant(self.hose_area), source, gas[SUPPLY].pressure)
        } else {
            zero
        };
        Evaluation {
            instant,
            acceleration,
            push,
            dashpot,
            piston_gas,
            valve_gas,
            spring,
            piston_friction,
            valve_friction,
            penetration,
            guard,
            exhaust,
            intake,
            check,
            foot,
            leak,
            channel,
            hose,
            plenum,
        }
    }

    /// dy/dt of states and integrals.
    pub(crate) fn rates<S: Real>(&self, y: &[S], mode: &Mode, past: &Past) -> [S; SIZE] {
        let e = self.evaluate(y, mode, past);
        let (p, g) = (&self.p, &self.geometry);
        let cp = self.air.cp;
        let ta = p.ambient.temperature;
        let Instant {
            travel,
            travel_rate,
            valve_rate,
            gas,
            ..
        } = e.instant;
        let mut rate = [S::constant(0.0); SIZE];
        for body in 0..4 {
            rate[2 * body] = y[2 * body + 1];
            rate[2 * body + 1] = e.acceleration[body];
        }

        // Flow carries the enthalpy of where it comes from.
        let from = |flow: S, source: S, target: S| if flow.value() >= 0.0 { flow * source } else { flow * target } * cp;
        let t = gas.map(|gas| gas.temperature);
        let outside = S::constant(ta);
        let exhaust_h = from(e.exhaust, t[ABOVE], outside);
        let intake_h = from(e.intake, t[SUPPLY], t[ABOVE]);
        let check_h = e.check * t[ABOVE] * cp;
        let foot_h = from(e.foot, t[BELOW], t[RETURN]);
        let leak_h = from(e.leak, t[BELOW], outside);
        let ChannelFlow { vent, fill, drain } = e.channel;
        let hose_h = e.hose * (cp * ta);

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
            e.intake - e.exhaust - e.check,
            -e.foot - e.leak,
            e.check + e.foot,
            fill.mass - vent.mass,
            e.hose - e.intake - drain.mass,
        ];
        let sum = |terms: [S; VOLUMES]| terms[0] + terms[1] + terms[2] + terms[3] + terms[4];
        for i in 0..VOLUMES {
            rate[ENERGY + i] = inflow_h[i] + heat[i] - work[i];
            rate[MASS + i] = inflow[i];
        }
        if p.model.gas == Form::Published {
            let polytropic = self.polytropic_energy(&e, &work);
            rate[ENERGY..ENERGY + VOLUMES].copy_from_slice(&polytropic);
        }
        rate[EXHAUST_MASS] = e.exhaust;
        rate[VENT_MASS] = vent.mass;
        rate[LEAK_MASS] = e.leak;
        rate[SUPPLY_MASS] = e.hose;
        rate[EXHAUST_ENTHALPY] = exhaust_h;
        rate[VENT_ENTHALPY] = vent.enthalpy;
        rate[LEAK_ENTHALPY] = leak_h;
        rate[SUPPLY_ENTHALPY] = hose_h;
        rate[HEAT] = sum(heat);
        rate[GAS_WORK] = sum(work);
        rate[PISTON_FRICTION] = e.piston_friction * travel_rate;
        rate[VALVE_FRICTION] = e.valve_friction * valve_rate;
        rate[PENETRATION] = e.penetration * (y[V_P] - y[V_W]);
        for contact in Contact::ALL {
            if mode.closed(contact) {
                let i = contact as usize;
                rate[DASHPOTS + i] = e.dashpot[i] * self.overlap(contact, y).1;
            }
        }
        rate[SUPPORT_IMPULSE] = e.push[Contact::Support as usize];
        let weight = (self.moving_mass(mode) + p.head_valve.mass + p.tool.mass + g.workpiece_mass) * p.ambient.gravity;
        rate[OUTER_IMPULSE] = S::constant(p.hand.force + weight);
        rate
    }

    /// dU/dt of the published gas law, for the energy U = P V/(gamma - 1) that is carried (C-02).
    ///
    /// ```text
    /// P' = R T_a/V (alpha_in sum(in) - alpha_o sum(out)) - alpha P V'/V
    /// ```
    /// with alpha_o = alpha_out from 1 to the atmosphere or back into ext and from 2 to the atmosphere, alpha_in for
    /// every other outflow.
    fn polytropic_energy<S: Real>(&self, e: &Evaluation<S>, work: &[S; VOLUMES]) -> [S; VOLUMES] {
        let m = &self.p.model;
        let (inward, outward) = (m.polytropic_inflow, m.polytropic_outflow);
        // What a flow takes from where it starts and gives to where it ends, by its direction.
        let weigh = |flow: S, forth: f64, back: f64| {
            if flow.value() >= 0.0 {
                (flow * forth, flow * inward)
            } else {
                (flow * inward, flow * back)
            }
        };
        let exhaust = weigh(e.exhaust, outward, inward).0;
        let intake = weigh(e.intake, inward, outward);
        let check = weigh(e.check, inward, inward);
        let foot = weigh(e.foot, inward, inward);
        let leak = weigh(e.leak, outward, inward).0;
        let ChannelFlow { vent, fill, drain } = e.channel;
        let growth = [
            intake.1 - exhaust - check.0,
            -foot.0 - leak,
            check.1 + foot.1,
            (fill.mass - vent.mass) * inward,
            (e.hose - drain.mass) * inward - intake.0,
        ];
        let rt = self.air.gas_constant * self.p.ambient.temperature;
        let scale = 1.0 / (self.air.gamma - 1.0);
        std::array::from_fn(|i| (growth[i] * rt - work[i] * (m.polytropic - 1.0)) * scale)
    }

    /// Attenuated flow through the trigger's channel at this instant: h -> atmosphere, or ext -> h when `released`.
    pub(crate) fn stream<S: Real>(&self, gas: &[Gas<S>; VOLUMES], released: bool) -> Stream<S> {
        let ambient = Gas {
            pressure: S::constant(self.p.ambient.pressure),
            temperature: S::constant(self.p.ambient.temperature),
        };
        let (area, from, to) = if released {
            (self.fill_area, gas[SUPPLY], gas[CONTROL])
        } else {
            (self.vent_area, gas[CONTROL], ambient)
        };
        let mass = self.air.exchange(area, from, to);
        if mass.value() < 0.0 && !released && self.p.model.intake == Form::Published {
            return Stream::still();
        }
        let source = if mass.value() >= 0.0 { from } else { to };
        Stream {
            mass,
            enthalpy: mass * source.temperature * self.air.cp,
        }
    }

    /// F_f = [F_d + (F_s - F_d) exp(-(v/v_st)^2)] tanh(v/v_0) + beta v (C-19).
    fn friction<S: Real>(&self, law: &crate::Friction, v: S) -> S {
        let m = &self.p.model;
        let x = v.value();
        let w = x / m.stribeck_velocity;
        let fall = (law.static_force - law.sliding_force) * (-w * w).exp();
        let level = law.sliding_force + fall;
        let turn = (x / m.friction_velocity).tanh();
        let force = level * turn + law.viscous * x;
        let slope = level * (1.0 - turn * turn) / m.friction_velocity - 2.0 * w / m.stribeck_velocity * fall * turn
            + law.viscous;
        v.chain(force, slope)
    }

    /// Area of a conical seat, A = pi Y sin(th) (d - sign Y sin(th) cos(th)).
    fn seat_area<S: Real>(opening: S, angle: (f64, f64), diameter: f64, sign: f64) -> S {
        let (sin, cos) = angle;
        opening * (PI * sin) * (opening * (-sign * sin * cos) + diameter)
    }

    /// Flow ext -> 1 over the opened head valve (Eqs. 4.34, 4.35).
    fn intake_flow<S: Real>(&self, opening: S, from: Gas<S>, to: Gas<S>) -> S {
        let area = Self::seat_area(opening, self.intake_angle, self.p.piston.bore, 1.0);
        let inward = from.pressure.value() >= to.pressure.value();
        let (up, down) = if inward { (from, to) } else { (to, from) };
        let ratio = down.pressure * up.pressure.recip();
        let coefficient = if ratio.value() < POPPET_RANGE.0 {
            S::constant(POPPET_RANGE.0).polynomial(&POPPET)
        } else if ratio.value() > POPPET_RANGE.1 {
            S::constant(POPPET_RANGE.1).polynomial(&POPPET)
        } else {
            ratio.polynomial(&POPPET)
        };
        let flow = self.air.flow(area * coefficient, up, down.pressure);
        if inward { flow } else { -flow }
    }

    /// Flow 1 -> atmosphere through valve seat and holes in series, and P_m between them (C-15, C-16).
    fn exhaust_flow<S: Real>(&self, opening: S, from: Gas<S>, ambient: Gas<S>) -> (S, S) {
        let valve = &self.p.head_valve;
        let cd = self.p.chambers.discharge_coefficient;
        let seat = Self::seat_area(opening, self.exhaust_angle, valve.exhaust_seat_diameter, -1.0);
        let outward = from.pressure.value() >= ambient.pressure.value();
        let (up, down) = if outward { (from, ambient) } else { (ambient, from) };
        if seat.value() <= 0.0 {
            // Continues the flow smoothly past the closing of the seat, to where a step may run before it is cut back.
            let flow = self.air.flow(seat * cd, up, down.pressure);
            return (if outward { flow } else { -flow }, ambient.pressure);
        }
        if outward {
            let plenum =
                self.air
                    .intermediate_pressure(seat, S::constant(self.exhaust_area), up.pressure, down.pressure);
            let at_holes = Gas {
                pressure: plenum,
                temperature: up.temperature,
            };
            (
                self.air
                    .flow(S::constant(cd * self.exhaust_area), at_holes, down.pressure),
                plenum,
            )
        } else {
            // The same law inward: first the holes, then the seat.
            let holes = S::constant(self.exhaust_area);
            let plenum = self.air.intermediate_pressure(holes, seat, up.pressure, down.pressure);
            (-self.air.flow(holes * cd, up, plenum), plenum)
        }
    }
}
