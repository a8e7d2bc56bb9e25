//! Mufflers: insertion loss, either measured or computed from chambers and lined pipes by transfer matrices.
//!
//! Only plane waves in air at rest in the ambient state are included; convection of sound by the flow is neglected. The
//! flow resistance of the muffler raises the upstream pressure and slows the cycle. The cycle models it as a
//! restriction downstream of the holes; the raised pressure is
//! [`FlowHistory::back_pressure`](crate::jets::FlowHistory::back_pressure).

mod elements;
pub(crate) mod error;
mod four_pole;

pub use elements::{Lining, MufflerElement, miki_fluid, plane_wave_limit};
pub use error::MufflerError;
pub use four_pole::FourPole;

use crate::air::Air;
use crate::checks::{InputError, finite, positive};
use crate::signals::{Band, band_containing};
use nalgebra::Complex;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Muffler between the exhaust holes and the air.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Muffler {
    /// Measured insertion loss.
    InsertionLoss(BandLosses),
    /// Chambers and pipes.
    Chain(MufflerChain),
}

/// Insertion loss in adjacent one-third-octave bands.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BandLosses {
    first: i32,
    decibels: Vec<f64>,
}

impl BandLosses {
    /// Creates the losses from pairs of nominal mid-band frequency \[Hz\] and insertion loss \[dB\], in ascending order
    /// without gaps.
    ///
    /// # Errors
    /// [`MufflerError::Bands`] if there are no bands, or if they have gaps or are not in order. It also reports values
    /// that are not finite.
    pub fn new(bands: &[(f64, f64)]) -> Result<Self, MufflerError> {
        let decibels: Vec<f64> = bands.iter().map(|band| band.1).collect();
        finite("insertion loss", &decibels)?;
        let index = |hz: f64| -> Result<i32, InputError> {
            positive("mid-band frequency [Hz]", hz).map(|hz| band_containing(hz).index)
        };
        let Some(&(hz, _)) = bands.first() else {
            return Err(MufflerError::Bands { hz: 0.0 });
        };
        let first = index(hz)?;
        for (i, &(hz, _)) in bands.iter().enumerate() {
            if index(hz)? != first + i as i32 {
                return Err(MufflerError::Bands { hz });
            }
        }
        Ok(Self { first, decibels })
    }

    /// Insertion loss of the band that contains the frequency `hz` \[dB\].
    ///
    /// # Errors
    /// [`MufflerError::Bands`] outside the given bands.
    pub fn decibels(&self, hz: f64) -> Result<f64, MufflerError> {
        let i = band_containing(hz).index - self.first;
        let value = usize::try_from(i).ok().and_then(|i| self.decibels.get(i));
        value.copied().ok_or(MufflerError::Bands { hz })
    }

    /// The frequencies covered \[Hz\].
    pub fn range_hz(&self) -> [f64; 2] {
        let last = self.first + self.decibels.len() as i32 - 1;
        [Band::new(self.first).low, Band::new(last).high]
    }
}

/// Elements in series, from the exhaust holes to the outlet.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MufflerChain {
    /// The elements.
    pub elements: Vec<MufflerElement>,
    /// Diameter of the outlet \[m\].
    pub outlet_diameter: f64,
    /// Mach number M of the outflow; its jet damps the resonances of the muffler.
    pub outlet_mach: f64,
}

impl MufflerChain {
    /// Product of the elements' four-poles.
    ///
    /// # Errors
    /// [`MufflerError::NotPlaneWaves`] above the first cross mode of the widest element; also for impossible
    /// dimensions.
    pub fn four_pole(&self, hz: f64, air: &Air) -> Result<FourPole, MufflerError> {
        let mut product = FourPole::IDENTITY;
        for element in &self.elements {
            product = product * element.four_pole(hz, air)?;
        }
        Ok(product)
    }

    /// Transmission loss between anechoic pipes of the two diameters \[dB\]; positive if less sound is transmitted.
    ///
    /// # Errors
    /// See [`Self::four_pole`].
    pub fn transmission_loss(&self, hz: f64, inlet_diameter: f64, air: &Air) -> Result<f64, MufflerError> {
        let impedance = |diameter: f64| air.impedance() / (0.25 * PI * diameter * diameter);
        let four_pole = self.four_pole(hz, air)?;
        Ok(four_pole.transmission_loss(impedance(inlet_diameter), impedance(self.outlet_diameter)))
    }

    /// Insertion loss \[dB\] for a source whose volume flow does not depend on the muffler, such as choked holes that
    /// would otherwise radiate into the open: 20 lg |U_source / U_outlet|. It is negative at resonances of the muffler.
    ///
    /// The outlet radiates into free space, and its jet absorbs sound energy:
    ///
    /// ```text
    /// Z = Z_open end + M rho0 c0 / S
    /// ```
    ///
    /// The second term is Bernoulli's law p = rho U^2/2 for small changes of a quasi-steady jet, dp/dU = rho U.
    ///
    /// # Errors
    /// See [`Self::four_pole`].
    pub fn insertion_loss(&self, hz: f64, air: &Air) -> Result<f64, MufflerError> {
        let area = 0.25 * PI * self.outlet_diameter * self.outlet_diameter;
        let load = open_end(hz, self.outlet_diameter, air) + self.outlet_mach * air.impedance() / area;
        Ok(self.four_pole(hz, air)?.flow_loss(load))
    }
}

/// Low-frequency radiation impedance of an unflanged pipe end \[Pa s/m³\].
///
/// ```text
/// Z = rho0 c0 / S [(k a)^2 / 4 + j 0.6133 k a]
/// ```
///
/// H. Levine & J. Schwinger, Phys. Rev. 73, 383 (1948).
pub fn open_end(hz: f64, diameter: f64, air: &Air) -> Complex<f64> {
    let a = 0.5 * diameter;
    let ka = 2.0 * PI * hz / air.sound_speed * a;
    Complex::new(0.25 * ka * ka, 0.6133 * ka) * (air.impedance() / (PI * a * a))
}

impl Muffler {
    /// The factor 10^{-IL/10} on energy at the frequency `hz`.
    ///
    /// # Errors
    /// If the frequency is outside the bands or above the plane-wave range.
    pub fn energy_factor(&self, hz: f64, air: &Air) -> Result<f64, MufflerError> {
        let loss = match self {
            Self::InsertionLoss(losses) => losses.decibels(hz)?,
            Self::Chain(chain) => chain.insertion_loss(hz, air)?,
        };
        Ok(10f64.powf(-0.1 * loss))
    }
}
