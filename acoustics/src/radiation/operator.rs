use super::hermitian_root::hermitian_root;
use super::resistance::Resistance;
use nalgebra::{Complex, DMatrix};
use std::f64::consts::TAU;

/// A radiation operator reduced to modal coordinates.
pub trait ModalRadiation: Sync {
    /// Label of the operator, shown with every result.
    fn method(&self) -> &str;

    /// Number of modes.
    fn modes(&self) -> usize;

    /// Names of the surface patches; their resistances add up to that of the complete surface.
    fn patches(&self) -> &[String];

    /// Highest frequency for which the operator was computed \[Hz\].
    fn highest_hz(&self) -> f64;

    /// Resistance R(f) of the complete surface at the frequency `hz`.
    fn resistance(&self, hz: f64) -> Resistance;

    /// v^T R(f) v of the complete surface for each frequency \[Hz\] and sparse real motion v, given by its nonzero
    /// entries; each mode may occur only once.
    fn sparse_forms(&self, motions: &[(f64, Vec<(usize, f64)>)]) -> Vec<f64> {
        let form = |(hz, v): &(f64, Vec<(usize, f64)>)| self.resistance(*hz).sparse_form(v);
        motions.iter().map(form).collect()
    }

    /// a^H (R_p / omega²) a for every patch p (rows) and frequency (columns), with the modal accelerations a in the
    /// columns of `accelerations` (modes x frequencies).
    fn energy_forms(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<f64>;

    /// (R / omega²) a for the complete surface at every frequency (columns), modes x frequencies.
    fn images(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let mut images = DMatrix::zeros(accelerations.nrows(), frequency.len());
        for (bin, &hz) in frequency.iter().enumerate() {
            let r = self.resistance(hz).scaled((TAU * hz).powi(-2));
            let a = accelerations.columns(bin, 1).into_owned();
            images.set_column(bin, &r.product(&a).column(0));
        }
        images
    }

    /// Number of signals returned by [`Self::root_signals`].
    fn signals(&self) -> usize {
        self.modes()
    }

    /// Signals x (rows) at every frequency (columns) with |x|² = a^H (R / omega²) a for the complete surface. They are
    /// x = S^H a, where S is the Hermitian root of R / omega². S is smooth over frequency; where it is interpolated,
    /// the energies are accurate to the interpolation error.
    fn root_signals(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let mut signals = DMatrix::zeros(accelerations.nrows(), frequency.len());
        for (bin, &hz) in frequency.iter().enumerate() {
            let root = hermitian_root(&self.resistance(hz)).scaled(1.0 / (TAU * hz));
            let a = accelerations.columns(bin, 1).into_owned();
            signals.set_column(bin, &root.product(&a).column(0));
        }
        signals
    }
}
