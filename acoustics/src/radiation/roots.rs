//! Roots of radiation resistances, which turn modal velocities into signals whose squared sum is the power.

use super::energy::ModalSpectra;
use super::resistance::{ModalRadiation, Resistance};
use crate::error::{AcousticsError, same_length};
use crate::levels::{PowerSignals, SourceSpectrum};
use nalgebra::{Complex, DMatrix, SymmetricEigen};

/// The Hermitian root of a resistance, S = S^H >= 0 with S^2 = R; its imaginary part is antisymmetric.
///
/// Unlike sorted eigenvectors it is a smooth function of R, so that it may be interpolated over frequency. Negative
/// eigenvalues, left by round-off or interpolation, count as zero.
pub(super) fn hermitian_root(resistance: &Resistance) -> Resistance {
    match &resistance.imaginary {
        None => {
            let eigen = SymmetricEigen::new(resistance.real.clone());
            let mut scaled = eigen.eigenvectors.clone();
            for (mut column, value) in scaled.column_iter_mut().zip(&eigen.eigenvalues) {
                column *= value.max(0.0).sqrt();
            }
            Resistance {
                real: scaled * eigen.eigenvectors.transpose(),
                imaginary: None,
            }
        }
        Some(imaginary) => {
            let whole = resistance.real.zip_map(imaginary, Complex::new);
            let eigen = SymmetricEigen::new(whole);
            let (u_re, u_im) = (eigen.eigenvectors.map(|u| u.re), eigen.eigenvectors.map(|u| u.im));
            let scale = |u: &DMatrix<f64>| {
                let mut scaled = u.clone();
                for (mut column, value) in scaled.column_iter_mut().zip(&eigen.eigenvalues) {
                    column *= value.max(0.0).sqrt();
                }
                scaled
            };
            let (s_re, s_im) = (scale(&u_re), scale(&u_im));
            let (t_re, t_im) = (u_re.transpose(), u_im.transpose());
            Resistance {
                real: &s_re * &t_re + &s_im * &t_im,
                imaginary: Some(s_im * t_re - s_re * t_im),
            }
        }
    }
}

/// The signals of a surface that moves in modes, for its energy over time.
///
/// ```text
/// x = L^H V = L^H A / (j omega)       R = L L^H
/// ```
///
/// `spectrum` is that of [`super::radiated_energy`] with the same operator and motion.
///
/// # Errors
/// A number of modes that differs from the operator's, a spectrum on other frequencies.
pub fn radiated_signals(
    radiation: &dyn ModalRadiation,
    spectra: &ModalSpectra,
    spectrum: &SourceSpectrum,
) -> Result<PowerSignals, AcousticsError> {
    same_length("modal spectra", spectra.accelerations.nrows(), radiation.modes())?;
    let mut signals = radiation.root_signals(&spectra.frequency, &spectra.accelerations);
    // The phase of 1/(j omega); its magnitude is in the root of R / omega².
    signals *= -Complex::<f64>::i();
    PowerSignals::new(spectrum, signals)
}

/// S^H a at every frequency, with the root of the resistance over omega taken anew at each.
pub(super) fn one_by_one(
    radiation: &(impl ModalRadiation + ?Sized),
    frequency: &[f64],
    accelerations: &DMatrix<Complex<f64>>,
) -> DMatrix<Complex<f64>> {
    let mut signals = DMatrix::zeros(accelerations.nrows(), frequency.len());
    for (bin, &hz) in frequency.iter().enumerate() {
        let root = hermitian_root(&radiation.resistance(hz));
        let omega = std::f64::consts::TAU * hz;
        let whole = match &root.imaginary {
            None => root.real.map(|s| Complex::from(s / omega)),
            Some(imaginary) => root.real.zip_map(imaginary, |re, im| Complex::new(re, im) / omega),
        };
        signals.set_column(bin, &whole.ad_mul(&accelerations.column(bin)));
    }
    signals
}

/// S a for a Hermitian S and all columns of `motion`.
pub(super) fn image(matrix: &Resistance, motion: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
    let mut image = apply(&matrix.real, motion);
    if let Some(imaginary) = &matrix.imaginary {
        image += apply(imaginary, motion) * Complex::<f64>::i();
    }
    image
}

/// S a for one real matrix and all columns.
pub(super) fn apply(root: &DMatrix<f64>, motion: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
    let (re, im) = (root * motion.map(|a| a.re), root * motion.map(|a| a.im));
    re.zip_map(&im, Complex::new)
}
