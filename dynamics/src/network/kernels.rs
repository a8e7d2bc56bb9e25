//! Constitutive laws of the blocks, generic over `f64` and dual numbers.

use std::f64::consts::PI;

use super::assembly::ContactDamping;
use super::mode::{Mode, depth, friction};
use super::plan::{
    AreaPlan, CoefficientPlan, ContactPlan, FastenerPlan, FrictionPlan, HoldPlan, MotorPlan, PassagePlan,
    RestrictionPlan, SpringPlan,
};
use super::resistance::{ShankLaw, interpolate};
use nailnoise_penetration::Real;

use super::gas::{Air, Gas};

/// A force and its dashpot contribution \[N\].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Damped<S> {
    pub(crate) force: S,
    pub(crate) dashpot: S,
}

impl<S: Real> Damped<S> {
    pub(crate) fn none() -> Self {
        Self {
            force: S::constant(0.0),
            dashpot: S::constant(0.0),
        }
    }
}

/// Flow through a passage.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Flow<S> {
    /// From its first to its second end \[kg/s\].
    pub(crate) mass: S,
    /// Enthalpy it carries \[W\].
    pub(crate) enthalpy: S,
    /// Pressures downstream of the first and the second restriction of a series \[Pa\].
    pub(crate) between: [S; 2],
}

impl<S: Real> Flow<S> {
    /// No flow towards a space with this pressure.
    #[inline]
    pub(crate) fn none(pressure: S) -> Self {
        Self {
            mass: S::constant(0.0),
            enthalpy: S::constant(0.0),
            between: [pressure; 2],
        }
    }
}

/// Variables that determine a passage's flow.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ends<S> {
    pub(crate) from: Gas<S>,
    pub(crate) to: Gas<S>,
    /// Travels that open its restrictions \[m\].
    pub(crate) travel: [S; 2],
}

impl ContactPlan {
    /// u and u' from the travel and its rate.
    #[inline]
    pub(crate) fn overlap<S: Real>(&self, x: S, v: S) -> (S, S) {
        ((x - self.at) * self.side, v * self.side)
    }

    /// Force of the closed contact as a function of overlap and rate,
    ///
    /// ```text
    /// f = k u^n + c u',   or   k u^n (1 + 1.5 a u')        (Hunt and Crossley 1975)
    /// ```
    #[inline]
    pub(crate) fn push<S: Real>(&self, u: S, rate: S) -> Damped<S> {
        let elastic = if self.exponent == 1.0 {
            u * self.stiffness
        } else {
            let (size, n) = (u.value().abs(), self.exponent);
            let slope = self.stiffness * n * size.powf(n - 1.0);
            u.chain(slope * u.value() / n, slope)
        };
        let dashpot = match self.damping {
            ContactDamping::Dashpot(c) => rate * c,
            ContactDamping::HuntCrossley(a) => elastic * rate * (1.5 * a),
        };
        Damped {
            force: elastic + dashpot,
            dashpot,
        }
    }

    /// Positive while a closed contact pushes, or while an open one would push; expressed as a length.
    pub(crate) fn pressing(&self, u: f64, rate: f64) -> f64 {
        match self.damping {
            _ if self.may_pull => u,
            ContactDamping::Dashpot(c) if self.exponent == 1.0 => u + c / self.stiffness * rate,
            ContactDamping::Dashpot(_) => self.push(u, rate).force / self.stiffness,
            ContactDamping::HuntCrossley(a) => u.min(1.0 + 1.5 * a * rate),
        }
    }

    /// Energy of the closed contact at a given overlap \[J\].
    pub(crate) fn energy(&self, u: f64) -> f64 {
        let n = self.exponent;
        if n == 1.0 {
            0.5 * self.stiffness * u * u
        } else {
            self.stiffness * u.abs().powf(n + 1.0) / (n + 1.0)
        }
    }
}

impl SpringPlan {
    /// e from the travel.
    #[inline]
    pub(crate) fn compression<S: Real>(&self, x: S) -> S {
        (x - self.free) * -self.sign + self.preload
    }

    /// Force on `on`, s F(e) - c x'.
    #[inline]
    pub(crate) fn force<S: Real>(&self, x: S, v: S) -> Damped<S> {
        let elastic = self.compression(x).polynomial(&self.law) * self.sign;
        if self.damping == 0.0 {
            return Damped {
                force: elastic,
                dashpot: S::constant(0.0),
            };
        }
        let dashpot = v * -self.damping;
        Damped {
            force: elastic + dashpot,
            dashpot,
        }
    }

    /// Integral of F over e \[J\].
    pub(crate) fn energy(&self, x: f64) -> f64 {
        let e = self.compression(x);
        let integral = |sum: f64, (i, c): (usize, &f64)| sum * e + c / (i as f64 + 1.0);
        self.law.iter().enumerate().rev().fold(0.0, integral) * e
    }
}

/// tanh x, which equals +-1 to the last digit beyond 20.
#[inline]
fn saturating_tanh(x: f64) -> f64 {
    if x.abs() > 20.0 { x.signum() } else { x.tanh() }
}

impl FrictionPlan {
    /// Friction opposing the motion, and its dissipating part.
    ///
    /// ```text
    /// F = [F_d + (F_s - F_d) exp(-(v/v_st)^2)] tanh(v/v_0) + beta v        smooth (C-19)
    ///     the same with the sign of the sliding for tanh                   sliding, where it may stick
    ///     k (x - x_s) + c v                                                stuck at x_s
    /// ```
    #[inline]
    pub(crate) fn force<S: Real>(&self, mode: &Mode, x: S, v: S) -> Damped<S> {
        let sign = match &self.stick {
            None => None,
            Some(stick) => match mode.switches[stick.switch] {
                friction::FORTH => Some(1.0),
                friction::BACK => Some(-1.0),
                friction::STUCK => {
                    let dashpot = v * stick.damping;
                    return Damped {
                        force: (x - mode.memory[stick.place]) * stick.stiffness + dashpot,
                        dashpot,
                    };
                }
                _ => return Damped::none(),
            },
        };
        let speed = v.value();
        let w = speed / self.stribeck;
        let stribeck = if w.abs() < 30.0 { (-w * w).exp() } else { 0.0 };
        let fall = (self.static_force - self.sliding_force) * stribeck;
        let level = self.sliding_force + fall;
        let (turn, turning) = match sign {
            Some(sign) => (sign, 0.0),
            None => {
                let turn = saturating_tanh(speed / self.width);
                (turn, (1.0 - turn * turn) / self.width)
            }
        };
        let force = level * turn + self.viscous * speed;
        let slope = level * turning - 2.0 * w / self.stribeck * fall * turn + self.viscous;
        let force = v.chain(force, slope);
        Damped { force, dashpot: force }
    }
}

impl MotorPlan {
    /// Force on `on`, s stall max(0, 1 - s v/free_speed).
    #[inline]
    pub(crate) fn force<S: Real>(&self, v: S) -> S {
        let pull = v * (-self.sign / self.free_speed) + 1.0;
        if pull.value() > 0.0 {
            pull * (self.sign * self.stall)
        } else {
            S::constant(0.0)
        }
    }
}

impl HoldPlan {
    /// Force on `on` of the latch that caught at `place`.
    #[inline]
    pub(crate) fn force<S: Real>(&self, place: f64, x: S, v: S) -> Damped<S> {
        let dashpot = v * -self.damping;
        Damped {
            force: (x - place) * -self.stiffness + dashpot,
            dashpot,
        }
    }
}

impl FastenerPlan {
    /// F_r(z, v) after an impact, smoothly continued above the surface \[N\].
    #[inline]
    fn shank<S: Real>(&self, z: S, v: S, impact: f64) -> S {
        match &self.law {
            ShankLaw::Solid(curve) => curve.evaluate(z),
            ShankLaw::Constant(force) => S::constant(*force),
            ShankLaw::Table(points) => {
                let (force, slope) = interpolate(points, z.value());
                z.chain(force, slope)
            }
            ShankLaw::Envelope(envelope) => envelope.law().evaluate(z, v, impact),
        }
    }

    /// Force beyond the length, where the head sinks into the work \[N\].
    #[inline]
    fn seated<S: Real>(&self, z: S, v: S, impact: f64) -> S {
        let sunk = z - self.length;
        match &self.law {
            ShankLaw::Envelope(envelope) => envelope.head_at(z) + envelope.seated(v, impact),
            _ if self.reversible => sunk * self.head_stiffness,
            _ => sunk * self.head_stiffness + self.shank(self.length, 0.0, impact),
        }
    }

    /// Force of the workpiece on the driver, upwards, at depth z and its rate v in a mode of the fastener \[N\].
    #[inline]
    pub(crate) fn force<S: Real>(&self, mode: &Mode, z: S, v: S) -> S {
        match mode.switches[self.depth] {
            depth::LOADING => self.shank(z, v, mode.memory[self.impact_speed]),
            depth::SEATED => self.seated(z, v, mode.memory[self.impact_speed]),
            depth::UNLOADING => {
                let [deepest, force] = [mode.memory[self.deepest], mode.memory[self.deepest + 1]];
                (z - deepest) * self.unloading + force
            }
            _ => S::constant(0.0),
        }
    }

    /// E(z) at rest after the impact of a mode \[N\].
    pub(crate) fn envelope(&self, mode: &Mode, z: f64) -> f64 {
        let impact = mode.memory[self.impact_speed];
        if z <= 0.0 {
            0.0
        } else if z > self.length {
            self.seated(z, 0.0, impact)
        } else {
            self.shank(z, 0.0, impact)
        }
    }

    /// Friction of the guide on the driver, opposing the velocity \[N\].
    #[inline]
    pub(crate) fn guide<S: Real>(&self, v: S) -> S {
        let turn = saturating_tanh(v.value() / self.guide_width);
        v.chain(
            self.guide_friction * turn,
            self.guide_friction * (1.0 - turn * turn) / self.guide_width,
        )
    }
}

impl RestrictionPlan {
    /// C A, excluding a coefficient that depends on the pressure ratio \[m2\].
    #[inline]
    fn area<S: Real>(&self, travel: [S; 2], t: f64) -> S {
        let bare = match &self.area {
            AreaPlan::Constant(area) => return S::constant(*area),
            AreaPlan::Ramp { area, time } => return S::constant(area * (t / time).clamp(0.0, 1.0)),
            AreaPlan::Seat {
                travel: way,
                diameter,
                sine,
                slope,
            } => {
                let opening = (travel[way.input] - way.at) * way.sign;
                opening * (PI * sine) * (opening * *slope + *diameter)
            }
            AreaPlan::Holes {
                travel: way,
                area,
                diameter,
            } => match diameter {
                None => S::constant(*area),
                Some(d) => {
                    let opening = (travel[way.input] - way.at) * way.sign;
                    // Segment of the circle, (p - sin p cos p)/pi of its area with cos p = 1 - 2 Y/d.
                    let p = (1.0 - 2.0 * opening.value() / d).clamp(-1.0, 1.0).acos();
                    opening.chain(area * (p - p.sin() * p.cos()) / PI, 4.0 * area * p.sin() / (PI * d))
                }
            },
        };
        match self.coefficient {
            CoefficientPlan::Constant(c) => bare * c,
            CoefficientPlan::Ratio { .. } => bare,
        }
    }

    /// Coefficient that depends on the pressure ratio.
    #[inline]
    fn coefficient<S: Real>(&self, up: S, down: S) -> Option<S> {
        let CoefficientPlan::Ratio { polynomial, from, to } = &self.coefficient else {
            return None;
        };
        let ratio = down * up.recip();
        let inside = if ratio.value() < *from {
            S::constant(*from)
        } else if ratio.value() > *to {
            S::constant(*to)
        } else {
            ratio
        };
        Some(inside.polynomial(polynomial))
    }
}

impl PassagePlan {
    /// Whether gate and restrictions allow flow.
    #[inline]
    pub(crate) fn is_open(&self, mode: &Mode) -> bool {
        !self.shut && self.switches.iter().all(|switch| mode.is_on(*switch))
    }

    /// Flow in a mode; `near` is a recent value of the pressure between two restrictions.
    ///
    /// The same mass flow passes all restrictions; the temperature in each is that of the upstream end (C-15).
    #[inline]
    pub(crate) fn flow<S: Real>(&self, air: &Air, mode: &Mode, ends: &Ends<S>, t: f64, near: Option<f64>) -> Flow<S> {
        if self.is_open(mode) {
            self.through(air, ends, t, near)
        } else {
            self.still(ends)
        }
    }

    /// No flow.
    #[inline]
    pub(crate) fn still<S: Real>(&self, ends: &Ends<S>) -> Flow<S> {
        Flow::none(ends.to.pressure)
    }

    /// Mass and energy that leave the first space, and those that reach the second.
    #[inline]
    pub(crate) fn carried<S: Real>(&self, leaving: &Flow<S>, arriving: &Flow<S>) -> [[S; 2]; 2] {
        let [out, into] = [leaving, arriving];
        match self.weights {
            None => [[out.mass, out.enthalpy], [into.mass, into.enthalpy]],
            Some([first, second, inflow]) => {
                let from = if out.mass.value() >= 0.0 { first } else { inflow };
                let to = if into.mass.value() >= 0.0 { inflow } else { second };
                [[out.mass, out.mass * from], [into.mass, into.mass * to]]
            }
        }
    }

    /// Flow through the open passage.
    #[inline]
    pub(crate) fn through<S: Real>(&self, air: &Air, ends: &Ends<S>, t: f64, near: Option<f64>) -> Flow<S> {
        let Ends { from, to, travel } = *ends;
        let forward = from.pressure.value() >= to.pressure.value();
        if self.one_way && from.pressure.value() <= to.pressure.value() {
            return self.still(ends);
        }
        let (up, down) = if forward { (from, to) } else { (to, from) };
        let (rate, between) = match &self.restrictions[..] {
            [one] => {
                let area = one.area(travel, t);
                let area = match one.coefficient(up.pressure, down.pressure) {
                    Some(coefficient) => area * coefficient,
                    None => area,
                };
                (air.flow(area, up, down.pressure), [to.pressure; 2])
            }
            [first, second] => {
                let [a, b] = [first, second].map(|r| r.area(travel, t));
                let areas = if forward { [a, b] } else { [b, a] };
                if let Some(shut) = areas.into_iter().find(|a| a.value() <= 0.0) {
                    // Extends the flow smoothly beyond the closing of a seat.
                    (air.flow(shut, up, down.pressure), [to.pressure; 2])
                } else {
                    let middle = air.intermediate_pressure(areas[0], areas[1], up.pressure, down.pressure, near);
                    let rate = if forward {
                        let at_second = Gas {
                            pressure: middle,
                            temperature: up.temperature,
                        };
                        air.flow(areas[1], at_second, down.pressure)
                    } else {
                        air.flow(areas[0], up, middle)
                    };
                    (rate, [middle, to.pressure])
                }
            }
            [first, second, third] => {
                let mut areas = [first, second, third].map(|r| r.area(travel, t));
                if !forward {
                    areas.reverse();
                }
                if let Some(shut) = areas.into_iter().find(|a| a.value() <= 0.0) {
                    (air.flow(shut, up, down.pressure), [to.pressure; 2])
                } else {
                    let mut between = air.two_intermediate_pressures(areas, up.pressure, down.pressure);
                    let rate = if forward {
                        let at_second = Gas {
                            pressure: between[0],
                            temperature: up.temperature,
                        };
                        air.flow(areas[1], at_second, between[1])
                    } else {
                        air.flow(areas[0], up, between[0])
                    };
                    if !forward {
                        between.reverse();
                    }
                    (rate, between)
                }
            }
            _ => (S::constant(0.0), [to.pressure; 2]),
        };
        let mass = if forward { rate } else { -rate };
        let source = if mass.value() >= 0.0 { from } else { to };
        Flow {
            mass,
            enthalpy: mass * source.temperature * air.cp,
            between,
        }
    }

    /// Positive while the last restriction in flow direction is choked, negative if the passage is closed \[Pa or N\].
    ///
    /// For two restrictions, it is the flow through the first at the critical intermediate pressure minus that through
    /// the second, (C A P)_1 N(P_m/P_1) - (C A)_2 P_m with P_m = P_d/P_cr. This does not require solving the series.
    pub(crate) fn choking(&self, air: &Air, mode: &Mode, ends: &Ends<f64>, t: f64) -> f64 {
        let Ends { from, to, travel } = *ends;
        let forward = from.pressure >= to.pressure;
        if !self.is_open(mode) || (self.one_way && !forward) {
            return -1.0;
        }
        let (up, down) = if forward { (from, to) } else { (to, from) };
        match &self.restrictions[..] {
            [_] => air.critical * up.pressure - down.pressure,
            [first, second] => {
                let [a, b] = [first, second].map(|r| r.area(travel, t));
                let (first, second) = if forward { (a, b) } else { (b, a) };
                let between = down.pressure / air.critical;
                if first <= 0.0 || up.pressure <= between {
                    return -second * between;
                }
                first * up.pressure * air.flow_function(between / up.pressure).0 - second * between
            }
            _ => {
                let between = self.flow(air, mode, ends, t, None).between;
                air.critical * if forward { between[1] } else { between[0] } - down.pressure
            }
        }
    }

    /// Pressure upstream and downstream of a restriction \[Pa\].
    #[inline]
    pub(crate) fn pressures_at<S: Real>(&self, restriction: usize, ends: &Ends<S>, flow: &Flow<S>) -> [S; 2] {
        let inside = |i: usize| flow.between[i.min(1)];
        let before = restriction.checked_sub(1).map_or(ends.from.pressure, inside);
        let last = restriction + 1 >= self.restrictions.len();
        [before, if last { ends.to.pressure } else { inside(restriction) }]
    }

    /// Thrust of the jet from the last restriction \[N\]; zero for inflow.
    #[inline]
    pub(crate) fn thrust<S: Real>(&self, air: &Air, ends: &Ends<S>, flow: &Flow<S>, t: f64) -> S {
        let last = self.restrictions.len() - 1;
        if flow.mass.value() <= 0.0 {
            return S::constant(0.0);
        }
        let [before, behind] = self.pressures_at(last, ends, flow);
        air.thrust(before, behind) * self.restrictions[last].area(ends.travel, t)
    }
}
