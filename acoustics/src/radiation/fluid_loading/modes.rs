use super::error::FluidLoadingError;
use crate::checks::{InputError, same_length};
use nalgebra::{Complex, DMatrix, SymmetricEigen};
use std::f64::consts::TAU;

/// Mass-normalised modes of a structure in vacuum.
#[derive(Debug, Clone, PartialEq)]
pub struct DryModes {
    omega: Vec<f64>,
    zeta: Vec<f64>,
}

impl DryModes {
    /// Creates modes from angular frequencies \[rad/s\], 0 for rigid ones, and damping ratios \[-\].
    ///
    /// # Errors
    /// [`InputError::Length`] if their numbers differ.
    pub fn new(omega: Vec<f64>, zeta: Vec<f64>) -> Result<Self, InputError> {
        same_length("damping ratios of the modes", zeta.len(), omega.len())?;
        Ok(Self { omega, zeta })
    }

    /// Number of modes.
    pub fn count(&self) -> usize {
        self.omega.len()
    }

    /// Angular frequencies \[rad/s\].
    pub fn omega(&self) -> &[f64] {
        &self.omega
    }

    /// 2 zeta Omega \[1/s\].
    pub(super) fn damping(&self, mode: usize) -> f64 {
        2.0 * self.zeta[mode] * self.omega[mode]
    }

    /// -omega² I + j omega (C + Z) + Omega².
    pub(super) fn dynamic_stiffness(
        &self,
        omega: Complex<f64>,
        impedance: &DMatrix<Complex<f64>>,
    ) -> Result<DMatrix<Complex<f64>>, InputError> {
        same_length("rows of the impedance", impedance.nrows(), self.count())?;
        same_length("columns of the impedance", impedance.ncols(), self.count())?;
        let j_omega = Complex::<f64>::i() * omega;
        let mut stiffness = impedance * j_omega;
        for i in 0..self.count() {
            stiffness[(i, i)] += self.omega[i] * self.omega[i] - omega * omega + j_omega * self.damping(i);
        }
        Ok(stiffness)
    }

    /// Undamped modes with an added mass M, in ascending order: angular frequencies, and amplitudes of the dry modes
    /// (dry x wet) with Phi^T (I + M) Phi = I.
    pub(super) fn with_mass(
        &self,
        mass: &DMatrix<f64>,
        hz: f64,
    ) -> Result<(Vec<f64>, DMatrix<f64>), FluidLoadingError> {
        let n = self.count();
        let total = DMatrix::identity(n, n) + (mass + mass.transpose()) * 0.5;
        let cholesky = total.cholesky().ok_or(FluidLoadingError::Mass { hz })?;
        let lower = cholesky.l();
        // L^-1 Omega² L^-T.
        let mut half = DMatrix::from_diagonal(&nalgebra::DVector::from_fn(n, |i, _| self.omega[i]));
        lower.solve_lower_triangular_mut(&mut half);
        let eigen = SymmetricEigen::new(&half * half.transpose());
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        let highest = self.omega.iter().fold(0.0, |a: f64, &b| a.max(b));
        // A frequency below this is the rounding error of a rigid mode.
        let rounding = 1e-7 * highest;
        let omega = order.iter().map(|&k| eigen.eigenvalues[k].max(0.0).sqrt());
        let omega = omega.map(|w| if w < rounding { 0.0 } else { w }).collect();
        let mut shapes = eigen.eigenvectors.select_columns(&order);
        lower.tr_solve_lower_triangular_mut(&mut shapes);
        Ok((omega, shapes))
    }
}

/// Converts an angular frequency to \[Hz\].
pub(super) fn hz(omega: f64) -> f64 {
    omega / TAU
}
