//! Roots of radiation resistances, which turn modal velocities into signals whose squared sum is the power.

use super::energy::ModalSpectra;
use super::resistance::{ModalRadiation, Resistance};
use crate::error::{AcousticsError, same_length};
use crate::levels::{PowerSignals, SourceSpectrum};
use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::linalg::matmul::matmul;
use faer::traits::ComplexField;
use faer::traits::math_utils::{mul_real, real};
use faer::{Accum, Mat, Par, unzip, zip};
use nalgebra::{Complex, DMatrix};

/// The Hermitian root of a resistance, S = S^H >= 0 with S^2 = R; its imaginary part is antisymmetric.
///
/// Unlike sorted eigenvectors it is a smooth function of R, so that it may be interpolated over frequency. Negative
/// eigenvalues, left by round-off or interpolation, count as zero.
pub(super) fn hermitian_root(resistance: &Resistance) -> Resistance {
    let shape = resistance.real.shape();
    match &resistance.imaginary {
        None => {
            let root = root_of(Mat::from_fn(shape.0, shape.1, |i, j| resistance.real[(i, j)]));
            Resistance {
                real: DMatrix::from_fn(shape.0, shape.1, |i, j| root[(i, j)]),
                imaginary: None,
            }
        }
        Some(imaginary) => {
            let whole = |i, j| Complex::new(resistance.real[(i, j)], imaginary[(i, j)]);
            let root = root_of(Mat::from_fn(shape.0, shape.1, whole));
            Resistance {
                real: DMatrix::from_fn(shape.0, shape.1, |i, j| root[(i, j)].re),
                imaginary: Some(DMatrix::from_fn(shape.0, shape.1, |i, j| root[(i, j)].im)),
            }
        }
    }
}

/// U max(D, 0)^{1/2} U^H for U D U^H; not a number where the eigenvalues of a damaged matrix do not converge.
fn root_of<T: ComplexField<Real = f64>>(whole: Mat<T>) -> Mat<T> {
    let n = whole.nrows();
    let mut values = Diag::<T>::zeros(n);
    let mut vectors = Mat::<T>::zeros(n, n);
    let request = self_adjoint_evd_scratch::<T>(n, ComputeEigenvectors::Yes, Par::Seq, Default::default());
    let found = self_adjoint_evd(
        whole.as_ref(),
        values.as_mut(),
        Some(vectors.as_mut()),
        Par::Seq,
        MemStack::new(&mut MemBuffer::new(request)),
        Default::default(),
    );
    let mut scaled = vectors.clone();
    for (column, value) in scaled.col_iter_mut().zip(values.column_vector().iter()) {
        let root = if found.is_ok() {
            real(value).max(0.0).sqrt()
        } else {
            f64::NAN
        };
        zip!(column).for_each(|unzip!(x)| *x = mul_real(x, &root));
    }
    let mut root = Mat::zeros(n, n);
    matmul(
        root.as_mut(),
        Accum::Replace,
        scaled.as_ref(),
        vectors.as_ref().adjoint(),
        T::one_impl(),
        Par::Seq,
    );
    root
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
