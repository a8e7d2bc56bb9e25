use nalgebra::{Complex, DMatrix};

/// Radiation impedance Z = R + jX of modes with unit modal mass, as an operator at many frequencies at once.
pub trait Impedance: Sync {
    /// Number of modes.
    fn modes(&self) -> usize;

    /// Highest frequency at which R and X are known \[Hz\].
    fn top_hz(&self) -> f64;

    /// Z(f) v for the modal velocities v in each column (modes x frequencies), at positive frequencies \[Hz\].
    fn product(&self, hz: &[f64], velocities: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>>;
}
