//! Flows between the gas volumes and to the outside.

use std::f64::consts::PI;

use super::gas::Gas;
use super::history::{Past, Stream};
use super::mode::{Channel, Mode};
use super::state::*;
use super::system::{Instant, System};
use crate::Form;
use nailnoise_penetration::Real;

/// Coefficients of the intake's flow coefficient C_f(P_d/P_u), and the range of the pressure ratio (Eq. 4.35).
const POPPET: [f64; 4] = [1.1, -0.71, 0.49, -0.14];
const POPPET_RANGE: (f64, f64) = (0.390, 0.913);

/// Flow through the trigger channel: from h to the atmosphere, into h, and out of ext.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ChannelFlow<S> {
    pub(crate) vent: Stream<S>,
    pub(crate) fill: Stream<S>,
    pub(crate) drain: Stream<S>,
}

/// Flow through the exhaust.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Outflow<S> {
    /// Outward mass flow \[kg/s\].
    pub(crate) mass: S,
    /// P_m upstream of the holes \[Pa\].
    pub(crate) plenum: S,
    /// P_s downstream of the holes, in the muffler if fitted \[Pa\].
    pub(crate) behind: S,
    /// Part of the jets' thrust on the tool, down \[N\].
    pub(crate) thrust: S,
}

/// Mass flows at a state \[kg/s\]: 1 -> exhaust, ext -> 1, 1 -> r, 2 -> r, 2 -> atmosphere, trigger channel, hose ->
/// ext.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Flows<S> {
    pub(crate) exhaust: Outflow<S>,
    pub(crate) intake: S,
    pub(crate) check: S,
    pub(crate) foot: S,
    pub(crate) leak: S,
    pub(crate) channel: ChannelFlow<S>,
    pub(crate) hose: S,
}

impl System {
    /// All flows, thesis Eqs. 4.28 to 4.54 as corrected.
    #[inline]
    pub(crate) fn flows<S: Real>(&self, now: &Instant<S>, mode: &Mode, past: &Past) -> Flows<S> {
        let (p, air, gas) = (&self.p, &self.air, &now.gas);
        let zero = S::constant(0.0);
        let check = if mode.check_holes && gas[ABOVE].pressure.value() > gas[RETURN].pressure.value() {
            air.flow(S::constant(self.check_area), gas[ABOVE], gas[RETURN].pressure)
        } else {
            zero
        };
        let leak = if self.leak_area > 0.0 {
            self.outward(air.exchange(self.leak_area, gas[BELOW], self.ambient()))
        } else {
            zero
        };
        let hose = if self.hose_area > 0.0 && gas[SUPPLY].pressure.value() < p.supply.pressure {
            let source = Gas {
                pressure: S::constant(p.supply.pressure),
                ..self.ambient()
            };
            air.flow(S::constant(self.hose_area), source, gas[SUPPLY].pressure)
        } else {
            zero
        };
        Flows {
            exhaust: self.exhaust(now, mode, None),
            intake: self.intake(now, mode),
            check,
            foot: air.exchange(self.return_area, gas[BELOW], gas[RETURN]),
            leak,
            channel: self.channel(gas, mode, past),
            hose,
        }
    }

    fn ambient<S: Real>(&self) -> Gas<S> {
        Gas {
            pressure: S::constant(self.p.ambient.pressure),
            temperature: S::constant(self.p.ambient.temperature),
        }
    }

    /// In the published form, there is no inflow from the atmosphere and the intake is one-way.
    fn outward<S: Real>(&self, flow: S) -> S {
        if self.p.model.intake == Form::Corrected || flow.value() > 0.0 {
            flow
        } else {
            S::constant(0.0)
        }
    }

    /// Flow ext -> 1 past the open head valve.
    #[inline]
    pub(crate) fn intake<S: Real>(&self, now: &Instant<S>, mode: &Mode) -> S {
        if !mode.intake {
            return S::constant(0.0);
        }
        let valve = &self.p.head_valve;
        let opening = -now.valve + (valve.lift - valve.intake_lap);
        self.outward(self.intake_flow(opening, now.gas[SUPPLY], now.gas[ABOVE]))
    }

    /// Flow 1 -> atmosphere through the exhaust; `near` is a recent value of P_m, if known.
    #[inline]
    pub(crate) fn exhaust<S: Real>(&self, now: &Instant<S>, mode: &Mode, near: Option<f64>) -> Outflow<S> {
        let zero = S::constant(0.0);
        let ambient = self.ambient();
        if !mode.exhaust {
            return Outflow {
                mass: zero,
                plenum: ambient.pressure,
                behind: ambient.pressure,
                thrust: zero,
            };
        }
        let valve = &self.p.head_valve;
        let opening = now.valve - (valve.lift - valve.exhaust_lap);
        let (mass, [plenum, behind]) = self.exhaust_flow(opening, now.gas[ABOVE], ambient, near);
        let mass = self.outward(mass);
        let share = self.p.exhaust.thrust_share;
        let thrust = if share != 0.0 && mass.value() > 0.0 {
            let holes = self.p.exhaust.coefficient(&self.p.chambers) * self.exhaust_area;
            match self.p.muffler_area {
                // The air leaves the tool at the end of the muffler.
                Some(area) => self.air.thrust(behind, ambient.pressure) * (share * area),
                None => self.air.thrust(plenum, ambient.pressure) * (share * holes),
            }
        } else {
            zero
        };
        Outflow {
            mass,
            plenum,
            behind,
            thrust,
        }
    }

    /// Greater than zero while the exhaust holes are choked. It is the flow through the seat at the critical P_m minus
    /// that through the holes, (C A P)_seat N(P_m/P_1) - A_ma P_m, where P_m = P_a/P_cr \[N\] or the value that a
    /// muffler requires.
    pub(crate) fn hole_choking(&self, now: &Instant<f64>) -> f64 {
        let valve = &self.p.head_valve;
        let opening = now.valve - (valve.lift - valve.exhaust_lap);
        let ambient = self.p.ambient.pressure;
        let critical = match self.muffler() {
            None => ambient / self.air.critical,
            Some(muffler) => match self.air.choking_pressure(self.exhaust_area, muffler, ambient) {
                Some(pressure) => pressure,
                // The muffler chokes first, and the holes never do.
                None => return -self.exhaust_area * ambient,
            },
        };
        let holes = self.exhaust_area * critical;
        let p1 = now.gas[ABOVE].pressure;
        if opening <= 0.0 || p1 <= critical {
            return -holes;
        }
        let seat = Self::seat_area(opening, self.exhaust_angle, valve.exhaust_seat_diameter, -1.0);
        seat * p1 * self.air.flow_function(critical / p1).0 - holes
    }

    /// Flow through the trigger channel in the mode's channel state.
    #[inline]
    pub(crate) fn channel<S: Real>(&self, gas: &[Gas<S>; VOLUMES], mode: &Mode, past: &Past) -> ChannelFlow<S> {
        let model = &self.p.model;
        let mut channel = ChannelFlow {
            vent: Stream::still(),
            fill: Stream::still(),
            drain: Stream::still(),
        };
        let delayed = model.delay == Form::Published;
        match mode.channel {
            Channel::Closed => {}
            Channel::Venting if delayed => channel.vent = self.one_way(past.vent.lift()),
            Channel::Venting => channel.vent = self.stream(gas, false),
            Channel::Filling if delayed => channel.fill = self.one_way(past.fill.lift()),
            Channel::Filling => channel.fill = self.stream(gas, true),
        }
        channel.drain = match model.channel {
            Form::Corrected => channel.fill,
            // Neither delayed nor attenuated (C-03).
            Form::Published if mode.released => self.stream(gas, true).scaled(1.0 / self.geometry.attenuation_fill),
            Form::Published => Stream::still(),
        };
        channel
    }

    /// Attenuated flow through the trigger channel at this instant: h -> atmosphere, or ext -> h if `released`.
    pub(crate) fn stream<S: Real>(&self, gas: &[Gas<S>; VOLUMES], released: bool) -> Stream<S> {
        let (area, from, to) = if released {
            (self.fill_area, gas[SUPPLY], gas[CONTROL])
        } else {
            (self.vent_area, gas[CONTROL], self.ambient())
        };
        let mass = self.air.exchange(area, from, to);
        let source = if mass.value() >= 0.0 { from } else { to };
        self.one_way(Stream {
            mass,
            enthalpy: mass * source.temperature * self.air.cp,
        })
    }

    /// In the published form there is no backflow through the channel; an interpolated past flow may be slightly
    /// negative.
    fn one_way<S: Real>(&self, stream: Stream<S>) -> Stream<S> {
        if stream.mass.value() < 0.0 && self.p.model.intake == Form::Published {
            Stream::still()
        } else {
            stream
        }
    }

    /// Area of a conical seat, A = pi Y sin(th) (d - sign Y sin(th) cos(th)).
    fn seat_area<S: Real>(opening: S, angle: (f64, f64), diameter: f64, sign: f64) -> S {
        let (sin, cos) = angle;
        opening * (PI * sin) * (opening * (-sign * sin * cos) + diameter)
    }

    /// Flow ext -> 1 past the open head valve (Eqs. 4.34, 4.35).
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

    /// Area of the muffler referred to the coefficient of the holes, A_s = (C A_s)/C_d \[m2\].
    fn muffler(&self) -> Option<f64> {
        let area = self.p.muffler_area?;
        Some(area / self.p.exhaust.coefficient(&self.p.chambers))
    }

    /// Flow 1 -> atmosphere through valve seat, holes and muffler in series, with P_m upstream and P_s downstream of
    /// the holes (C-15, C-16).
    fn exhaust_flow<S: Real>(&self, opening: S, from: Gas<S>, ambient: Gas<S>, near: Option<f64>) -> (S, [S; 2]) {
        let valve = &self.p.head_valve;
        let cd = self.p.exhaust.coefficient(&self.p.chambers);
        let seat = Self::seat_area(opening, self.exhaust_angle, valve.exhaust_seat_diameter, -1.0);
        let outward = from.pressure.value() >= ambient.pressure.value();
        let (up, down) = if outward { (from, ambient) } else { (ambient, from) };
        if seat.value() <= 0.0 {
            // Extends the flow smoothly beyond the closing of the seat, where a step may go before it is cut back.
            let flow = self.air.flow(seat * cd, up, down.pressure);
            return (if outward { flow } else { -flow }, [ambient.pressure; 2]);
        }
        if let Some(muffler) = self.muffler() {
            let [holes, muffler] = [self.exhaust_area, muffler].map(S::constant);
            return if outward {
                let [plenum, behind] =
                    self.air
                        .two_intermediate_pressures([seat, holes, muffler], up.pressure, down.pressure);
                let at_holes = Gas {
                    pressure: plenum,
                    temperature: up.temperature,
                };
                (self.air.flow(holes * cd, at_holes, behind), [plenum, behind])
            } else {
                let [behind, plenum] =
                    self.air
                        .two_intermediate_pressures([muffler, holes, seat], up.pressure, down.pressure);
                (-self.air.flow(muffler * cd, up, behind), [plenum, behind])
            };
        }
        if outward {
            let plenum =
                self.air
                    .intermediate_pressure(seat, S::constant(self.exhaust_area), up.pressure, down.pressure, near);
            let at_holes = Gas {
                pressure: plenum,
                temperature: up.temperature,
            };
            (
                self.air
                    .flow(S::constant(cd * self.exhaust_area), at_holes, down.pressure),
                [plenum, ambient.pressure],
            )
        } else {
            // The same law for inflow: first the holes, then the seat.
            let holes = S::constant(self.exhaust_area);
            let plenum = self
                .air
                .intermediate_pressure(holes, seat, up.pressure, down.pressure, near);
            (-self.air.flow(holes * cd, up, plenum), [plenum, ambient.pressure])
        }
    }
}
