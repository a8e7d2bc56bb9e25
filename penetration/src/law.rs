//! The published laws and their evaluation.

use nailnoise_quantities::choice;
use serde::{Deserialize, Serialize};

use super::RangeError;
use super::dual::Real;
use super::{HIGHEST_SPEED, LOWEST_SPEED};

choice! {
    /// A published law of the penetration resistance force.
    PenetrationLaw {
        /// Smooth shank in plywood (Table 2-6).
        Smooth = "smooth",
        /// Annular shank in plywood (Table 2-6).
        Annular = "annular",
        /// Helical shank in plywood (Table 2-6).
        Helical = "helical",
        /// All shanks in plywood (Table 2-6).
        General = "general",
        /// General law without C9 (Table 2-8).
        Reduced1 = "reduced1",
        /// General law up to C7 (Table 2-8).
        Reduced2 = "reduced2",
        /// General law up to C6 (Table 2-8).
        Reduced3 = "reduced3",
        /// General law up to C5 (Table 2-8).
        Reduced4 = "reduced4",
        /// General law up to C4 (Table 2-8).
        Reduced5 = "reduced5",
        /// General law up to C3 (Table 2-8).
        Reduced6 = "reduced6",
        /// Solid wood (Eq. 4.59).
        SolidWood = "solid_wood",
    }
}

/// A nail in a wood: the inputs of the laws other than depth and speed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Specimen {
    /// NL, nail length \[m\].
    pub length: f64,
    /// D, nominal shank diameter \[m\].
    pub diameter: f64,
    /// H_M, hardness modulus \[N/m\].
    pub hardness_modulus: f64,
    /// rho, wood density \[kg/m3\].
    pub density: f64,
}

impl PenetrationLaw {
    /// Penetration resistance force \[N\] at `depth` \[m\] and penetration speed `speed` \[m/s\]; zero at or above the
    /// surface.
    ///
    /// # Errors
    /// [`RangeError::PenetrationSpeed`] outside the quasi-static range of the laws, 3.33e-4 to 8.4e-3 m/s, and
    /// [`RangeError::PenetrationDepth`] beyond the nail's length.
    pub fn force(self, specimen: &Specimen, depth: f64, speed: f64) -> Result<f64, RangeError> {
        // The source gives the bounds to three digits, so exactly 20 mm/min must pass.
        if !(LOWEST_SPEED * (1.0 - 1e-12)..=HIGHEST_SPEED).contains(&speed) {
            return Err(RangeError::PenetrationSpeed {
                speed,
                lowest: LOWEST_SPEED,
                highest: HIGHEST_SPEED,
            });
        }
        if depth.is_nan() || depth > specimen.length * (1.0 + 1e-12) {
            return Err(RangeError::PenetrationDepth {
                depth,
                length: specimen.length,
            });
        }
        Ok(self.curve(specimen, speed).force(depth))
    }

    /// The law as a function of depth only, at a fixed speed.
    pub fn curve(self, specimen: &Specimen, speed: f64) -> Curve {
        Curve::new(&self.coefficients(), specimen, speed)
    }
}

/// F_r(y) = scale max(0, root(y/NL))^2.
#[derive(Debug, Clone, Copy)]
pub struct Curve {
    root: [f64; 8],
    length: f64,
    scale: f64,
}

impl Curve {
    /// Eq. 2.2 with coefficients C0..C9 at a fixed speed.
    pub fn new(c: &[f64; 10], specimen: &Specimen, speed: f64) -> Self {
        let pi3 = specimen.length * specimen.density * speed * speed / specimen.hardness_modulus;
        let pi4 = specimen.diameter / specimen.length;
        let mut root = [0.0; 8];
        root.copy_from_slice(&c[..8]);
        root[0] += c[8] * pi3 + c[9] * pi4;
        Self {
            root,
            length: specimen.length,
            scale: specimen.hardness_modulus * specimen.length,
        }
    }

    /// Creates scale max(0, root(y/NL))^2 from the coefficients, the nail's length \[m\] and the scale \[N\].
    pub fn of(root: [f64; 8], length: f64, scale: f64) -> Self {
        Self { root, length, scale }
    }

    /// Force at `z` with its derivative, smoothly continued above the surface.
    #[inline]
    pub fn evaluate<S: Real>(&self, z: S) -> S {
        let root = (z * (1.0 / self.length)).polynomial(&self.root);
        if root.value() > 0.0 {
            root * root * self.scale
        } else {
            S::constant(0.0)
        }
    }

    /// Force at `depth` \[N\], 0 above the surface.
    #[inline]
    pub fn force(&self, depth: f64) -> f64 {
        if depth <= 0.0 {
            return 0.0;
        }
        let x = depth / self.length;
        let root = self.root.iter().rev().fold(0.0, |sum, c| sum * x + c).max(0.0);
        self.scale * root * root
    }
}
