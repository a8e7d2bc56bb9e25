use super::image;
use crate::air::Air;
use crate::checks::{ReceiverError, positive};
use nalgebra::{Complex, Point3};
use std::f64::consts::PI;

/// How much of an evenly spread source's energy a place hears, and when.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Sound exposure over sound energy \[Pa² s / J\].
    pub exposure_per_energy: f64,
    /// Travel time \[s\].
    pub delay: f64,
}

impl Spread {
    /// The pressure of a signal x with E = 2 |x|² \[Pa s\].
    pub fn pressure(&self, hz: f64, signal: Complex<f64>) -> Complex<f64> {
        signal * Complex::from_polar(self.exposure_per_energy.sqrt(), -2.0 * PI * hz * self.delay)
    }
}

/// A source that is known by its energy alone, spread evenly from one point; the floor's reflection adds its energy.
///
/// ```text
/// E_p = E rho0 c0 / (4 pi) (1/r^2 + 1/r'^2)
/// ```
///
/// Around it no direction is louder than another: levels by an array of microphones say nothing of its directivity.
///
/// # Errors
/// A place at the source, or below the floor.
pub fn spread_evenly(centre: Point3<f64>, place: Point3<f64>, floor: f64, air: &Air) -> Result<Spread, ReceiverError> {
    for z in [centre.z, place.z] {
        if z.is_nan() || z < floor {
            return Err(ReceiverError::BelowFloor { z, floor });
        }
    }
    let [r, reflected] = [centre, image(centre, floor)].map(|from| (place - from).norm());
    positive("distance of a receiver from the source [m]", r)?;
    Ok(Spread {
        exposure_per_energy: air.impedance() / (4.0 * PI) * (r.powi(-2) + reflected.powi(-2)),
        delay: r / air.sound_speed,
    })
}
