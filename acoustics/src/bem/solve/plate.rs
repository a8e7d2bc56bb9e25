//! Thin flat plates: one side wet in a rigid baffle, or both sides wet.
//!
//! A plate of zero thickness moves with v along its normal n. With G = e^{-jkr} / (4 pi r), W is the hypersingular
//! operator of [`Exterior`]; the operators K and K' vanish in a plane. The pressure on the wet side of a plate in a
//! rigid baffle is given by Rayleigh's integral. The pressure difference across a plate in free fluid solves the second
//! equation (Maue 1949; Stephan 1987 for open surfaces).
//!
//! ```text
//! p = 2 j omega rho S v                                   one side
//! W [p] = j omega rho v,  [p] = 0 at the free edges       both sides; [p] = pressure on the side of n less that behind
//! ```
//!
//! Near an edge, the difference [p] is proportional to the square root of the distance, so panels should become narrow
//! there. With panels of equal width, the added mass is too small, with a first-order error in the width.

use super::neumann::Patterns;
use super::problem::{Exterior, SurfacePressure, Threads};
use crate::air::Air;
use crate::bem::error::BemError;
use crate::bem::mesh::boundary::Boundary;
use crate::bem::operators::wave::Wave;
use crate::checks::positive;
use nalgebra::{Complex, DMatrix};
use std::f64::consts::PI;

/// Which sides of a plate are in contact with the fluid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WetSides {
    /// The side of the normal, with the plate in a rigid baffle.
    OneInBaffle,
    /// Both sides, in free fluid.
    Both,
}

/// A thin flat plate in a fluid.
#[derive(Debug)]
pub struct Plate {
    surface: Exterior,
    wetted: WetSides,
}

impl Plate {
    /// Creates a plate from its midplane, see [`Boundary::flat`].
    pub fn new(midplane: Boundary, fluid: &Air, wetted: WetSides) -> Self {
        Self {
            surface: Exterior::new(midplane, fluid),
            wetted,
        }
    }

    /// The midplane.
    pub fn boundary(&self) -> &Boundary {
        self.surface.boundary()
    }

    /// Modal radiation impedance Z_ij = int v_i p_j dS \[kg/s\] at `hz` for normal velocities of one parity (corner
    /// values of each panel x patterns, see [`Boundary::project`]). It is symmetric: its real part is R, its imaginary
    /// part omega times the added mass.
    ///
    /// # Errors
    /// Those of [`Exterior::solve_parities`].
    pub fn impedance(&self, hz: f64, patterns: &Patterns) -> Result<DMatrix<Complex<f64>>, BemError> {
        positive("frequency [Hz]", hz)?;
        self.surface.check_resolution(hz)?;
        let data = self.surface.neumann_data(patterns)?;
        let omega = 2.0 * PI * hz;
        let k = omega / self.surface.air().sound_speed;
        // alpha W = -j coupling W; if the length 1/k is used as coupling, both operators have the magnitude of the
        // identity.
        let coupling = match self.wetted {
            WetSides::OneInBaffle => 0.0,
            WetSides::Both => self.boundary().half_width().min(1.0 / k),
        };
        let mut factor = Complex::new(0.0, omega * self.surface.air().density);
        let mut pressure = DMatrix::zeros(self.boundary().nodes(), data.count());
        for mut sums in self
            .surface
            .integrals(Wave { k, coupling }, std::slice::from_ref(&data), Threads::One)
        {
            match self.wetted {
                WetSides::OneInBaffle => self.surface.add_mass(&mut sums.matrix, 0.5),
                WetSides::Both => {
                    // Discards the contributions of K and S: rounding in the matrix, and all of S v on the right.
                    sums.right.iter_mut().for_each(|right| right.fill(0.0));
                    data.moments().add_to(1.0, &mut sums.right[0]);
                    factor *= Complex::new(0.0, -coupling);
                    for node in 0..self.boundary().nodes() {
                        if self.boundary().on_free_edge(node) {
                            sums.hold(node);
                        }
                    }
                }
            }
            self.surface.hold_odd(patterns.parity, &mut sums);
            pressure = sums.solve(factor);
        }
        let solution = SurfacePressure {
            hz,
            parity: patterns.parity,
            pressure,
        };
        let parts = self.surface.impedances(data.by_patch(), &solution)?;
        let zeros = DMatrix::zeros(data.count(), data.count());
        let whole = parts.into_iter().fold(zeros, |sum, z| sum + z);
        Ok((&whole + whole.transpose()) * Complex::from(0.5))
    }
}
