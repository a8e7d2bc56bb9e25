use std::f64::consts::PI;

use nalgebra::Complex;
use serde::{Deserialize, Serialize};

use super::open_end::OpenEnd;
use crate::air::Air;
use crate::checks::{InputError, positive};
use crate::muffler::plane_wave_limit;

/// Width of the transition to the range above the plane waves: a sixth of an octave.
const TRANSITION: f64 = 1.0 / 6.0;

/// A pipe on the exhaust holes, open at its end: closed by the choked holes on one side, it resonates as a quarter
/// wave.
///
/// The volume flow Q of choked holes does not depend on the pipe. Plane waves carry U = H Q to the open end, whose
/// impedance r + j x is that of [`OpenEnd`]. The jet at the outlet, p = rho U^2/2, adds M, which absorbs and does not
/// radiate.
///
/// ```text
/// H = 1/(cos kL + j z sin kL)     z = r + j x + M     G = |H|^2 4 r/(ka)^2
/// ```
///
/// G is the energy over that of the same flow as a monopole in the open. Above the first cross mode of the pipe, G = 1
/// is assumed; over the sixth of an octave below it, G goes over to 1.
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
    /// Ratio H of the volume flows at the open end and at the holes, for an impedance z of the end over rho0 c0/S.
    pub fn flow_ratio(&self, hz: f64, end: Complex<f64>, air: &Air) -> Complex<f64> {
        let (sine, cosine) = (2.0 * PI * hz / air.sound_speed * self.length).sin_cos();
        (cosine + Complex::<f64>::i() * end * sine).inv()
    }

    /// Highest frequency of plane waves \[Hz\].
    pub fn plane_wave_limit(&self, air: &Air) -> f64 {
        plane_wave_limit(self.diameter, air.sound_speed)
    }

    /// Energy G(f) over that of the monopole without the fitting.
    ///
    /// # Errors
    /// Dimensions that are not positive, a negative Mach number, a frequency that is not positive.
    pub fn gain(&self, hz: f64, air: &Air) -> Result<f64, InputError> {
        self.response(hz, air).map(|response| response.norm_sqr())
    }

    /// Factor on the signal of the monopole; its square is G.
    ///
    /// # Errors
    /// As [`gain`](Self::gain).
    pub fn response(&self, hz: f64, air: &Air) -> Result<Complex<f64>, InputError> {
        positive("frequency [Hz]", hz)?;
        let k = 2.0 * PI * hz / air.sound_speed;
        let limit = self.plane_wave_limit(air);
        let above = Complex::from_polar(1.0, -k * self.length);
        // 0 where only plane waves run, 1 at the first cross mode and above it.
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
