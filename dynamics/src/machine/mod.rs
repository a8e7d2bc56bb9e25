//! A machine that drives nails by a free projectile: launch by gas, impact, penetration, rebound, sensors.
//!
//! Nili Ahmadabadi (2016), ch. 3, describes the machine: a reservoir, a valve, a cylinder whose carrier throws the
//! projectile, and bumpers that stop the carrier. The projectile then flies freely and strikes the nail without air
//! pressure behind it. The dimensions and masses of the carrier and the bumpers are unpublished, so they are inputs.
//! The machine is the built-in assembly `impact_rig` with the values of a [`Machine`].

mod driving;
mod launch;
mod plan;
mod rig;
mod sensors;

use nailnoise_quantities::dimension::*;
use nailnoise_quantities::{gas_pressure, group, nonnegative, positive};
use thiserror::Error;

pub use driving::{Drive, EnergyOfDrive, Sample, drive};
pub use launch::{Launched, launch};
pub use plan::{MASSES, PlanError, Row, TOOL_MASS, TOOL_SPEED, TOOL_SPEED_STEP, plan, speed_for_mean};
pub use rig::Shot;
pub use sensors::{Readings, read};

use crate::{Ambient, Wood};

group! {
    /// The machine.
    Machine {}
    groups {
        projectile: Projectile,
        launch: Launch,
        nail: TestNail,
        wood: Wood,
        block: TestBlock,
        sensors: Sensors,
        scatter: ScatterOfWood,
        ambient: Ambient,
    }
}

group! {
    /// The projectile.
    Projectile {
        /// Mass.
        mass: f64 = positive(MASS), "M";
        /// Mass ahead of the plane of the load cell.
        mass_ahead_of_cell: f64 = nonnegative(MASS), "m_f";
    }
}

group! {
    /// The launch by gas, downwards.
    Launch {
        /// Speed of the projectile at the nail, in place of a launch by gas; 0 for the gas.
        speed: f64 = nonnegative(VELOCITY), "v_0";
        /// Pressure of the reservoir, absolute; a unit that ends in g (psig, barg) is a gauge pressure.
        reservoir_pressure: f64 = gas_pressure(), "P_c";
        /// Volume of the reservoir.
        reservoir_volume: f64 = positive(VOLUME), "";
        /// Effective area C A of the valve from reservoir to cylinder; 0 where the cylinder opens into the reservoir
        /// without restriction.
        valve_area: f64 = nonnegative(AREA), "C A";
        /// Dead volume of the cylinder above the piston.
        dead_volume: f64 = positive(VOLUME), "";
        /// Bore of the cylinder.
        bore: f64 = positive(LENGTH), "";
        /// Diameter of the piston's rod; 0 without one.
        rod_diameter: f64 = nonnegative(LENGTH), "";
        /// Effective area C A of the vent below the piston; 0 where that side is open to the atmosphere.
        vent_area: f64 = nonnegative(AREA), "C A";
        /// Dead volume below the piston on the bumpers.
        below_volume: f64 = positive(VOLUME), "";
        /// Travel of the carrier to the bumpers.
        stroke: f64 = positive(LENGTH), "";
        /// Mass of piston, rod and carrier.
        carrier_mass: f64 = positive(MASS), "M_c";
        /// Friction of piston and carrier.
        friction: f64 = nonnegative(FORCE), "F_f";
        /// Number of bumpers.
        bumpers: u32 = nailnoise_quantities::Kind::Count(100), "";
        /// Stiffness of one bumper.
        bumper_stiffness: f64 = positive(STIFFNESS), "k";
        /// Damping of one bumper.
        bumper_damping: f64 = nonnegative(DAMPING), "c";
        /// Travel of the projectile from rest to the nail.
        nail_distance: f64 = positive(LENGTH), "";
    }
}

group! {
    /// The nail.
    TestNail {
        /// Length.
        length: f64 = positive(LENGTH), "NL";
        /// Diameter of the shank.
        diameter: f64 = positive(LENGTH), "D";
        /// Mass.
        mass: f64 = positive(MASS), "M_n";
    }
}

group! {
    /// The block of wood.
    TestBlock {
        /// Thickness.
        thickness: f64 = positive(LENGTH), "";
    }
}

group! {
    /// The sensors: depth by laser, force by a load cell on the projectile's end.
    Sensors {
        /// Sample rate.
        rate: f64 = positive(FREQUENCY), "";
        /// Standard deviation of the depth's white noise.
        depth_noise: f64 = nonnegative(LENGTH), "sigma_y";
        /// Standard deviation of the force's white noise.
        force_noise: f64 = nonnegative(FORCE), "";
        /// Natural frequency of the cell, of second order; 0 for one without lag.
        cell_frequency: f64 = nonnegative(FREQUENCY), "f_c";
        /// Damping ratio of the cell.
        cell_damping: f64 = positive(NUMBER).within(1e-3, 10.0), "zeta";
    }
}

group! {
    /// Scatter of the wood in virtual tests.
    ScatterOfWood {
        /// Standard deviation between specimens of s = sqrt(F_r/(H_M NL)).
        sigma_between: f64 = nonnegative(NUMBER).within(0.0, 1.0), "sigma_b";
    }
}

/// Why a shot of the machine cannot be computed.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum MachineError {
    /// The carrier still pushes the projectile when it reaches the nail.
    #[error("the carrier still pushes the projectile after {travel:.4} m, where the nail stands")]
    StillPushing {
        /// Travel to the nail \[m\].
        travel: f64,
    },
    /// The gas does not move the carrier to the bumpers.
    #[error("the gas pushes with {force:.1} N against friction of {friction:.1} N: the carrier does not arrive")]
    NoLaunch {
        /// Net force of the gas \[N\].
        force: f64,
        /// Friction \[N\].
        friction: f64,
    },
    /// The mass ahead of the cell is not less than that of the projectile.
    #[error("projectile.mass_ahead_of_cell {ahead} kg must be below projectile.mass {mass} kg")]
    CellMass {
        /// m_f \[kg\].
        ahead: f64,
        /// M \[kg\].
        mass: f64,
    },
    /// The tip leaves the block.
    #[error("the tip goes {depth:.4} m deep, through the block of {thickness:.4} m")]
    ThroughBlock {
        /// Depth \[m\].
        depth: f64,
        /// Thickness \[m\].
        thickness: f64,
    },
    /// The rod is as thick as the bore.
    #[error("launch.rod_diameter {rod} m must be below launch.bore {bore} m")]
    Rod {
        /// Diameter of the rod \[m\].
        rod: f64,
        /// Bore \[m\].
        bore: f64,
    },
    /// A fitted law that is missing.
    #[error("wood.penetration_law = \"fitted\" needs wood.penetration_fit, the file of a fitted law")]
    NoFit,
    /// An impact beyond those of a fitted law.
    #[error("the projectile strikes at {speed:.3} m/s, and the fitted law holds for {lowest:.3} .. {highest:.3} m/s")]
    BeyondFit {
        /// v0 \[m/s\].
        speed: f64,
        /// Lowest \[m/s\].
        lowest: f64,
        /// Highest \[m/s\].
        highest: f64,
    },
    /// Nothing stops the nail.
    #[error("the nail does not stop within {time} s: the wood resists with less than the weight")]
    NoStop {
        /// Time \[s\].
        time: f64,
    },
    /// The rig does not run with these values.
    #[error("{cause}")]
    Run {
        /// Message of the assembly or its integration.
        cause: String,
    },
}

impl MachineError {
    /// What to do about it.
    pub fn remedy(&self) -> &'static str {
        match self {
            Self::StillPushing { .. } => {
                "put the nail farther away (launch.nail_distance), or shorten launch.stroke or stiffen the bumpers"
            }
            Self::NoLaunch { .. } => "raise launch.reservoir_pressure",
            Self::CellMass { .. } | Self::Rod { .. } => "correct one of the two",
            Self::ThroughBlock { .. } => "use a thicker block (block.thickness), or less energy",
            Self::NoFit => "name the file that `nailnoise penetration fit` wrote, or choose another law",
            Self::BeyondFit { .. } => "choose another speed, or fit with --extrapolate to allow it",
            Self::NoStop { .. } => "check wood.hardness_modulus and wood.penetration_law",
            Self::Run { .. } => "check the machine for values that differ by many orders of magnitude",
        }
    }
}

impl Machine {
    /// Warnings about the machine and its sensors, for a nail that begins at `speed` \[m/s\].
    pub fn warnings(&self, speed: f64) -> Vec<String> {
        let mut warnings = Vec::new();
        let launch = &self.launch;
        if launch.speed == 0.0 && launch.reservoir_pressure > HIGHEST_PRESSURE {
            warnings.push(format!(
                "the reservoir holds {:.2} MPa, more than the 1.48 MPa (1.38 MPa gauge) of the published machine",
                1e-6 * launch.reservoir_pressure
            ));
        }
        let rise = speed / (TIP * self.nail.length);
        let band = [self.sensors.cell_frequency, 0.5 * self.sensors.rate];
        let band = band.into_iter().filter(|hz| *hz > 0.0).fold(f64::INFINITY, f64::min);
        if band < rise {
            warnings.push(format!(
                "the tip enters in 1/{:.1} kHz, and cell and sampling end at {:.1} kHz: the rise of the force is lost",
                1e-3 * rise,
                1e-3 * band
            ));
        }
        warnings
    }
}

/// 1.38 MPa gauge, read as such, over 0.101325 MPa \[Pa\].
const HIGHEST_PRESSURE: f64 = 1.38e6 + 101_325.0;
/// Length of the tip as a fraction of the nail's length.
const TIP: f64 = 0.09;
