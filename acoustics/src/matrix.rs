//! Products of real and complex matrices.

use nalgebra::{Complex, DMatrix};

/// A real matrix times a complex one.
pub(crate) fn real_product(a: &DMatrix<f64>, z: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
    let [re, im] = [z.map(|z| z.re), z.map(|z| z.im)].map(|part| a * part);
    re.zip_map(&im, Complex::new)
}
