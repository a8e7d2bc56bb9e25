//! Impact of the projectile on the nail, penetration, and rebound.
//!
//! ```text
//! v_1 = v_0 M/M_1,  M_1 = M + M_n,   M_1 v' = M_1 g - E(y; v),   E = F_r + k_w max(0, y - NL)
//! ```
//! From the deepest point the nail springs back with k_u, as in the nailing cycle. The projectile leaves it at F = 0.

use std::f64::consts::PI;

use serde::Serialize;

use super::integrator::integrate;
use super::{Machine, MachineError};
use nailnoise_penetration::fit::FittedLaw;
use nailnoise_penetration::{Driven, NailedWood, Resistance, ResistanceLaw, Shanks, Specimen};

/// Tolerance of the integration.
const TOLERANCE: f64 = 1e-12;
/// Longest drive \[s\].
const LONGEST: f64 = 0.5;
/// Speed of longitudinal waves along a steel nail, sqrt(E/rho) with E = 205 GPa and rho = 7850 kg/m3 \[m/s\].
const WAVE_SPEED: f64 = 5110.0;

/// One shot into one specimen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shot {
    /// v0, speed of the projectile at the nail \[m/s\].
    pub speed: f64,
    /// b, deviation of the specimen from the law, of s = sqrt(F_r/(H_M NL)).
    pub deviation: f64,
}

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

/// Where the projectile's energy goes \[J\].
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
    /// Given back by the wood from the deepest point on.
    pub elastic: f64,
    /// Work of gravity.
    pub gravity: f64,
    /// Motion left when the projectile leaves the nail.
    pub rest: f64,
    /// Their imbalance, as a part of M v0^2/2 \[-\].
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

/// Drives the nail of a machine, with samples at intervals of `interval` \[s\].
///
/// # Errors
/// [`MachineError`] where the nail does not stop, leaves the block, or a law is not valid.
pub fn drive(machine: &Machine, fit: Option<&FittedLaw>, shot: Shot, interval: f64) -> Result<Drive, MachineError> {
    let (nail, wood, projectile) = (&machine.nail, &machine.wood, &machine.projectile);
    let gravity = machine.ambient.gravity;
    let (m, v0) = (projectile.mass, shot.speed);
    if projectile.mass_ahead_of_cell >= m {
        return Err(MachineError::CellMass {
            ahead: projectile.mass_ahead_of_cell,
            mass: m,
        });
    }
    let specimen = Specimen {
        length: nail.length,
        diameter: nail.diameter,
        hardness_modulus: wood.hardness_modulus,
        density: wood.density,
    };
    if wood.penetration_law == ResistanceLaw::Fitted {
        let Some(fit) = fit else {
            return Err(MachineError::NoFit);
        };
        let [lowest, highest] = fit.of(&specimen, m).impacts();
        if !(lowest..=highest).contains(&v0) {
            return Err(MachineError::BeyondFit {
                speed: v0,
                lowest,
                highest,
            });
        }
    }
    let law = Resistance::new(&Driven {
        wood: &NailedWood::quasi_static(wood.clone()),
        table: None,
        fit,
        specimen: &specimen,
        mass: m,
        shanks: Shanks::SMOOTH,
    });
    let joint = m + nail.mass;
    let v1 = v0 * m / joint;
    let to_cell = (m - projectile.mass_ahead_of_cell) / joint;
    let scale = wood.hardness_modulus * nail.length;
    let shank = |depth: f64, v: f64| {
        let force: f64 = law.evaluate(depth.min(nail.length), v, v0);
        if shot.deviation == 0.0 {
            force
        } else {
            scale * ((force / scale).sqrt() + shot.deviation).max(0.0).powi(2)
        }
    };
    let stiffness = wood.head_stiffness_scale * wood.hardness_modulus;
    let head = |depth: f64| stiffness * (depth - nail.length).max(0.0);
    // Depth, speed, work along the shank, work under the head.
    let rates = |y: &[f64; 4]| {
        let (along, under) = (shank(y[0], y[1]), head(y[0]));
        [y[1], gravity - (along + under) / joint, along * y[1], under * y[1]]
    };
    let energy = 0.5 * m * v0 * v0;
    let tolerance = (TOLERANCE, [nail.length, v0, energy, energy]);
    let mut samples = vec![Sample {
        time: 0.0,
        depth: 0.0,
        speed: v1,
        force: shank(0.0, v1),
        cell: to_cell * shank(0.0, v1),
    }];
    // Separate steps for samples: no interpolation between force and motion.
    let (mut t, mut y) = (0.0, [0.0, v1, 0.0, 0.0]);
    let mut head_speed = None;
    let mut stopped = false;
    while !stopped {
        let next = samples.len() as f64 * interval;
        if next > LONGEST {
            return Err(MachineError::NoStop { time: LONGEST });
        }
        let failure = MachineError::Integration { time: t };
        let reached_head = y[0] >= nail.length;
        // To the head, the deepest point, or the next sample, whichever is first.
        let event = |y: &[f64; 4]| {
            if reached_head {
                y[1]
            } else {
                y[1].min((nail.length - y[0]) / nail.length * v0)
            }
        };
        let (end, found) = integrate(rates, event, (t, y), next, tolerance, |_| {}).ok_or(failure)?;
        (t, y) = end;
        if y[0] > machine.block.thickness {
            return Err(MachineError::ThroughBlock {
                depth: y[0],
                thickness: machine.block.thickness,
            });
        }
        if !found {
            let force = shank(y[0], y[1]) + head(y[0]);
            samples.push(Sample {
                time: t,
                depth: y[0],
                speed: y[1],
                force,
                cell: to_cell * force,
            });
        } else if !reached_head && y[1] > 1e-9 * v0 {
            y[0] = nail.length;
            head_speed = Some(y[1]);
        } else {
            stopped = true;
        }
    }
    let (deepest, stop_time) = (y[0], t);
    let force = shank(deepest, 0.0) + head(deepest);
    let k = wood.unloading_stiffness;
    // M_1 y'' = M_1 g - F - k_u (y - z): swings about F = M_1 g until F = 0.
    let omega = (k / joint).sqrt();
    let (middle, swing) = (joint * gravity, force - joint * gravity);
    let square = force * force / (k * joint) - 2.0 * gravity * force / k;
    let leaves = square > 0.0;
    let rebound = square.max(0.0).sqrt();
    let end = stop_time
        + if leaves {
            (-middle / swing).clamp(-1.0, 1.0).acos() / omega
        } else {
            PI / omega
        };
    while samples.len() as f64 * interval < end {
        let time = samples.len() as f64 * interval;
        let phase = omega * (time - stop_time);
        let force = middle + swing * phase.cos();
        samples.push(Sample {
            time,
            depth: deepest - swing / k * (1.0 - phase.cos()),
            speed: -swing / k * omega * phase.sin(),
            force,
            cell: to_cell * force,
        });
    }
    let back = if leaves { force / k } else { 2.0 * swing / k };
    let elastic = if leaves {
        0.5 * force * force / k
    } else {
        joint * gravity * back
    };
    let energy = EnergyOfDrive {
        projectile: energy,
        impact: energy - 0.5 * joint * v1 * v1,
        shank: y[2],
        head: y[3],
        elastic,
        gravity: joint * gravity * (deepest - back),
        rest: 0.5 * joint * rebound * rebound,
        balance: 0.0,
    };
    let residual =
        energy.projectile + energy.gravity + energy.elastic - energy.impact - energy.shank - energy.head - energy.rest;
    Ok(Drive {
        impact_speed: v0,
        joint_speed: v1,
        stop_depth: deepest,
        stop_time,
        stop_force: force,
        stop_cell: to_cell * force,
        head_speed,
        rebound,
        rigid_to: WAVE_SPEED / (20.0 * nail.length),
        energy: EnergyOfDrive {
            balance: residual.abs() / energy.projectile,
            ..energy
        },
        samples,
    })
}
