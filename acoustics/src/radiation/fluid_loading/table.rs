use crate::checks::{InputError, positive};
use nalgebra::{Complex, DMatrix};
use std::f64::consts::{PI, TAU};

/// A radiation impedance interpolated over frequency, which is valid also near the real axis.
///
/// Z/(j omega) = X/omega - j R/omega is smooth and finite down to zero frequency. The polynomial through its values at
/// Chebyshev points of the range is analytic, so it is also valid at the complex frequencies of damped vibration.
#[derive(Debug, Clone)]
pub struct ImpedanceTable {
    /// Angular frequencies of the samples \[rad/s\], and the weights of the barycentric formula.
    nodes: Vec<(f64, f64)>,
    /// Z/(j omega) at each.
    samples: Vec<DMatrix<Complex<f64>>>,
}

impl ImpedanceTable {
    /// Samples `impedance`, a function of frequency in hertz, at `count` frequencies in a range \[Hz\].
    ///
    /// # Errors
    /// [`InputError`] if the range is not positive; errors of `impedance`.
    pub fn new<E: From<InputError>>(
        [low, high]: [f64; 2],
        count: usize,
        mut impedance: impl FnMut(f64) -> Result<DMatrix<Complex<f64>>, E>,
    ) -> Result<Self, E> {
        positive("lowest frequency of the impedance [Hz]", low)?;
        positive("width of the impedance's range [Hz]", high - low)?;
        let (mut nodes, mut samples) = (Vec::new(), Vec::new());
        for n in 0..count.max(2) {
            // Chebyshev points of the first kind (Berrut & Trefethen 2004, equation 5.3).
            let angle = PI * (n as f64 + 0.5) / count.max(2) as f64;
            let hz = 0.5 * (low + high) + 0.5 * (high - low) * angle.cos();
            let omega = TAU * hz;
            let sign = if n % 2 == 0 { 1.0 } else { -1.0 };
            nodes.push((omega, sign * angle.sin()));
            samples.push(impedance(hz)? / Complex::new(0.0, omega));
        }
        Ok(Self { nodes, samples })
    }

    /// Z at a complex angular frequency \[rad/s\].
    pub fn at(&self, omega: Complex<f64>) -> DMatrix<Complex<f64>> {
        let mut sum = DMatrix::zeros(self.samples[0].nrows(), self.samples[0].ncols());
        let mut weights = Complex::from(0.0);
        for ((node, weight), sample) in self.nodes.iter().zip(&self.samples) {
            let from = omega - node;
            if from.norm() <= 1e-12 * node {
                return sample * (Complex::<f64>::i() * omega);
            }
            let weight = Complex::from(*weight) / from;
            sum += sample * weight;
            weights += weight;
        }
        sum * (Complex::<f64>::i() * omega / weights)
    }
}
