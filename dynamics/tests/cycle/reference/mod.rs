//! An independent integration of the cycle: pressures as states, branches on the sign of every gap, fixed-step RK4.
//!
//! Written from the published equations without the crate's model code, so that a mistake in either shows. With the
//! forms as published the gas is polytropic, P' = R T/V (sum alpha mdot) - alpha P V'/V, the nail is elastic, and flow
//! through the channel to the valve arrives one wave's time after it entered.

use std::f64::consts::PI;

use nailnoise_dynamics::{Form, Parameters, SupportDamping};

const N: usize = 21;
type Y = [f64; N];

/// Events that are the first passage of a level, and the passage of the full depth.
const LEVELS: usize = 16;

/// The reference's results for a shot up to `end`.
#[derive(Debug, Default)]
#[allow(dead_code)] // each test that includes this reads what it needs
pub(crate) struct Shot {
    /// t0..t18 \[s\].
    pub(crate) events: [Option<f64>; 19],
    /// Time at which the nail's full length is in the wood \[s\].
    pub(crate) full: Option<f64>,
    /// Deepest depth of the nail's tip \[m\].
    pub(crate) depth: f64,
    /// First contact with the bumper \[s\].
    pub(crate) bumper: Option<f64>,
    /// Whether the piston used up the volume below it.
    pub(crate) dry: bool,
}

/// Passages of |v_pr| through a level: times, and whether it rose.
#[derive(Default)]
struct Speed(Vec<(f64, bool)>);

impl Speed {
    fn follow(&mut self, level: f64, t: f64, h: f64, before: f64, after: f64) {
        let (a, b) = (before.abs() - level, after.abs() - level);
        if (a > 0.0) != (b > 0.0) {
            self.0.push((t + h * a / (a - b), b > 0.0));
        }
    }

    /// First instant from `after` on since which the speed has stayed below its level for 2 ms, before `end`.
    fn rest(&self, after: f64, end: f64) -> Option<f64> {
        let slow_at = |t: f64| self.0.iter().rev().find(|c| c.0 <= t).is_none_or(|c| !c.1);
        let falls = self.0.iter().filter(|c| c.0 > after && !c.1).map(|c| c.0);
        let rise = |since: f64| self.0.iter().find(|c| c.0 > since && c.1).map_or(end, |c| c.0.min(end));
        let now = slow_at(after).then_some(after);
        now.into_iter().chain(falls).find(|since| rise(*since) - since >= 2e-3)
    }
}

/// Constants of one design, named as in the thesis.
struct Model {
    p: Parameters,
    a1: f64,
    a2: f64,
    ar: f64,
    ah1: f64,
    ah2: f64,
    ah3: f64,
    ama: f64,
    mn: f64,
    mw: f64,
    tau: f64,
    phi_in: f64,
    phi_out: f64,
    c_ws: f64,
    pcr: f64,
    k: f64,
    n2: f64,
    /// Time of the trigger's release, infinite before.
    released: f64,
    attached: bool,
    left: bool,
    /// Whether every form is the published one.
    published: bool,
    /// Step of the integration, and the flows that entered vent and fill at its ends, with the published forms.
    step: f64,
    entered: Vec<[f64; 2]>,
}

impl Model {
    fn new(p: &Parameters) -> Self {
        let disc = |d: f64| PI / 4.0 * d * d;
        let v = &p.head_valve;
        let air = &p.ambient;
        let (g, r) = (air.heat_capacity_ratio, air.gas_constant);
        let c = (g * r * air.temperature).sqrt();
        let ch = &p.trigger;
        let attenuation = |pressure: f64| {
            let resistance = 32.0 * air.viscosity / ch.channel_diameter.powi(2);
            (-resistance * r * air.temperature * ch.channel_length / (2.0 * pressure * c)).exp()
        };
        let mw = p.workpiece.mass(p.wood.density);
        let n = &p.nail;
        Self {
            a1: disc(p.piston.bore),
            ar: disc(p.piston.rod_diameter),
            a2: disc(p.piston.bore) - disc(p.piston.rod_diameter),
            ah1: disc(v.outer_diameter) - disc(v.inner_diameter),
            ah2: disc(v.outer_diameter) - disc(v.seat_diameter),
            // The published underside bears no pressure.
            ah3: match p.model.gas {
                Form::Published => 0.0,
                Form::Corrected => disc(v.seat_diameter) - disc(v.inner_diameter),
            },
            ama: f64::from(p.exhaust.holes) * disc(p.exhaust.hole_diameter),
            mn: n.density
                * (disc(n.diameter) * (n.length - n.head_thickness) + disc(n.head_diameter) * n.head_thickness),
            mw,
            tau: ch.channel_length / c,
            phi_in: attenuation(p.supply.pressure),
            phi_out: attenuation(air.pressure),
            c_ws: match p.support.damping {
                SupportDamping::Ratio(z) => 2.0 * z * (p.support.stiffness * mw).sqrt(),
                SupportDamping::Coefficient(c) => c,
            },
            pcr: (2.0 / (g + 1.0)).powf(g / (g - 1.0)),
            k: (g / r * (2.0 / (g + 1.0)).powf((g + 1.0) / (g - 1.0))).sqrt(),
            n2: (g - 1.0) / 2.0 * (2.0 / (g + 1.0)).powf((g + 1.0) / (g - 1.0)),
            released: if p.trigger.release_after > 0.0 {
                p.trigger.release_after
            } else {
                f64::INFINITY
            },
            attached: false,
            left: false,
            published: p.model.gas == Form::Published,
            step: f64::NAN,
            entered: Vec::new(),
            p: p.clone(),
        }
    }

    /// Flows into vent and fill from the present pressures, with the published forms.
    fn entering(&self, t: f64, y: &Y) -> [f64; 2] {
        let (p, air) = (&self.p, &self.p.ambient);
        let flow = |pu: f64, pd: f64, area: f64| {
            if pu > pd {
                self.orifice(pu, pd, air.temperature, area)
            } else {
                0.0
            }
        };
        if t < self.released {
            [flow(y[11], air.pressure, p.trigger.vent_area * self.phi_out), 0.0]
        } else {
            [0.0, flow(y[12], y[11], p.trigger.fill_area * self.phi_in)]
        }
    }

    /// Flows that entered vent and fill at a past time, linear between the ends of steps.
    fn arriving(&self, t: f64) -> [f64; 2] {
        let place = t / self.step;
        let (before, share) = (place.floor() as usize, place.fract());
        let node = |at: usize| {
            self.entered
                .get(at)
                .or(self.entered.last())
                .copied()
                .unwrap_or([0.0; 2])
        };
        let (a, b) = (node(before), node(before + 1));
        std::array::from_fn(|i| a[i] + share * (b[i] - a[i]))
    }

    fn nozzle(&self, r: f64) -> f64 {
        let g = self.p.ambient.heat_capacity_ratio;
        let lin = self.p.model.orifice_linear;
        let subsonic = |r: f64| {
            let q = (r.ln() / g).exp();
            ((q * q - q * r) / self.n2).sqrt()
        };
        if r <= self.pcr {
            1.0
        } else if 1.0 - r < lin {
            subsonic(1.0 - lin) * (1.0 - r) / lin
        } else {
            subsonic(r)
        }
    }

    fn orifice(&self, pu: f64, pd: f64, tu: f64, ca: f64) -> f64 {
        ca * self.k * pu * self.nozzle(pd / pu) / tu.sqrt()
    }

    /// Flow and enthalpy flow from a to b.
    fn both(&self, a: (f64, f64), b: (f64, f64), ca: f64) -> (f64, f64) {
        let air = &self.p.ambient;
        let cp = air.heat_capacity_ratio * air.gas_constant / (air.heat_capacity_ratio - 1.0);
        if a.0 >= b.0 {
            let m = self.orifice(a.0, b.0, a.1, ca);
            (m, m * cp * a.1)
        } else {
            let m = self.orifice(b.0, a.0, b.1, ca);
            (-m, -m * cp * b.1)
        }
    }

    /// Series restriction: flow per C_d K/sqrt(T), and the pressure between.
    fn series(&self, first: f64, second: f64, pu: f64, pd: f64) -> (f64, f64) {
        let f = |pm: f64| first * pu * self.nozzle(pm / pu) - second * pm * self.nozzle(pd / pm);
        let (mut a, mut b) = (pd, pu);
        let (mut fa, mut fb) = (f(a), f(b));
        let mut pm = a;
        for _ in 0..60 {
            pm = if fa == fb {
                0.5 * (a + b)
            } else {
                b - fb * (b - a) / (fb - fa)
            };
            let fm = f(pm);
            if fm.abs() <= 1e-13 * second * pu || (b - a).abs() < 1e-12 * pu {
                break;
            }
            if fm * fb < 0.0 {
                (a, fa) = (b, fb);
            } else {
                fa *= 0.5;
            }
            (b, fb) = (pm, fm);
        }
        (second * pm * self.nozzle(pd / pm), pm)
    }

    fn friction(&self, law: &nailnoise_dynamics::Friction, v: f64) -> f64 {
        let m = &self.p.model;
        let stribeck = (law.static_force - law.sliding_force) * (-(v / m.stribeck_velocity).powi(2)).exp();
        (law.sliding_force + stribeck) * (v / m.friction_velocity).tanh() + law.viscous * v
    }

    fn spring(&self, y: f64) -> f64 {
        let c = [
            4.17, 79135.7, -7.55e7, 3.56e10, -8.57e12, 1.13e15, -8.28e16, 3.14e18, -4.79e19,
        ];
        c.iter().rev().fold(0.0, |sum, c| sum * y + c)
    }

    fn envelope(&self, z: f64) -> f64 {
        let (n, w) = (&self.p.nail, &self.p.wood);
        let (ln, hm) = (n.length, w.hardness_modulus);
        if self.published && z > ln {
            return w.head_stiffness_scale * hm * (z - ln);
        }
        let x = z.min(ln) / ln;
        let root = 0.085 + 2.038 * x - 12.95 * x.powi(2) + 46.49 * x.powi(3) - 94.97 * x.powi(4) + 110.18 * x.powi(5)
            - 67.56 * x.powi(6)
            + 16.99 * x.powi(7)
            + w.speed_term * ln * w.density / hm
            + w.slenderness_term * n.diameter / ln;
        w.resistance_scale * hm * ln * root.max(0.0).powi(2) + w.head_stiffness_scale * hm * (z - ln).max(0.0)
    }

    fn volumes(&self, y: &Y) -> [f64; 5] {
        let c = &self.p.chambers;
        let (travel, valve) = (y[0] - y[4], y[2] - y[4]);
        let s = self.p.head_valve.lift - valve;
        [
            c.above_piston + self.a1 * travel + self.ah3 * s,
            c.below_piston + self.a2 * (self.p.piston.stroke - travel),
            c.return_volume,
            c.above_valve + self.ah1 * valve,
            c.supply_volume + if self.published { 0.0 } else { self.ah2 * s },
        ]
    }

    fn f(&self, t: f64, y: &Y) -> Y {
        let p = &self.p;
        let (air, v, c, k) = (&p.ambient, &p.head_valve, &p.chambers, &p.contacts);
        let (yp, vp, yh, vh, yg, vg, yw, vw) = (y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7]);
        let (travel, rate, valve, valve_rate) = (yp - yg, vp - vg, yh - yg, vh - vg);
        let s = v.lift - valve;
        let vol = self.volumes(y);
        let pr: [f64; 5] = std::array::from_fn(|i| y[8 + i]);
        let mass: [f64; 5] = std::array::from_fn(|i| y[13 + i]);
        let (pa, ta) = (air.pressure, air.temperature);
        let temp: [f64; 5] = std::array::from_fn(|i| match self.published {
            true => ta,
            false => pr[i] * vol[i] / (mass[i] * air.gas_constant),
        });
        // A published contact pulls before it opens.
        let least = if self.published { f64::NEG_INFINITY } else { 0.0 };

        let fgp = pr[0] * self.a1 - pr[1] * self.a2 - pa * self.ar;
        let fgh = pr[3] * self.ah1 - pr[4] * self.ah2 - pr[0] * self.ah3;
        let l = p.piston.stroke;
        let fb = if travel >= l {
            (k.bumper_stiffness * (travel - l) + k.bumper_damping * rate).max(least)
        } else {
            0.0
        };
        let fst = if travel <= 0.0 {
            (k.stopper_stiffness * travel + k.stopper_damping * rate).min(-least)
        } else {
            0.0
        };
        let dash = |kk: f64, m: f64, z: f64| 2.0 * z * (kk * m).sqrt();
        let fhc = if valve <= 0.0 {
            let cc = dash(k.cap_stiffness, v.mass, k.valve_damping_ratio);
            (k.cap_stiffness * valve + cc * valve_rate).min(0.0)
        } else if valve >= v.lift {
            let cc = dash(k.seat_stiffness, v.mass, k.valve_damping_ratio);
            (k.seat_stiffness * (valve - v.lift) + cc * valve_rate).max(0.0)
        } else {
            0.0
        };
        let u = yg - yw;
        let cn = dash(k.nose_stiffness, p.tool.mass, k.nose_damping_ratio);
        let fnose = if u > 0.0 {
            (k.nose_stiffness * u + cn * (vg - vw)).max(0.0)
        } else {
            0.0
        };
        let kesg = k.guard_stiffness * k.nose_stiffness / (k.guard_stiffness + k.nose_stiffness);
        let fe = if u > -k.guard_travel {
            kesg * (u + k.guard_travel)
        } else {
            0.0
        };
        let fsup = if yw > 0.0 {
            (p.support.stiffness * yw + self.c_ws * vw).max(0.0)
        } else {
            0.0
        };
        let z = yp - yw - p.nail.tip_gap(&p.piston);
        let zmax = y[18];
        let fpen = if self.published {
            // Elastic until the driver turns.
            if z > 0.0 && !self.left { self.envelope(z) } else { 0.0 }
        } else if z <= 0.0 && zmax <= 0.0 {
            0.0
        } else if z >= zmax {
            self.envelope(z)
        } else {
            (self.envelope(zmax) - p.wood.unloading_stiffness * (zmax - z)).max(0.0)
        };
        let fs = v.spring_scale * self.spring(s + v.spring_preload);
        let ffp = self.friction(&p.piston.friction, rate);
        let ffh = self.friction(&v.friction, valve_rate);
        let (mt, fmag) = if self.attached {
            let turn = (rate / p.model.friction_velocity).tanh();
            (p.piston.mass + self.mn, p.nail.magazine_friction * turn)
        } else {
            (p.piston.mass, 0.0)
        };
        let g = air.gravity;

        // Flows.
        let gas = |i: usize| (pr[i], temp[i]);
        let seat = |y: f64, th: f64, d: f64, sign: f64| PI * y * th.sin() * (d - sign * y * th.sin() * th.cos());
        let opening = s - v.intake_lap;
        let (mi, hi) = if opening > 0.0 && !(self.published && pr[0] >= pr[4]) {
            let r = (pr[0].min(pr[4]) / pr[0].max(pr[4])).clamp(0.390, 0.913);
            let cf = 1.1 - 0.71 * r + 0.49 * r * r - 0.14 * r.powi(3);
            self.both(gas(4), gas(0), cf * seat(opening, v.intake_angle, p.piston.bore, 1.0))
        } else {
            (0.0, 0.0)
        };
        let cd = p.exhaust.coefficient(&p.chambers);
        let cp = air.heat_capacity_ratio * air.gas_constant / (air.heat_capacity_ratio - 1.0);
        let opening = v.exhaust_lap - s;
        let (mx, hx, thrust) = if opening > 0.0 && pr[0] != pa {
            let a = seat(opening, v.exhaust_angle, v.exhaust_seat_diameter, -1.0);
            if pr[0] > pa {
                let (flow, pm) = self.series(a, self.ama, pr[0], pa);
                let m = cd * self.k * flow / temp[0].sqrt();
                let gamma = air.heat_capacity_ratio;
                let r = (pa / pm).max(self.pcr);
                let jet = 2.0 * gamma / (gamma - 1.0) * (r.powf(1.0 / gamma) - r) + r;
                let thrust = p.exhaust.thrust_share * cd * self.ama * (pm * jet - pa);
                (m, m * cp * temp[0], thrust)
            } else if self.published {
                (0.0, 0.0, 0.0)
            } else {
                let (flow, _) = self.series(self.ama, a, pa, pr[0]);
                let m = cd * self.k * flow / ta.sqrt();
                (-m, -m * cp * ta, 0.0)
            }
        } else {
            (0.0, 0.0, 0.0)
        };
        let (mc, hc) = if travel > c.check_hole_position && pr[0] > pr[2] {
            self.both(
                gas(0),
                gas(2),
                c.coefficient(c.check_hole_coefficient) * c.check_hole_area,
            )
        } else {
            (0.0, 0.0)
        };
        let (mf, hf) = self.both(
            gas(1),
            gas(2),
            c.coefficient(c.return_hole_coefficient) * c.return_hole_area,
        );
        let (ml, hl) = self.both(gas(1), (pa, ta), c.coefficient(c.leak_coefficient) * c.leak_area);
        let filling = t - self.released >= self.tau;
        let (mv, hv) = if t >= self.tau && !filling {
            self.both(gas(3), (pa, ta), p.trigger.vent_area * self.phi_out)
        } else {
            (0.0, 0.0)
        };
        let (mfill, hfill) = if filling {
            self.both(gas(4), gas(3), p.trigger.fill_area * self.phi_in)
        } else {
            (0.0, 0.0)
        };
        let (ms, hs) = if p.supply.pressure > pr[4] && !self.published {
            self.both(
                (p.supply.pressure, ta),
                gas(4),
                c.coefficient(p.supply.hose_coefficient) * p.supply.hose_area,
            )
        } else {
            (0.0, 0.0)
        };
        let flow = [mi - mx - mc, -mf - ml, mc + mf, mfill - mv, ms - mi - mfill];
        let enthalpy = [hi - hx - hc, -hf - hl, hc + hf, hfill - hv, hs - hi - hfill];
        let bore = PI * p.piston.bore;
        let wall = [
            c.wall_above_piston + bore * travel,
            c.wall_below_piston + bore * (l - travel),
            c.wall_return,
            c.wall_above_valve,
            c.wall_supply,
        ];
        let dv = [
            self.a1 * rate - self.ah3 * valve_rate,
            -self.a2 * rate,
            0.0,
            self.ah1 * valve_rate,
            if self.published { 0.0 } else { -self.ah2 * valve_rate },
        ];
        let gamma = air.heat_capacity_ratio;
        let mut d = [0.0; N];
        d[0] = vp;
        d[1] = (fgp - fb - fst - fpen - ffp - fmag) / mt + g;
        d[2] = vh;
        d[3] = (fgh + fs - fhc - ffh) / v.mass + g;
        d[4] = vg;
        let inner = fb + fst + fhc + ffp + ffh + fmag - fgp - fgh - fs;
        // The hand's mass, pushed by the force, or the force itself.
        let hand = if p.hand.mass > 0.0 {
            p.hand.stiffness * (y[19] - yg) + p.hand.damping * (y[20] - vg)
        } else {
            p.hand.force
        };
        if p.hand.mass > 0.0 {
            d[19] = y[20];
            d[20] = (p.hand.force - hand) / p.hand.mass;
        }
        d[5] = (hand + thrust + inner - fnose - fe) / p.tool.mass + g;
        d[6] = vw;
        d[7] = (fpen + fnose + fe - fsup) / self.mw + g;
        if self.published {
            let m = &p.model;
            let [vented, filled] = self.arriving(t - self.tau);
            let vented = if t >= self.tau && !filling { vented } else { 0.0 };
            let filled = if filling { filled } else { 0.0 };
            // What leaves the supply does so with the trigger and without the attenuation of the channel.
            let lost = self.entering(t, y)[1] / self.phi_in;
            let (inner, outer) = (m.polytropic_inflow, m.polytropic_outflow);
            let flow = [
                inner * (mi - mc) - outer * mx,
                -inner * mf,
                inner * (mc + mf),
                inner * (filled - vented),
                -inner * (mi + lost),
            ];
            for i in 0..5 {
                d[8 + i] = (air.gas_constant * ta * flow[i] - m.polytropic * pr[i] * dv[i]) / vol[i];
            }
            d[18] = (vp - vw).max(0.0) * f64::from(u8::from(z >= zmax && z > 0.0));
            return d;
        }
        for i in 0..5 {
            let heat = c.wall_heat_transfer * wall[i] * (ta - temp[i]);
            d[8 + i] = ((gamma - 1.0) * (enthalpy[i] + heat) - gamma * pr[i] * dv[i]) / vol[i];
            d[13 + i] = flow[i];
        }
        d[18] = if z >= zmax && z > 0.0 { (vp - vw).max(0.0) } else { 0.0 };
        d
    }

    fn start(&self) -> Y {
        let p = &self.p;
        let g = p.ambient.gravity;
        let mut y = [0.0; N];
        let tool = p.hand.force + (p.tool.mass + p.piston.mass + p.head_valve.mass) * g;
        let k = &p.contacts;
        let kesg = k.guard_stiffness * k.nose_stiffness / (k.guard_stiffness + k.nose_stiffness);
        y[6] = (tool + self.mw * g) / p.support.stiffness;
        y[4] = y[6] + (tool - kesg * k.guard_travel) / (k.nose_stiffness + kesg);
        y[0] = y[4];
        y[19] = y[4] + p.hand.force / p.hand.stiffness;
        let (ps, pa) = (p.supply.pressure, p.ambient.pressure);
        let close = ps * self.ah1 - ps * self.ah2 - pa * self.ah3
            + p.head_valve.spring_scale * self.spring(p.head_valve.spring_preload)
            + p.head_valve.mass * g;
        y[2] = y[4] + p.head_valve.lift + close / k.seat_stiffness;
        let vol = self.volumes(&y);
        for (i, pressure) in [pa, pa, pa, ps, ps].into_iter().enumerate() {
            y[8 + i] = pressure;
            y[13 + i] = pressure * vol[i] / (p.ambient.gas_constant * p.ambient.temperature);
        }
        y
    }
}

/// A shot from RK4 with step `h` up to `end`.
pub(crate) fn integrate(p: &Parameters, h: f64, end: f64) -> Shot {
    let mut m = Model::new(p);
    m.step = h;
    let mut y = m.start();
    let mut t = 0.0;
    let mut steps = 0u32;
    let mut found: [Option<f64>; LEVELS] = [None; LEVELS];
    let (mut rest, mut still) = (Speed::default(), Speed::default());
    let mut bumper = None;
    let level = p.ambient.pressure + 0.1 * (p.supply.pressure - p.ambient.pressure);
    // (rises, value, may it be looked for yet)
    let watch = |m: &Model, y: &Y, found: &[Option<f64>; LEVELS], t: f64| -> [(bool, f64, bool); LEVELS] {
        let p = &m.p;
        let (travel, s) = (y[0] - y[4], p.head_valve.lift - (y[2] - y[4]));
        let z = y[0] - y[6] - p.nail.tip_gap(&p.piston);
        let after = |i: usize| found[i].is_some();
        [
            (true, s - 10e-6, true),
            (false, y[11] - level, true),
            (true, s - p.head_valve.intake_lap, true),
            (true, travel - 0.1e-3, true),
            (true, travel - p.nail.head_gap(&p.piston), true),
            (true, z, true),
            (true, travel - 50.51e-3, true),
            (true, travel - p.chambers.check_hole_position, true),
            (false, y[1] - y[7], after(5)),
            (true, travel - p.piston.stroke, after(8)),
            (false, y[4] - y[6] + p.contacts.guard_travel, true),
            (
                false,
                s - p.head_valve.exhaust_lap,
                t > m.released && y[8] > p.ambient.pressure,
            ),
            (false, travel - 50.51e-3, after(8)),
            (false, travel, after(12)),
            (
                false,
                y[8] - 1.02 * p.ambient.pressure,
                found[11].is_some_and(|t13| t > t13 + 1e-3),
            ),
            (true, z - p.nail.length, true),
        ]
    };
    while t < end {
        if m.published {
            let entered = m.entering(t, &y);
            m.entered.push(entered);
        }
        let add = |a: &Y, b: &Y, w: f64| -> Y { std::array::from_fn(|i| a[i] + w * b[i]) };
        let k1 = m.f(t, &y);
        let k2 = m.f(t + 0.5 * h, &add(&y, &k1, 0.5 * h));
        let k3 = m.f(t + 0.5 * h, &add(&y, &k2, 0.5 * h));
        let k4 = m.f(t + h, &add(&y, &k3, h));
        let mut next: Y = std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        next[18] = next[18].max(next[0] - next[6] - p.nail.tip_gap(&p.piston)).max(0.0);
        let before = watch(&m, &y, &found, t);
        let after = watch(&m, &next, &found, t + h);
        for i in 0..LEVELS {
            let (rises, a, _) = before[i];
            let (_, b, open) = after[i];
            if found[i].is_none()
                && open
                && (if rises {
                    a <= 0.0 && b > 0.0
                } else {
                    a > 0.0 && b <= 0.0
                })
            {
                found[i] = Some(t + h * a / (a - b));
            }
        }
        // t10 is t9 where the piston has passed the bumper before.
        if found[8].is_some() && found[9].is_none() && before[9].1 > 0.0 {
            found[9] = found[8];
        }
        let (slow, fast) = (y[1] - y[5], next[1] - next[5]);
        rest.follow(0.1, t, h, slow, fast);
        still.follow(0.05, t, h, slow, fast);
        if bumper.is_none() && before[9].1 <= 0.0 && after[9].1 > 0.0 {
            bumper = Some(t + h * before[9].1 / (before[9].1 - after[9].1));
        }
        if m.volumes(&next)[1] < 1e-3 * p.chambers.below_piston {
            return Shot {
                dry: true,
                ..Shot::default()
            };
        }
        if !m.attached && !m.left && next[0] - next[4] >= p.nail.head_gap(&p.piston) {
            if !m.published {
                next[1] *= p.piston.mass / (p.piston.mass + m.mn);
            }
            m.attached = true;
        } else if m.attached && next[1] <= 0.0 {
            m.attached = false;
            m.left = true;
        }
        if let Some(t12) = found[10] {
            m.released = m.released.min(t12);
        }
        steps += 1;
        // The published flows are found by the number of their step.
        t = if m.published { f64::from(steps) * h } else { t + h };
        y = next;
    }
    let [t1, t2, t3, t4, t5, t6, t7, t8, t9, t10, t12, t13, t15, t16, t17, full] = found;
    let by_hand = Some(p.trigger.release_after).filter(|release| *release > 0.0 && *release <= end);
    let t12 = [t12, by_hand].into_iter().flatten().reduce(f64::min);
    let t14 = t15.and_then(|t15| {
        let rise = still.0.iter().rev().find(|c| c.1 && c.0 < t15);
        rise.map(|c| c.0).filter(|t| t6.is_some_and(|t6| *t > t6))
    });
    let t11 = t10.and_then(|t10| rest.rest(t10, t14.unwrap_or(end)));
    let t18 = t16.and_then(|t16| rest.rest(t16, end));
    Shot {
        events: [
            Some(0.0),
            t1,
            t2,
            t3,
            t4,
            t5,
            t6,
            t7,
            t8,
            t9,
            t10,
            t11,
            t12,
            t13,
            t14,
            t15,
            t16,
            t17,
            t18,
        ],
        full,
        depth: y[18],
        bumper,
        dry: false,
    }
}
