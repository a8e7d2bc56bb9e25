//! Effects of the fluid on the sound of radiating bodies.

use super::fluid_loading::Loading;
use super::moving_body::MovingBody;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Change in a source's sound due to fluid loading: the sum over modes of each mode's share of the energy times the
/// effect of the fluid on that mode, ringing at its resonance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FluidLoading {
    /// The part of the loading that acts on the modes.
    pub acts: Loading,
    /// Change in the A-weighted level due to R as damping \[dB\], considering structural and radiation damping but not
    /// contact. It is the actual change, or the change that would occur if R acted.
    pub damping_db: f64,
    /// Change due to X as mass \[dB\], likewise; null if the method provides no reactance.
    pub mass_db: Option<f64>,
    /// Largest added mass, relative to the modal mass, of modes up to the highest frequency that boundary elements
    /// solve \[-\].
    pub largest_mass: Option<f64>,
    /// Largest relative frequency shift of such a mode \[-\]; negative.
    pub largest_shift: Option<f64>,
}

/// Relative change of a frequency due to an added mass.
pub(crate) fn shift(mass: f64) -> f64 {
    (1.0 + mass.max(0.0)).sqrt().recip() - 1.0
}

impl FluidLoading {
    /// Computes the changes from the energies of all modes of all bodies, one body after another. Masses above
    /// `top_hz`, which are upper bounds, are not considered for the largest value. None if a body's loads are unknown.
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
                // A mode that absorbs sound from others does so whatever its damping.
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
