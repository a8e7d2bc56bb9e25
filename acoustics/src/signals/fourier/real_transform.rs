//! Fourier transforms of real records of a fixed length. The plan allocates all buffers, so the transforms cannot fail.

use std::sync::Arc;

use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::num_complex::Complex;

/// Forward and inverse transforms of real records.
#[derive(Clone)]
pub struct RealTransform {
    length: usize,
    forward: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
}

impl RealTransform {
    /// Plans transforms for records of up to `length` samples.
    pub fn new(length: usize) -> Self {
        let mut planner = RealFftPlanner::new();
        Self {
            length,
            forward: planner.plan_fft_forward(length),
            inverse: planner.plan_fft_inverse(length),
        }
    }

    /// Number of samples.
    pub fn length(&self) -> usize {
        self.length
    }

    /// Lines X_k = sum_n x_n e^(-j 2 pi k n/N), k = 0 .. N/2, of a record that is padded with zeros.
    pub fn lines(&self, record: &[f64]) -> Vec<Complex<f64>> {
        let mut padded = record.to_vec();
        padded.resize(self.length, 0.0);
        let mut lines = self.forward.make_output_vec();
        let done = self.forward.process(&mut padded, &mut lines);
        debug_assert!(done.is_ok(), "buffers of the plan's own lengths");
        lines
    }

    /// Inverse transform of the lines. The lines at 0 Hz and at half the sampling rate are real; their imaginary parts
    /// are ignored.
    pub fn signal(&self, mut lines: Vec<Complex<f64>>) -> Vec<f64> {
        lines[0].im = 0.0;
        if self.length.is_multiple_of(2) {
            lines[self.length / 2].im = 0.0;
        }
        let mut record = self.inverse.make_output_vec();
        let done = self.inverse.process(&mut lines, &mut record);
        debug_assert!(done.is_ok(), "buffers of the plan's own lengths");
        record.iter_mut().for_each(|x| *x /= self.length as f64);
        record
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_returns_from_its_lines() {
        for length in [8, 9] {
            let record: Vec<f64> = (0..length).map(|n| (1.3 * n as f64).sin()).collect();
            let transform = RealTransform::new(length);
            let back = transform.signal(transform.lines(&record));
            assert!(record.iter().zip(&back).all(|(a, b)| (a - b).abs() < 1e-15), "{back:?}");
        }
    }
}
