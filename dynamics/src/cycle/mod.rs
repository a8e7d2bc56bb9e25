//! One nailing cycle: segments of smooth motion between located events.
//!
//! | part | modules |
//! |---|---|
//! | states, constants and kinematics | `state`, `system`, `start` |
//! | physics | `gas` (restrictions), `flows`, `forces` (springs, contacts), `wood`, `rates` (right-hand side) |
//! | contacts and passages that open and close | `mode`, `switching`, `marks` (events), `history` (delays) |
//! | integration | `integrate`, `equations`, `block_lu`, `tolerances`, `locate`, `coupled` |
//! | results | `recorder`, `balance` (conservation), `summary` |

mod balance;
mod block_lu;
mod coupled;
mod equations;
mod event_functions;
mod flows;
mod forces;
mod gas;
mod history;
mod integrate;
mod locate;
mod mode;
#[cfg(test)]
mod network_agrees;
mod rates;
mod recorder;
mod start;
mod state;
mod summary;
mod switching;
mod system;
mod tolerances;
mod wood;

pub(crate) use gas::{Air, Gas};
pub(crate) use locate::locate;

use crate::{CouplingWork, CycleError, CycleRecord, Parameters, Settings, Workpiece};

/// Computes one nailing cycle, from the trigger pull to 5 ms after the piston comes to rest at the top. It ends no
/// later than `settings.end` or the landing of the tool.
///
/// # Errors
/// [`CycleError`]. A value is out of range, the design is outside the model (spring range, overlapping laps, tool not
/// seated, valve not closed), a dry fire occurs, a contact chatters, or the integration cannot continue.
pub fn simulate(parameters: &Parameters, settings: &Settings) -> Result<CycleRecord, CycleError> {
    start::check(parameters)?;
    settings.check()?;
    let system = system::System::new(parameters);
    let run = integrate::integrate(&system, settings)?;
    Ok(summary::record(&system, run))
}

/// Computes one nailing cycle like [`simulate`] on an external workpiece, coupled in both directions: the forces of the
/// cycle act on the structure, its motion acts on the cycle, and both are consistent at every sample.
///
/// The record's workpiece is then the surface under the nose, and its support that of the structure.
///
/// # Errors
/// The errors of [`simulate`], [`CycleError::Coupling`], and those of the structure.
pub fn simulate_on<W: Workpiece<Error: From<CycleError>>>(
    parameters: &Parameters,
    settings: &Settings,
    wood: &mut W,
) -> Result<(CycleRecord, CouplingWork), W::Error> {
    start::check(parameters)?;
    settings.check()?;
    let system = system::System::new(parameters);
    let (run, work) = coupled::integrate_on(&system, settings, wood)?;
    Ok((summary::record(&system, run), work))
}
