use std::f64::consts::PI;

use nalgebra::Complex;
use serde::{Deserialize, Serialize};

use super::open_end::OpenEnd;
use crate::air::Air;
use crate::checks::{InputError, positive};
use crate::muffler::plane_wave_limit;

/// Width of the transition to frequencies above the plane-wave range: a sixth of an octave.
const TRANSITION: f64 = 1.0 / 6.0;

/// A pipe on the exhaust holes. The choked holes close it at one end, and the other end is open, so that the gas inside
/// it resonates as a quarter wave.
///
/// The volume flow Q of choked holes does not depend on the pipe. Plane waves carry U = H Q to the open end. The gas of
/// the outflow fills the pipe. Because it leaves as a jet, it also fills the near field of the mouth. The far field is
/// the ambient air. The impedance of the end, divided by rho c/S of the outflow's gas, has three parts. The reactance x
/// of [`OpenEnd`] is evaluated in this gas, and its resistance r in the ambient air. The jet, p = rho U^2/2, adds the
/// resistance M, which absorbs sound and does not radiate it.
///
/// ```text
/// k = 2 pi f/c, k0 = 2 pi f/c0                    z = (rho0 c0/rho c) r(k0 a) + j x(k a) + M
/// H = 1/(cos kL + j z sin kL)                     G = |H|^2 4 r(k0 a)/(k0 a)^2
/// ```
///
/// G is the radiated energy relative to that of the same flow as a monopole in free space. G = 1 is assumed above the
/// first cross mode of the pipe, with a transition over the sixth of an octave below it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PipeFitting {
    /// Length L from the holes to the open end \[m\].
    pub length: f64,
    /// Inner diameter \[m\].
    pub diameter: f64,
    /// Mach number M of the mean flow at the outlet.
    pub outlet_mach: f64,
    /// Temperature of the gas inside \[K\]; `None` for the stagnation temperature of the outflow.
    pub temperature: Option<f64>,
}

/// A pipe fitting with the gas inside it, in the air outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilledFitting {
    /// The pipe.
    pub pipe: PipeFitting,
    /// The gas inside, at ambient pressure.
    pub gas: Air,
    /// The ambient air.
    pub outside: Air,
}

impl PipeFitting {
    /// Fills the pipe with gas at `temperature`. If that is `None`, the gas has the stagnation temperature `outflow`
    /// \[K\], because the flow in the pipe is slow. `outside` is the ambient air.
    ///
    /// # Errors
    /// If a dimension or temperature is not positive, or the Mach number is outside 0 to 1.
    pub fn filled(&self, outflow: f64, outside: &Air) -> Result<FilledFitting, InputError> {
        self.check()?;
        let temperature = self.temperature.unwrap_or(outflow);
        Ok(FilledFitting {
            pipe: *self,
            gas: outside.in_state(temperature, outside.pressure)?,
            outside: *outside,
        })
    }

    fn check(&self) -> Result<(), InputError> {
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

impl FilledFitting {
    /// Ratio H of the volume flows at the open end and at the holes, for an impedance z of the end divided by rho c/S
    /// of the gas inside.
    pub fn flow_ratio(&self, hz: f64, end: Complex<f64>) -> Complex<f64> {
        let (sine, cosine) = (2.0 * PI * hz / self.gas.sound_speed * self.pipe.length).sin_cos();
        (cosine + Complex::<f64>::i() * end * sine).inv()
    }

    /// Upper frequency limit of plane waves \[Hz\].
    pub fn plane_wave_limit(&self) -> f64 {
        plane_wave_limit(self.pipe.diameter, self.gas.sound_speed)
    }

    /// Energy G(f) relative to that of the monopole without the fitting.
    ///
    /// # Errors
    /// If the frequency is not positive.
    pub fn gain(&self, hz: f64) -> Result<f64, InputError> {
        self.response(hz).map(|response| response.norm_sqr())
    }

    /// Factor on the monopole's signal; its square is G.
    ///
    /// # Errors
    /// Same as [`gain`](Self::gain).
    pub fn response(&self, hz: f64) -> Result<Complex<f64>, InputError> {
        positive("frequency [Hz]", hz)?;
        let k = 2.0 * PI * hz / self.gas.sound_speed;
        let limit = self.plane_wave_limit();
        let above = Complex::from_polar(1.0, -k * self.pipe.length);
        // 0 in the plane-wave range, 1 at and above the first cross mode.
        let share = (1.0 + (hz / limit).log2() / TRANSITION).clamp(0.0, 1.0);
        if share >= 1.0 {
            return Ok(above);
        }
        let radius = 0.5 * self.pipe.diameter;
        let outer_ka = 2.0 * PI * hz / self.outside.sound_speed * radius;
        let reactance = OpenEnd::new(k * radius)?.impedance.im;
        let resistance = OpenEnd::new(outer_ka)?.impedance.re;
        let radiation = resistance * self.outside.impedance() / self.gas.impedance();
        let end = Complex::new(radiation + self.pipe.outlet_mach, reactance);
        let plane = self.flow_ratio(hz, end) * (2.0 * resistance.sqrt() / outer_ka);
        if share <= 0.0 {
            return Ok(plane);
        }
        let energy = (1.0 - share) * plane.norm_sqr() + share;
        let direction = plane.unscale(plane.norm()).scale(1.0 - share) + above.scale(share);
        Ok(Complex::from_polar(energy.sqrt(), direction.arg()))
    }
}
