//! Modes with the fluid's mass and damping frozen at each mode's resonance, for time-domain motion.

use super::error::FluidLoadingError;
use super::modes::{DryModes, hz};
use crate::checks::same_length;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// Number of passes over the wet resonances; the first pass uses the mass at the dry ones.
const PASSES: usize = 3;

/// Modes of a structure with the added mass of the fluid and radiation damping.
///
/// ```text
/// M_ij = [X_ij(w_i)/w_i + X_ij(w_j)/w_j] / 2          symmetric, at the wet resonances w
/// (Omega² - w² (I + M)) Phi = 0,  Phi^T (I + M) Phi = I
/// zeta = [Phi^T C Phi + Phi^T R(w) Phi] / (2 w)       of each column of Phi
/// ```
///
/// R and X off resonance, the off-diagonal elements of Phi^T (C + R) Phi, and echoes are neglected.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WetModes {
    /// Angular frequencies in ascending order \[rad/s\]; 0 for rigid modes.
    pub omega: Vec<f64>,
    /// Damping ratio of the structure in each mode \[-\].
    pub of_structure: Vec<f64>,
    /// Damping ratio that radiation adds \[-\].
    pub of_radiation: Vec<f64>,
    /// Amplitudes of the dry modes, dry x wet.
    #[serde(with = "crate::blocks")]
    pub shapes: DMatrix<f64>,
    /// Added mass M of the dry modes, relative to their modal mass \[-\].
    #[serde(with = "crate::blocks")]
    pub mass: DMatrix<f64>,
}

impl WetModes {
    /// Creates the modes from two functions of the dry modes. One returns a column of X/omega, given its index and the
    /// angular frequency. The other returns the quadratic form of R, given the angular frequency and amplitudes.
    /// Frequencies \[rad/s\] are at least `lowest`, the value for rigid modes.
    ///
    /// # Errors
    /// If a column has the wrong length; [`FluidLoadingError::Mass`].
    pub fn new(
        modes: &DryModes,
        lowest: f64,
        mass_column: impl Fn(usize, f64) -> DVector<f64>,
        resistance_form: impl Fn(f64, &DVector<f64>) -> f64,
    ) -> Result<Self, FluidLoadingError> {
        let n = modes.count();
        let mut at: Vec<f64> = modes.omega().to_vec();
        let mut mass = DMatrix::zeros(n, n);
        let (mut omega, mut shapes) = (at.clone(), DMatrix::identity(n, n));
        for _ in 0..PASSES {
            mass.fill(0.0);
            for (i, &w) in at.iter().enumerate() {
                let column = mass_column(i, w.max(lowest));
                same_length("a column of the added mass", column.len(), n)?;
                for j in 0..n {
                    mass[(i, j)] += 0.5 * column[j];
                    mass[(j, i)] += 0.5 * column[j];
                }
            }
            let highest = at.iter().fold(0.0, |a: f64, &b| a.max(b));
            (omega, shapes) = modes.with_mass(&mass, hz(highest))?;
            for (i, w) in at.iter_mut().enumerate() {
                let amplitude = |k: &usize| shapes[(i, *k)].abs();
                let own = (0..n).max_by(|a, b| amplitude(a).total_cmp(&amplitude(b)));
                *w = own.map_or(*w, |own| omega[own]);
            }
        }
        let mut wet = Self {
            of_structure: vec![0.0; n],
            of_radiation: vec![0.0; n],
            omega,
            shapes,
            mass,
        };
        for k in 0..n {
            let (w, shape) = (wet.omega[k], wet.shapes.column(k).into_owned());
            if w > 0.0 {
                let of_structure: f64 = (0..n).map(|i| modes.damping(i) * shape[i] * shape[i]).sum();
                let of_radiation = resistance_form(w.max(lowest), &shape);
                wet.of_structure[k] = of_structure / (2.0 * w);
                wet.of_radiation[k] = of_radiation.max(0.0) / (2.0 * w);
            }
        }
        Ok(wet)
    }
}
