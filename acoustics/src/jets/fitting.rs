use std::f64::consts::PI;

use nalgebra::Complex;
use serde::{Deserialize, Serialize};

use super::open_end::OpenEnd;
use crate::air::Air;
use crate::checks::{InputError, positive};
use crate::muffler::plane_wave_limit;

/// Width of the transition to frequencies above the plane-wave range: a sixth of an octave.
const TRANSITION: f64 = 1.0 / 6.0;

/// A pipe on the exhaust holes. It is closed by the choked holes at one end and open at the other, so it resonates as a
/// quarter-wave resonator.
///
/// The volume flow Q of choked holes does not depend on the pipe. Plane waves transmit U = H Q to the open end, whose
/// impedance r + j x is that of [`OpenEnd`]. The jet at the outlet, p = rho U^2/2, adds M, which absorbs sound but does
/// not radiate.
///
/// ```text
/// H = 1/(cos kL + j z sin kL)     z = r + j x + M     G = |H|^2 4 r/(ka)^2
/// ```
///
/// G is the radiated energy relative to that of the same flow as a monopole in free space. G = 1 is assumed above the
/// first cross mode of the pipe; there is a transition over the sixth of an octave below it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PipeFitting {
    /// Length L from the holes to the open end \[m\].
    pub length: f64,
    /// Inner diameter \[m\].
    pub diameter: f64,
    /// Mach number M of the mean flow at the outlet.
    pub outlet_mach: f64,
}

impl PipeFitting {
    /// Ratio H of the volume flows at the open end and at the holes, for an end impedance z normalised by rho0 c0/S.
    pub fn flow_ratio(&self, hz: f64, end: Complex<f64>, air: &Air) -> Complex<f64> {
        let (sine, cosine) = (2.0 * PI * hz / air.sound_speed * self.length).sin_cos();
        (cosine + Complex::<f64>::i() * end * sine).inv()
    }

    /// Upper frequency limit of plane waves \[Hz\].
    pub fn plane_wave_limit(&self, air: &Air) -> f64 {
        plane_wave_limit(self.diameter, air.sound_speed)
    }

    /// Energy G(f) relative to that of the monopole without the fitting.
    ///
    /// # Errors
    /// If dimensions or frequency are not positive, or the Mach number is negative.
    pub fn gain(&self, hz: f64, air: &Air) -> Result<f64, InputError> {
        self.response(hz, air).map(|response| response.norm_sqr())
    }

    /// Factor on the monopole's signal; its square is G.
    ///
    /// # Errors
    /// Same as [`gain`](Self::gain).
    pub fn response(&self, hz: f64, air: &Air) -> Result<Complex<f64>, InputError> {
        positive("frequency [Hz]", hz)?;
        let k = 2.0 * PI * hz / air.sound_speed;
        let limit = self.plane_wave_limit(air);
        let above = Complex::from_polar(1.0, -k * self.length);
        // 0 in the plane-wave range, 1 at and above the first cross mode.
        let share = (1.0 + (hz / limit).log2() / TRANSITION).clamp(0.0, 1.0);
        if share >= 1.0 {
            return Ok(above);
        }
        let ka = 0.5 * k * self.diameter;
        let end = OpenEnd::new(ka)?.impedance;
        let plane = self.flow_ratio(hz, end + self.outlet_mach, air) * (2.0 * end.re.sqrt() / ka);
        if share <= 0.0 {
            return Ok(plane);
        }
        let energy = (1.0 - share) * plane.norm_sqr() + share;
        let direction = plane.unscale(plane.norm()).scale(1.0 - share) + above.scale(share);
        Ok(Complex::from_polar(energy.sqrt(), direction.arg()))
    }

    pub(super) fn check(&self) -> Result<(), InputError> {
        positive("length of the exhaust fitting [m]", self.length)?;
        positive("diameter of the exhaust fitting [m]", self.diameter)?;
        if self.outlet_mach >= 0.0 && self.outlet_mach <= 1.0 {
            return Ok(());
        }
        Err(InputError::OutsideRange {
            what: "Mach number at the outlet of the exhaust fitting",
            value: self.outlet_mach,
            low: 0.0,
            high: 1.0,
        })
    }
}
