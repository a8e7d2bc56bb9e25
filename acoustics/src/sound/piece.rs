//! What is linear in the modes' accelerations, sampled at a few frequencies of a range and carried to any between them.

use crate::error::AcousticsError;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Samples beyond two a wave. The Chebyshev coefficients of e^{j tau x} are Bessel functions J_n(tau), which fall off over
/// some tau^{1/3} orders beyond n = tau: three of these widths and a few samples leave less than 1e-3.
const WIDTHS: f64 = 3.0;
const BESIDE: f64 = 9.0;

/// Rows of a quantity per unit of modal acceleration, modes in the columns.
pub(crate) type Rows = Mat<Complex<f64>>;

/// A range of frequencies with samples of several quantities at its Chebyshev points of the first kind.
pub(crate) struct Piece {
    hz: Vec<f64>,
    weights: Vec<f64>,
    /// Sample by sample.
    quantities: Vec<Vec<Rows>>,
}

impl Piece {
    /// Samples `at` often enough for waves that travel `path` \[m\] farther or less than those whose travel is taken out.
    ///
    /// # Errors
    /// Those of `at`.
    pub(crate) fn new(
        range_hz: [f64; 2],
        (path, sound_speed): (f64, f64),
        at: impl Fn(f64) -> Result<Vec<Rows>, AcousticsError> + Sync,
    ) -> Result<Self, AcousticsError> {
        let [low, high] = range_hz;
        // e^{jkr} over a range has as many half waves as a Chebyshev polynomial of order tau = (k_2 - k_1) r / 2.
        let tau = PI * (high - low) * path / sound_speed;
        let count = (tau + WIDTHS * tau.cbrt() + BESIDE).ceil() as usize;
        let angle = |i: usize| PI * (i as f64 + 0.5) / count as f64;
        let hz: Vec<f64> = (0..count)
            .map(|i| 0.5 * (low + high) - 0.5 * (high - low) * angle(i).cos())
            .collect();
        let alternate = |i: usize| if i.is_multiple_of(2) { 1.0 } else { -1.0 };
        let weights = (0..count).map(|i| alternate(i) * angle(i).sin()).collect();
        // One frequency at a time on a thread: they take equally long.
        let quantities = hz
            .par_iter()
            .with_max_len(1)
            .map(|&hz| at(hz))
            .collect::<Result<_, _>>()?;
        Ok(Self {
            hz,
            weights,
            quantities,
        })
    }

    /// Frequencies sampled.
    pub(crate) fn samples(&self) -> usize {
        self.hz.len()
    }

    /// Weights of the samples at a frequency; they sum to one.
    fn weights(&self, hz: f64) -> Vec<f64> {
        if let Some(hit) = self.hz.iter().position(|&node| node == hz) {
            return (0..self.hz.len()).map(|i| f64::from(u8::from(i == hit))).collect();
        }
        let terms: Vec<f64> = self.hz.iter().zip(&self.weights).map(|(x, w)| w / (hz - x)).collect();
        let sum: f64 = terms.iter().sum();
        terms.into_iter().map(|t| t / sum).collect()
    }

    /// A quantity for modal accelerations (modes x bins) at the frequency of each bin, rows x bins.
    pub(crate) fn carried(&self, quantity: usize, frequency: &[f64], accelerations: &Rows) -> Rows {
        let weights: Vec<Vec<f64>> = frequency.iter().map(|&hz| self.weights(hz)).collect();
        let mut sum = Mat::zeros(self.quantities[0][quantity].nrows(), frequency.len());
        for (node, sample) in self.quantities.iter().enumerate() {
            let weighted = Mat::from_fn(accelerations.nrows(), frequency.len(), |mode, bin| {
                accelerations[(mode, bin)] * weights[bin][node]
            });
            let one = Complex::from(1.0);
            matmul(
                sum.as_mut(),
                Accum::Add,
                sample[quantity].as_ref(),
                weighted.as_ref(),
                one,
                Par::Seq,
            );
        }
        sum
    }

    /// Estimated interpolation error of a quantity: the largest of its last two Chebyshev coefficients over its largest
    /// entry.
    pub(crate) fn error(&self, quantity: usize) -> f64 {
        let count = self.hz.len();
        let (rows, modes) = self.quantities[0][quantity].shape();
        let size = |m: &Rows| {
            m.row_iter()
                .flat_map(|r| r.iter())
                .map(|z| z.norm())
                .fold(0.0, f64::max)
        };
        let largest = self.quantities.iter().map(|q| size(&q[quantity])).fold(0.0, f64::max);
        if largest == 0.0 {
            return 0.0;
        }
        let last = |order: usize| {
            let mut sum: Rows = Mat::zeros(rows, modes);
            for (i, sample) in self.quantities.iter().enumerate() {
                let cosine = (PI * order as f64 * (i as f64 + 0.5) / count as f64).cos();
                let factor = faer::Scale(Complex::from(2.0 / count as f64 * cosine));
                sum += factor * &sample[quantity];
            }
            size(&sum) / largest
        };
        last(count - 1).max(last(count - 2))
    }
}

/// The same values in the other library's matrix.
pub(crate) fn rows(m: &DMatrix<Complex<f64>>) -> Rows {
    Mat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waves_are_carried_to_every_frequency() {
        let (path, c) = (3.0, 343.0);
        let wave = |hz: f64, r: f64| Complex::from_polar(1.0, -2.0 * PI * hz * r / c);
        let at = |hz: f64| Ok(vec![Mat::from_fn(4, 1, |i, _| wave(hz, path * (i as f64 / 1.5 - 1.0)))]);
        for range in [[40.0, 160.0], [500.0, 2500.0]] {
            let piece = Piece::new(range, (path, c), at).unwrap();
            let frequency: Vec<f64> = (0..57)
                .map(|i| range[0] + (range[1] - range[0]) * i as f64 / 56.0)
                .collect();
            let found = piece.carried(0, &frequency, &Mat::full(1, frequency.len(), Complex::from(1.0)));
            let mut worst: f64 = 0.0;
            for (bin, &hz) in frequency.iter().enumerate() {
                for i in 0..4 {
                    worst = worst.max((found[(i, bin)] - wave(hz, path * (i as f64 / 1.5 - 1.0))).norm());
                }
            }
            assert!(worst < 1e-3, "{range:?}: {worst:e}");
            assert!(
                piece.error(0) < 1e-3 && piece.error(0) > 1e-2 * worst,
                "{:e}",
                piece.error(0)
            );
        }
    }
}
