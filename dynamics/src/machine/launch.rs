//! The launch: gas drives the carrier with the projectile in it, bumpers stop the carrier.
//!
//! ```text
//! (M_c + M) a = (P_c - P_a) A_p - (P_u - P_a)(A_p - A_rod) - F_f - F_b + (M_c + M) g
//! F_b = n max(0, k (u - L) + c u')  for u > L
//! ```
//! The projectile lies in the carrier, which can push but not pull it. If the carrier falls behind (a < g), the
//! projectile is free.

use std::f64::consts::PI;

use super::rig::{Logged, Rig};
use super::{Machine, MachineError};

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
    /// Residual of the energy balance, as a fraction of the work of the gas \[-\].
    pub balance: f64,
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
    let record = Rig::launching(machine)?.run(f64::INFINITY)?;
    let cradle = Logged::last(&record, "cradle", &["closes", "opens"]);
    let strike = record.strikes.first();
    if strike.is_some() && cradle.as_ref().is_some_and(|cradle| cradle.is("closes")) {
        return Err(MachineError::StillPushing {
            travel: l.nail_distance,
        });
    }
    // A projectile that the gas does not push falls on the nail by its weight.
    let arrived = record.event("buffered").is_some();
    let Some((cradle, strike)) = cradle.zip(strike).filter(|_| arrived) else {
        let area = 0.25 * PI * l.bore * l.bore;
        let weight = (l.carrier_mass + machine.projectile.mass) * ambient.gravity;
        return Err(MachineError::NoLaunch {
            force: (l.reservoir_pressure - ambient.pressure) * area + weight,
            friction: l.friction,
        });
    };
    let mut checks = record.checks.iter();
    let residual = checks.find(|check| check.name == "whole-shot energy balance [J]");
    let work = record.integral("work.carrier").unwrap_or(0.0);
    Ok(Launched {
        speed: strike.before,
        travel: cradle.value("projectile.position"),
        time: cradle.time(),
        pressure: cradle.value("cylinder.pressure"),
        balance: residual.map_or(f64::NAN, |residual| residual.value) / work.abs(),
    })
}
