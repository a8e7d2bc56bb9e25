//! Velocity patterns of a problem, and the radiation impedance from the surface pressure.

use super::cover::CoverPatterns;
use super::neumann::{Moments, NeumannData, Patterns};
use super::problem::{Exterior, SurfacePressure};
use crate::bem::error::BemError;
use crate::checks::same_length;
use nalgebra::{Complex, DMatrix};

impl Exterior {
    /// Prepares velocity patterns for solutions at several frequencies.
    ///
    /// # Errors
    /// If the patterns have the wrong length.
    pub(crate) fn neumann_data(&self, patterns: &Patterns) -> Result<NeumannData, BemError> {
        self.check_velocities(&patterns.velocities)?;
        let (boundary, blocks) = (self.boundary(), self.blocks());
        let cover = self.cover().map(|cover| CoverPatterns::new(boundary, cover));
        Ok(NeumannData::new(
            (boundary, blocks),
            self.masses(),
            patterns.clone(),
            cover,
        ))
    }

    /// Modal radiation impedance Z_ij = int v_i p_j dS of every patch; the real part is R, and the imaginary part is
    /// omega times the added mass of the air. With mirror planes, it is the impedance of the complete body.
    ///
    /// # Errors
    /// If patterns or pressures have the wrong length.
    pub fn impedance(
        &self,
        velocities: &DMatrix<f64>,
        solution: &SurfacePressure,
    ) -> Result<Vec<DMatrix<Complex<f64>>>, BemError> {
        self.check_velocities(velocities)?;
        self.impedances(&Moments::by_patch(self.boundary(), self.masses(), velocities), solution)
    }

    /// The same, given the moments of every patch.
    pub(crate) fn impedances(
        &self,
        by_patch: &[Moments],
        solution: &SurfacePressure,
    ) -> Result<Vec<DMatrix<Complex<f64>>>, BemError> {
        same_length(
            "rows of the pressure",
            solution.pressure.nrows(),
            self.boundary().nodes(),
        )?;
        let copies = self.boundary().copies() as f64;
        let of_patch = |moments: &Moments| moments.impedance(copies, &solution.pressure);
        Ok(by_patch.iter().map(of_patch).collect())
    }

    /// Checks the number of velocity values.
    pub(crate) fn check_velocities(&self, velocities: &DMatrix<f64>) -> Result<(), BemError> {
        let rows = velocities.nrows();
        same_length("rows of the normal velocities", rows, self.boundary().velocity_values())?;
        Ok(())
    }
}
