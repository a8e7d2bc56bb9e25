use super::error::MufflerError;
use super::four_pole::FourPole;
use crate::air::Air;
use crate::checks::{InputError, positive};
use nalgebra::Complex;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// First zero of J_1': the first cross mode of a round pipe cuts on at k d / 2 = 1.8412.
const CROSS_MODE: f64 = 1.841_183_781_340_659;

/// One element of a muffler: a round pipe or chamber, empty or lined.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MufflerElement {
    /// Length \[m\].
    pub length: f64,
    /// Inner diameter inside the lining \[m\].
    pub diameter: f64,
    /// Porous lining of the entire wall.
    pub lining: Option<Lining>,
}

/// A locally reacting porous layer on a rigid wall.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Lining {
    /// Thickness \[m\].
    pub thickness: f64,
    /// Flow resistivity sigma \[Pa s/m²\].
    pub resistivity: f64,
}

/// Normalised impedance Z/(rho0 c0) and wavenumber \[1/m\] of sound inside a porous material.
///
/// ```text
/// Z / (rho0 c0) = 1 + 0.070 x^{-0.632} - j 0.107 x^{-0.632}          x = f/sigma
/// k / (omega/c0) = 1 + 0.109 x^{-0.618} - j 0.160 x^{-0.618}
/// ```
///
/// Y. Miki, J. Acoust. Soc. Jpn. (E) 11, 19 (1990), after Delany & Bazley (1970); fitted for 0.01 < x < 1, causal below
/// that range.
pub fn miki_fluid(hz: f64, resistivity: f64, air: &Air) -> (Complex<f64>, Complex<f64>) {
    let x = hz / resistivity;
    let (z, k) = (x.powf(-0.632), x.powf(-0.618));
    let free = 2.0 * PI * hz / air.sound_speed;
    (
        Complex::new(1.0 + 0.070 * z, -0.107 * z),
        Complex::new(1.0 + 0.109 * k, -0.160 * k) * free,
    )
}

impl Lining {
    /// Normalised admittance of the layer in front of a rigid wall, beta = j tan(k t) rho0 c0 / Z.
    ///
    /// # Errors
    /// If the frequency is above the range of the fit, f/sigma = 1.
    pub fn admittance(&self, hz: f64, air: &Air) -> Result<Complex<f64>, MufflerError> {
        positive("thickness of the lining [m]", self.thickness)?;
        positive("flow resistivity of the lining [Pa s/m2]", self.resistivity)?;
        if hz > self.resistivity {
            return Err(InputError::OutsideRange {
                what: "frequency over flow resistivity of the lining [m3/kg]",
                value: hz / self.resistivity,
                low: 0.0,
                high: 1.0,
            }
            .into());
        }
        let (z, k) = miki_fluid(hz, self.resistivity, air);
        Ok(Complex::<f64>::i() * (k * self.thickness).tan() / z)
    }
}

/// Highest frequency \[Hz\] at which only plane waves propagate in a round pipe of the given diameter \[m\]: the cut-on
/// of the first cross mode, k d/2 = 1.8412. `sound_speed` in m/s.
pub fn plane_wave_limit(diameter: f64, sound_speed: f64) -> f64 {
    CROSS_MODE * sound_speed / (PI * diameter)
}

impl MufflerElement {
    /// Highest frequency of plane waves in the element, [`plane_wave_limit`] \[Hz\].
    pub fn highest_hz(&self, air: &Air) -> f64 {
        plane_wave_limit(self.diameter, air.sound_speed)
    }

    /// The element's four-pole.
    ///
    /// ```text
    /// k_z = sqrt(k^2 - j k beta P/S)      Z = rho0 c0 k / (S k_z)
    /// ```
    ///
    /// P/S = 4/d is perimeter over area. The fundamental mode of the lined pipe is approximated as a plane wave, and
    /// the wall as flat. This is valid if the lining is thin compared with the pipe and |beta| k d < 1.
    ///
    /// # Errors
    /// [`MufflerError::NotPlaneWaves`] above [`Self::highest_hz`]; also for impossible dimensions or a lining outside
    /// the range of its fit.
    pub fn four_pole(&self, hz: f64, air: &Air) -> Result<FourPole, MufflerError> {
        positive("length of a muffler's element [m]", self.length)?;
        positive("diameter of a muffler's element [m]", self.diameter)?;
        positive("frequency [Hz]", hz)?;
        let highest = self.highest_hz(air);
        if hz > highest {
            return Err(MufflerError::NotPlaneWaves {
                hz,
                diameter: self.diameter,
                highest,
            });
        }
        let k = 2.0 * PI * hz / air.sound_speed;
        let area = 0.25 * PI * self.diameter * self.diameter;
        let beta = match &self.lining {
            Some(lining) => lining.admittance(hz, air)?,
            None => Complex::ZERO,
        };
        // The principal root decays along the pipe: its imaginary part is negative for an absorbing wall.
        let along = (Complex::from(k * k) - Complex::<f64>::i() * k * beta * (4.0 / self.diameter)).sqrt();
        Ok(FourPole::pipe(
            along,
            along.inv() * (air.impedance() * k / area),
            self.length,
        ))
    }
}
