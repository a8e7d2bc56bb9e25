//! Impact of the projectile on the nail, penetration, and rebound.
//!
//! ```text
//! v_1 = v_0 M/M_1,  M_1 = M + M_n,   M_1 v' = M_1 g - E(y; v),   E = F_r + k_w max(0, y - NL)
//! ```
//! From the deepest point the nail springs back with k_u. It pushes the projectile but cannot pull it. They separate
//! when the force of the wood is zero (the rule `leaves = "unloaded"` of a fastener).

use serde::Serialize;

use super::rig::{Logged, Rig, Shot};
use super::{Machine, MachineError};
use nailnoise_penetration::fit::FittedLaw;

/// Speed of longitudinal waves along a steel nail, sqrt(E/rho) with E = 205 GPa and rho = 7850 kg/m3 \[m/s\].
const WAVE_SPEED: f64 = 5110.0;

/// A state of a drive.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Sample {
    /// Time from the impact \[s\].
    pub time: f64,
    /// y, depth of the tip \[m\].
    pub depth: f64,
    /// v \[m/s\].
    pub speed: f64,
    /// F, force of the wood on the nail \[N\].
    pub force: f64,
    /// F_cell, force of the load cell \[N\].
    pub cell: f64,
}

/// Distribution of the projectile's energy \[J\].
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct EnergyOfDrive {
    /// M v0^2/2.
    pub projectile: f64,
    /// Lost at the impact on the nail.
    pub impact: f64,
    /// Work along the shank and at the tip, to the deepest point.
    pub shank: f64,
    /// Work under the head.
    pub head: f64,
    /// Returned by the wood after the deepest point.
    pub elastic: f64,
    /// Work of gravity.
    pub gravity: f64,
    /// Kinetic energy when the projectile leaves the nail.
    pub rest: f64,
    /// Their imbalance, as a fraction of M v0^2/2 \[-\].
    pub balance: f64,
}

/// A drive.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Drive {
    /// v0 \[m/s\].
    pub impact_speed: f64,
    /// v_1 \[m/s\].
    pub joint_speed: f64,
    /// Depth of the tip at the end of loading \[m\].
    pub stop_depth: f64,
    /// Time of it from the impact \[s\].
    pub stop_time: f64,
    /// Force there \[N\].
    pub stop_force: f64,
    /// Force of the cell there \[N\].
    pub stop_cell: f64,
    /// Speed when the head meets the wood \[m/s\]; none if it does not.
    pub head_speed: Option<f64>,
    /// Time of it from the impact \[s\].
    #[serde(skip)]
    pub head_time: Option<f64>,
    /// Speed of the rebound, upwards \[m/s\].
    pub rebound: f64,
    /// Frequency above which the nail is not a rigid body, c/(20 NL) \[Hz\].
    pub rigid_to: f64,
    /// Energies.
    pub energy: EnergyOfDrive,
    /// Samples from the impact until the projectile leaves the nail.
    #[serde(skip)]
    pub samples: Vec<Sample>,
}

/// Drives the nail of a machine, with samples at intervals of `interval` \[s\]; without samples if it is infinite.
///
/// # Errors
/// [`MachineError`] if the nail does not stop, leaves the block, or a law is not valid.
pub fn drive(machine: &Machine, fit: Option<&FittedLaw>, shot: Shot, interval: f64) -> Result<Drive, MachineError> {
    let (nail, wood, projectile) = (&machine.nail, &machine.wood, &machine.projectile);
    let (m, v0) = (projectile.mass, shot.speed);
    if projectile.mass_ahead_of_cell >= m {
        return Err(MachineError::CellMass {
            ahead: projectile.mass_ahead_of_cell,
            mass: m,
        });
    }
    let rig = Rig::driving(machine, fit, shot)?;
    let record = rig.run(interval)?;
    let last = |words: &[&str]| Logged::last(&record, "nail", words);
    let history = |name: &str| record.get(name).unwrap_or_default();
    let stop = last(&["unloads"]);
    let deepest = match &stop {
        Some(stop) => stop.value("nail.tip"),
        None => history("nail.tip").last().copied().unwrap_or_default(),
    };
    if deepest > machine.block.thickness {
        return Err(MachineError::ThroughBlock {
            depth: deepest,
            thickness: machine.block.thickness,
        });
    }
    let stop = stop.ok_or(MachineError::NoStop { time: record.end })?;
    let of = |name: &str| record.integral(name).unwrap_or(0.0);
    let (head, left) = (last(&["seats"]), last(&["left"]));
    let joint = m + nail.mass;
    let force = rig.stop_force(deepest, v0);
    // The wood returns F^2/(2 k_u) until the projectile leaves. If the weight of the projectile presses on the nail,
    // the nail oscillates until the end of the record.
    let (back, gravity, rebound, rest) = match &left {
        Some(left) => {
            let (end, rebound) = (left.value("nail.tip"), -left.value("projectile.velocity"));
            let gravity = joint * machine.ambient.gravity * end;
            (deepest - end, gravity, rebound, 0.5 * joint * rebound * rebound)
        }
        None => (0.0, of("gravity"), 0.0, of("kinetic.end")),
    };
    let elastic = (force - 0.5 * wood.unloading_stiffness * back) * back;
    let sunk = (deepest - nail.length).max(0.0);
    let under_head = 0.5 * wood.head_stiffness_scale * wood.hardness_modulus * sunk * sunk;
    let work = of("penetration.nail");
    let mut energy = EnergyOfDrive {
        projectile: 0.5 * m * v0 * v0,
        impact: of("lost.nail"),
        shank: work + elastic - under_head,
        head: under_head,
        elastic,
        gravity,
        rest,
        balance: 0.0,
    };
    let residual = energy.projectile + energy.gravity - energy.impact - work - energy.rest;
    energy.balance = residual.abs() / energy.projectile;
    let [depth, speed, forces, cell] = ["nail.tip", "projectile.velocity", "nail.force", "cell"].map(history);
    let samples = (0..depth.len()).map(|n| Sample {
        time: n as f64 * interval,
        depth: depth[n],
        speed: speed[n],
        force: forces[n],
        cell: cell[n],
    });
    Ok(Drive {
        impact_speed: v0,
        joint_speed: record.strikes.first().map_or(0.0, |strike| strike.after),
        stop_depth: deepest,
        stop_time: stop.time(),
        stop_force: force,
        stop_cell: force * (m - projectile.mass_ahead_of_cell) / joint,
        head_speed: head.as_ref().map(|head| head.value("projectile.velocity")),
        head_time: head.as_ref().map(Logged::time),
        rebound,
        rigid_to: WAVE_SPEED / (20.0 * nail.length),
        energy,
        samples: samples.collect(),
    })
}
