//! The launch: gas drives the carrier with the projectile in it, bumpers stop the carrier.
//!
//! ```text
//! (M_c + M) a = (P_c - P_a) A_p - (P_u - P_a)(A_p - A_rod) - F_f - F_b + (M_c + M) g
//! F_b = n max(0, k (u - L) + c u')  for u > L
//! ```
//! The projectile is free once the carrier falls behind it, a < g. Gas as in the nailing cycle, without heat to the
//! walls.

use std::f64::consts::PI;

use super::integrator::integrate;
use super::{Machine, MachineError};
use crate::network::gas::{Air, Gas};

/// Tolerance of the integration.
const TOLERANCE: f64 = 1e-11;
/// Velocity over which friction turns its sign, as in the nailing cycle \[m/s\].
const FRICTION_VELOCITY: f64 = 1e-3;
/// Longest launch \[s\].
const LONGEST: f64 = 1.0;

/// The results of a launch.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Launched {
    /// v0, speed of the projectile at the nail \[m/s\].
    pub speed: f64,
    /// Travel at which the projectile is free \[m\].
    pub travel: f64,
    /// Time from the valve's opening until then \[s\].
    pub time: f64,
    /// Pressure in the cylinder then \[Pa\].
    pub pressure: f64,
    /// Residual of the energy, as a part of the gas' work \[-\].
    pub balance: f64,
}

const U: usize = 0;
const V: usize = 1;
const RESERVOIR: usize = 2;
const CYLINDER: usize = 4;
const BELOW: usize = 6;
const WORK: usize = 8;
const LOST: usize = 9;
const STATES: usize = 10;

/// Forces and flows of a state.
struct Now {
    rates: [f64; STATES],
    /// Force on carrier and projectile without gravity \[N\].
    push: f64,
}

/// The launch of a machine.
///
/// # Errors
/// [`MachineError::NoLaunch`], [`MachineError::StillPushing`] and [`MachineError::Rod`].
pub fn launch(machine: &Machine) -> Result<Launched, MachineError> {
    let (l, ambient) = (&machine.launch, &machine.ambient);
    if l.speed > 0.0 {
        return Ok(Launched {
            speed: l.speed,
            travel: 0.0,
            time: 0.0,
            pressure: ambient.pressure,
            balance: 0.0,
        });
    }
    if l.rod_diameter >= l.bore {
        return Err(MachineError::Rod {
            rod: l.rod_diameter,
            bore: l.bore,
        });
    }
    let area = 0.25 * PI * l.bore * l.bore;
    let ring = area - 0.25 * PI * l.rod_diameter * l.rod_diameter;
    let mass = l.carrier_mass + machine.projectile.mass;
    let bumpers = f64::from(l.bumpers);
    let air = Air::new(ambient.gas_constant, ambient.heat_capacity_ratio, 1e-3);
    let gamma = ambient.heat_capacity_ratio;
    let joined = l.valve_area == 0.0;
    let gas = |y: &[f64; STATES], place: usize, volume: f64| Gas {
        pressure: y[place] * (gamma - 1.0) / volume,
        temperature: y[place] / y[place + 1] * (gamma - 1.0) / ambient.gas_constant,
    };
    let outside = Gas {
        pressure: ambient.pressure,
        temperature: ambient.temperature,
    };
    let flow = |c_a: f64, from: Gas<f64>, to: Gas<f64>| {
        let mass = air.exchange(c_a, from, to);
        let source = if mass >= 0.0 { from.temperature } else { to.temperature };
        (mass, mass * air.cp * source)
    };
    let below_volume = |u: f64| l.below_volume + ring * (l.stroke - u);
    let evaluate = |y: &[f64; STATES]| -> Now {
        let (u, v) = (y[U], y[V]);
        let volume = l.dead_volume + area * u + if joined { l.reservoir_volume } else { 0.0 };
        let cylinder = gas(y, CYLINDER, volume);
        let mut rates = [0.0; STATES];
        if !joined {
            let (m, h) = flow(l.valve_area, gas(y, RESERVOIR, l.reservoir_volume), cylinder);
            (rates[RESERVOIR], rates[RESERVOIR + 1]) = (-h, -m);
            (rates[CYLINDER], rates[CYLINDER + 1]) = (h, m);
        }
        let below = if l.vent_area > 0.0 {
            let below = gas(y, BELOW, below_volume(u));
            let (m, h) = flow(l.vent_area, below, outside);
            (rates[BELOW], rates[BELOW + 1]) = (below.pressure * ring * v - h, -m);
            below.pressure
        } else {
            ambient.pressure
        };
        rates[CYLINDER] -= cylinder.pressure * area * v;
        let gas_force = (cylinder.pressure - ambient.pressure) * area - (below - ambient.pressure) * ring;
        let over = u - l.stroke;
        let bumper = if over >= 0.0 {
            bumpers * (l.bumper_stiffness * over + l.bumper_damping * v).max(0.0)
        } else {
            0.0
        };
        let friction = l.friction * (v / FRICTION_VELOCITY).tanh();
        let push = gas_force - friction - bumper;
        rates[U] = v;
        rates[V] = push / mass + ambient.gravity;
        rates[WORK] = gas_force * v;
        rates[LOST] = (friction + bumper) * v;
        Now { rates, push }
    };
    let mut y = [0.0; STATES];
    let mut fill = |place: usize, pressure: f64, volume: f64| {
        y[place] = pressure * volume / (gamma - 1.0);
        y[place + 1] = pressure * volume / (ambient.gas_constant * ambient.temperature);
    };
    fill(RESERVOIR, l.reservoir_pressure, l.reservoir_volume);
    if joined {
        // Only the reservoir's gas: the valve shut off the dead volume, which is small.
        fill(CYLINDER, l.reservoir_pressure, l.reservoir_volume + l.dead_volume);
    } else {
        fill(CYLINDER, ambient.pressure, l.dead_volume);
    }
    fill(BELOW, ambient.pressure, below_volume(0.0));
    let start = y;
    let scale: [f64; STATES] = std::array::from_fn(|i| match i {
        U => l.stroke,
        V => 10.0,
        WORK | LOST => 100.0,
        place => start[place].abs().max(1e-9),
    });
    let failure = |time: f64| MachineError::Integration { time };
    let rates = |y: &[f64; STATES]| evaluate(y).rates;
    let tolerance = (TOLERANCE, scale);
    let ((t, at), arrived) =
        integrate(rates, |y| l.stroke - y[U], (0.0, y), LONGEST, tolerance, |_| {}).ok_or_else(|| failure(0.0))?;
    if !arrived {
        return Err(MachineError::NoLaunch {
            force: evaluate(&start).push + mass * ambient.gravity,
            friction: l.friction,
        });
    }
    let mut at = at;
    at[U] = l.stroke;
    let (t, y) = if evaluate(&at).push <= 0.0 {
        (t, at)
    } else {
        let ((t, y), free) =
            integrate(rates, |y| evaluate(y).push, (t, at), LONGEST, tolerance, |_| {}).ok_or_else(|| failure(t))?;
        if !free {
            return Err(MachineError::StillPushing { travel: y[U] });
        }
        (t, y)
    };
    if y[U] > l.nail_distance {
        return Err(MachineError::StillPushing {
            travel: l.nail_distance,
        });
    }
    let kinetic = 0.5 * mass * y[V] * y[V];
    let residual = y[WORK] + mass * ambient.gravity * y[U] - y[LOST] - kinetic;
    Ok(Launched {
        speed: (y[V] * y[V] + 2.0 * ambient.gravity * (l.nail_distance - y[U])).sqrt(),
        travel: y[U],
        time: t,
        pressure: gas(
            &y,
            CYLINDER,
            l.dead_volume + area * y[U] + if joined { l.reservoir_volume } else { 0.0 },
        )
        .pressure,
        balance: (residual / y[WORK]).abs(),
    })
}
