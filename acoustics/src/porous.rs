//! A porous layer on a vibrating wall, as a two-port between the wall and the layer's outer face.

use crate::air::Air;
use crate::checks::{InputError, positive};
use crate::muffler::miki_fluid;
use nalgebra::Complex;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Motion of the frame, that is, of the solid part of a porous layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Frame {
    /// It moves with the wall as a rigid body: the layer is glued to the wall, well below the first resonance of its
    /// thickness.
    Moving,
    /// It is at rest: the layer is decoupled from the wall, or far above that resonance.
    Resting,
}

/// A layer of open-cell foam or fibres on a wall. It reacts locally: sound in it propagates only along the normal.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PorousLayer {
    thickness: f64,
    resistivity: f64,
    frame: Frame,
}

/// The two-port of a layer at one frequency. The outer face has the velocity v = T v_s - Y p, where v_s is that of the
/// wall and p the pressure on the outer face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LayerTransfer {
    /// T: velocity of the outer face without pressure, relative to that of the wall.
    pub velocity: Complex<f64>,
    /// Y: admittance of the outer face, that is, its inward velocity divided by the pressure with the wall at rest
    /// \[m/(s Pa)\].
    pub admittance: Complex<f64>,
}

impl PorousLayer {
    /// A layer with the thickness t \[m\] (zero for no layer) and the flow resistivity sigma \[Pa s/m²\].
    ///
    /// # Errors
    /// If the thickness is negative or not finite, or if the resistivity is not positive.
    pub fn new(thickness: f64, resistivity: f64, frame: Frame) -> Result<Self, InputError> {
        if !(thickness.is_finite() && thickness >= 0.0) {
            return Err(InputError::OutsideRange {
                what: "thickness of a porous layer [m]",
                value: thickness,
                low: 0.0,
                high: f64::INFINITY,
            });
        }
        Ok(Self {
            thickness,
            resistivity: positive("flow resistivity of a porous layer [Pa s/m2]", resistivity)?,
            frame,
        })
    }

    /// Frequency above which the fit of the material is extrapolated \[Hz\]: f/sigma = 1 m³/kg. There, the formulas
    /// tend to those of air.
    pub fn fitted_to_hz(&self) -> f64 {
        self.resistivity
    }

    /// The layer that gives, in standard air and at the same wavelength, the results of this layer in the given air.
    /// This is possible because Z/(rho c) and k c/omega depend only on f/sigma.
    #[must_use]
    pub fn in_standard_air(&self, air: &Air) -> Self {
        Self {
            resistivity: self.resistivity * Air::default().sound_speed / air.sound_speed,
            ..*self
        }
    }

    /// The two-port at the frequency `hz`.
    ///
    /// The air in the pores is a fluid with the impedance Z and the wavenumber k of [`miki_fluid`]. Its density is
    /// given by rho = Z k/omega, and its bulk modulus by K = omega Z/k. The frame has the velocity w and drags the air;
    /// the mass of the frame is neglected.
    ///
    /// ```text
    /// -dp/dx = j omega rho (v - w) + j omega rho0 w      -dv/dx = j omega p/K      v(0) = v_s
    /// v(t) = T v_s - Y p(t)                              Y = j tan(k t)/Z
    /// w = 0:    T = 1/cos(k t)
    /// w = v_s:  T = 1 + (rho0/rho) (1/cos(k t) - 1)
    /// ```
    ///
    /// With w = 0 this is the transfer matrix of a layer of fluid (Allard & Atalla 2009, section 2.3). Y is the
    /// admittance of the layer on a rigid wall in both cases. Without flow resistance, |T/(1 + rho0 c0 Y)| = 1 in both
    /// cases, because a layer of air does not change a plane wave.
    pub fn transfer(&self, hz: f64, air: &Air) -> LayerTransfer {
        let (z, k) = miki_fluid(hz, self.resistivity, air);
        let along = k * self.thickness;
        let resting = along.cos().inv();
        let free = 2.0 * PI * hz / air.sound_speed;
        LayerTransfer {
            velocity: match self.frame {
                Frame::Resting => resting,
                Frame::Moving => 1.0 + free / (z * k) * (resting - 1.0),
            },
            admittance: Complex::<f64>::i() * along.tan() / (z * air.impedance()),
        }
    }

    /// Power of a plane wave from the covered wall, relative to that from the bare one: |T/(1 + rho0 c0 Y)|².
    pub fn plane_wave_power(&self, hz: f64, air: &Air) -> f64 {
        let of = self.transfer(hz, air);
        (of.velocity / (1.0 + of.admittance * air.impedance())).norm_sqr()
    }
}
