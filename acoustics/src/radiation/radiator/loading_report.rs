//! The effects of the fluid on the sound of radiating bodies.

use super::fluid_loading::Loading;
use super::moving_body::MovingBody;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Change of a source's sound by fluid loading, mode by mode: each mode's share of the energy times the effect of the
/// fluid on that mode ringing at its resonance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FluidLoading {
    /// The loading that acts on the modes.
    pub acts: Loading,
    /// Change of the A-weighted level by R as damping \[dB\]: the modes' own damping and that of radiation, contact
    /// left aside. That which acted, or would have.
    pub damping_db: f64,
    /// Change by X as mass \[dB\], as above; null where the method gives no reactance.
    pub mass_db: Option<f64>,
    /// Largest added mass of a mode up to the highest frequency that boundary elements solve, relative to its own
    /// \[-\].
    pub largest_mass: Option<f64>,
    /// Largest shift of such a mode's frequency, relative \[-\]; negative.
    pub largest_shift: Option<f64>,
}

/// Frequency with an added mass relative to that in vacuum, less one.
pub(crate) fn shift(mass: f64) -> f64 {
    (1.0 + mass.max(0.0)).sqrt().recip() - 1.0
}

impl FluidLoading {
    /// From the energies of all modes of all bodies, one after the other. Masses above `top_hz`, which are upper
    /// bounds, are not among the largest. None where a body's loads are not known.
    pub(crate) fn new(bodies: &[MovingBody<'_>], energies: &[f64], top_hz: f64) -> Option<Self> {
        let total: f64 = energies.iter().sum();
        let acts = bodies.first()?.acts;
        let (mut damped, mut loaded) = (0.0, 0.0);
        let (mut known, mut largest): (bool, Option<f64>) = (true, None);
        let mut energies = energies.iter();
        for body in bodies {
            let loads = body.loads?;
            known &= loads.mass.is_some();
            for (mode, omega) in body.omega.iter().enumerate() {
                let share = energies.next()? / total;
                if *omega == 0.0 || mode >= body.modes {
                    continue;
                }
                if let Some(mass) = loads.mass.as_ref().filter(|_| *omega <= TAU * top_hz) {
                    largest = Some(largest.unwrap_or(0.0).max(mass[mode]));
                }
                // A mode that takes sound from others does so whatever its damping.
                if share > 0.0 {
                    let (by_damping, by_mass) = (loads.of_damping(mode, body.zeta), loads.of_mass(mode));
                    damped += share
                        * if acts.damps() {
                            by_damping - 1.0
                        } else {
                            by_damping.recip() - 1.0
                        };
                    loaded += share
                        * if acts == Loading::Full {
                            by_mass.recip() - 1.0
                        } else {
                            by_mass - 1.0
                        };
                }
            }
        }
        let level = |change: f64, acted: bool| {
            let level = 10.0 * (1.0 + change).log10();
            if acted { 0.0 - level } else { level }
        };
        (total > 0.0).then(|| Self {
            acts,
            damping_db: level(damped, acts.damps()),
            mass_db: known.then(|| level(loaded, acts == Loading::Full)),
            largest_mass: largest,
            largest_shift: largest.map(shift),
        })
    }
}
