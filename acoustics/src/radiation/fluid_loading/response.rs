use super::error::FluidLoadingError;
use super::modes::{DryModes, hz};
use crate::checks::same_length;
use nalgebra::{Complex, DMatrix};

/// Modal velocities at the angular frequency `omega` \[rad/s\] for modal forces (modes x cases). With the radiation
/// impedance Z(omega) of the modes \[1/s\]:
///
/// ```text
/// q' = j omega [-omega² I + j omega (C + Z) + Omega²]^-1 f
/// ```
///
/// # Errors
/// If lengths are inconsistent; [`FluidLoadingError::Singular`].
pub fn velocities(
    modes: &DryModes,
    omega: f64,
    impedance: &DMatrix<Complex<f64>>,
    forces: &DMatrix<Complex<f64>>,
) -> Result<DMatrix<Complex<f64>>, FluidLoadingError> {
    same_length("rows of the modal forces", forces.nrows(), modes.count())?;
    let stiffness = modes.dynamic_stiffness(Complex::from(omega), impedance)?;
    let singular = FluidLoadingError::Singular { hz: hz(omega) };
    let displacements = stiffness.lu().solve(forces).ok_or(singular)?;
    Ok(displacements * Complex::new(0.0, omega))
}

/// Mean powers of a harmonic motion \[W\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PowerBalance {
    /// Supplied by the forces, 1/2 Re f^H q'.
    pub input: f64,
    /// Dissipated by the structure, 1/2 q'^H C q'.
    pub dissipated: f64,
    /// Radiated, 1/2 q'^H R q'.
    pub radiated: f64,
}

impl PowerBalance {
    /// Powers for velocities under forces, one case each. The radiation resistance R at this frequency may come from a
    /// different evaluation than the impedance used in [`velocities`].
    ///
    /// # Errors
    /// If lengths are inconsistent.
    pub fn new(
        modes: &DryModes,
        resistance: &DMatrix<f64>,
        forces: &[Complex<f64>],
        velocities: &[Complex<f64>],
    ) -> Result<Self, FluidLoadingError> {
        let n = modes.count();
        same_length("modal forces", forces.len(), n)?;
        same_length("modal velocities", velocities.len(), n)?;
        same_length("rows of the resistance", resistance.nrows(), n)?;
        let pairs = forces.iter().zip(velocities);
        let mut radiated = 0.0;
        for j in 0..n {
            for i in 0..n {
                radiated += 0.5 * resistance[(i, j)] * (velocities[i].conj() * velocities[j]).re;
            }
        }
        Ok(Self {
            input: 0.5 * pairs.map(|(f, v)| (f.conj() * v).re).sum::<f64>(),
            dissipated: (0..n).map(|i| 0.5 * modes.damping(i) * velocities[i].norm_sqr()).sum(),
            radiated,
        })
    }

    /// Imbalance, relative to the input \[-\].
    pub fn error(&self) -> f64 {
        (self.input - self.dissipated - self.radiated) / self.input
    }
}
