use super::image;
use crate::air::Air;
use crate::checks::{ReceiverError, positive};
use nalgebra::{Complex, Point3};
use std::f64::consts::PI;

/// Transfer from the energy of an omnidirectional source to the sound exposure at a point, with the delay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OmnidirectionalTransfer {
    /// Ratio of sound exposure to sound energy \[Pa² s / J\].
    pub exposure_per_energy: f64,
    /// Travel time \[s\].
    pub delay: f64,
}

impl OmnidirectionalTransfer {
    /// The pressure due to a signal x with E = 2 |x|² \[Pa s\].
    pub fn pressure(&self, hz: f64, signal: Complex<f64>) -> Complex<f64> {
        signal * Complex::from_polar(self.exposure_per_energy.sqrt(), -2.0 * PI * hz * self.delay)
    }
}

/// Transfer from an omnidirectional source of known energy to a point, including the energy of the floor reflection.
///
/// ```text
/// E_p = E rho0 c0 / (4 pi) (1/r^2 + 1/r'^2)
/// ```
///
/// The result contains no directivity. Differences between microphones of an array therefore carry no information about
/// it.
///
/// # Errors
/// If the point is at the source or below the floor.
pub fn omnidirectional_transfer(
    centre: Point3<f64>,
    place: Point3<f64>,
    floor: f64,
    air: &Air,
) -> Result<OmnidirectionalTransfer, ReceiverError> {
    for z in [centre.z, place.z] {
        if z.is_nan() || z < floor {
            return Err(ReceiverError::BelowFloor { z, floor });
        }
    }
    let [r, reflected] = [centre, image(centre, floor)].map(|from| (place - from).norm());
    positive("distance of a receiver from the source [m]", r)?;
    Ok(OmnidirectionalTransfer {
        exposure_per_energy: air.impedance() / (4.0 * PI) * (r.powi(-2) + reflected.powi(-2)),
        delay: r / air.sound_speed,
    })
}
