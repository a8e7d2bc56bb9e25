//! The plan of tests at high speed: masses, and three speeds a mass (Nili Ahmadabadi 2016, Table 3-2).

use serde::Serialize;
use thiserror::Error;

use super::driving::drive;
use super::rig::Shot;
use super::{Machine, MachineError};
use nailnoise_penetration::fit::FittedLaw;

/// Masses of the published plan \[kg\]. The first is printed as 0.1293 kg with the speeds of the tool's 0.131 kg: at
/// 0.1293 kg the middle level would be 25.52 m/s.
pub const MASSES: [f64; 5] = [0.131, 0.2, 0.3, 0.4, 0.5];
/// Mass of the tool's piston \[kg\], and its speed with a 12d nail \[m/s\].
pub const TOOL_MASS: f64 = 0.131;
/// See [`TOOL_MASS`].
pub const TOOL_SPEED: f64 = 25.36;
/// Distance of the levels of a mass \[m/s\].
pub const TOOL_SPEED_STEP: f64 = 5.0;

/// A row of a plan.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Row {
    /// M \[kg\].
    pub mass: f64,
    /// Speeds: middle less 5 m/s, middle, middle plus 5 m/s \[m/s\].
    pub speeds: [f64; 3],
    /// M v^2/2 at them \[J\].
    pub energies: [f64; 3],
}

/// Why a plan is not possible.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum PlanError {
    /// A mass or energy that is none.
    #[error("{what} is {value}, and must be above 0")]
    Value {
        /// The quantity.
        what: &'static str,
        /// Its value \[SI\].
        value: f64,
    },
    /// The lower speed level of a mass would not be positive.
    #[error(
        "a projectile of {mass} kg with {energy:.3} J flies at {speed:.3} m/s, not above the {TOOL_SPEED_STEP} m/s \
         between levels"
    )]
    TooSlow {
        /// The mass \[kg\].
        mass: f64,
        /// The energy \[J\].
        energy: f64,
        /// The middle speed \[m/s\].
        speed: f64,
    },
}

/// The plan for these masses \[kg\] at the energy of the middle level \[J\]: v = sqrt(2 E/M), and 5 m/s below and
/// above.
///
/// # Errors
/// [`PlanError`] for values that allow no plan.
pub fn plan(energy: f64, masses: &[f64]) -> Result<Vec<Row>, PlanError> {
    let positive = |what: &'static str, value: f64| {
        if value > 0.0 && value.is_finite() {
            Ok(())
        } else {
            Err(PlanError::Value { what, value })
        }
    };
    positive("the energy (J)", energy)?;
    let row = |mass: &f64| {
        positive("a mass (kg)", *mass)?;
        let speed = (2.0 * energy / mass).sqrt();
        if speed <= TOOL_SPEED_STEP {
            return Err(PlanError::TooSlow {
                mass: *mass,
                energy,
                speed,
            });
        }
        let speeds = [-TOOL_SPEED_STEP, 0.0, TOOL_SPEED_STEP].map(|step| speed + step);
        Ok(Row {
            mass: *mass,
            speeds,
            energies: speeds.map(|speed| 0.5 * mass * speed * speed),
        })
    };
    masses.iter().map(row).collect()
}

/// The impact speed that gives the mean speed NL/(time to full depth) = `mean` \[m/s\] with the law of the machine's
/// wood. None if the nail does not reach its full depth at any such speed.
///
/// # Errors
/// Same as [`drive`], but for a nail that goes through the block.
pub fn speed_for_mean(machine: &Machine, fit: Option<&FittedLaw>, mean: f64) -> Result<Option<f64>, MachineError> {
    let found = |speed: f64| -> Result<Option<f64>, MachineError> {
        let shot = Shot { speed, deviation: 0.0 };
        match drive(machine, fit, shot, f64::INFINITY) {
            Ok(drive) => Ok(drive.head_time.map(|time| machine.nail.length / time)),
            // Faster than any speed asked for.
            Err(MachineError::ThroughBlock { .. }) => Ok(Some(f64::INFINITY)),
            Err(error) => Err(error),
        }
    };
    // NL/time rises with the impact speed, from the lowest speed that reaches full depth.
    let (mut low, mut high) = (mean, 10.0 * mean);
    if found(high)?.is_none_or(|speed| speed < mean) {
        return Ok(None);
    }
    let mut reached = false;
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        match found(middle)? {
            Some(speed) if speed >= mean => high = middle,
            Some(_) => {
                reached = true;
                low = middle;
            }
            None => low = middle,
        }
    }
    // Even the lowest speed that drives the nail home may give a higher mean speed.
    Ok(reached.then_some(high))
}
