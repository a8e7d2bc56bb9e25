//! Fourier transforms of records times e^{-sigma t}, that is, transforms at the complex frequencies s = sigma + j
//! omega.

use crate::checks::{InputError, positive};
use crate::signals::fourier::{RealTransform, fast_length};
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Fraction of a motion that remains after one period of the transform \[-\].
const WRAP_AROUND: f64 = 1e-5;

/// Transforms of records of one length, and the inverse, for frequencies from zero upwards.
///
/// The period is at least twice the record. Within the record, the response of a causal system is therefore its
/// response to the complete history, because the part that wraps around the period is attenuated by e^{-sigma L}. Rigid
/// motion and offsets are included, because nothing is singular at s = sigma + j omega.
#[derive(Clone)]
pub struct DampedTransform {
    fft: RealTransform,
    samples: usize,
    step: f64,
    sigma: f64,
    bins: usize,
}

impl DampedTransform {
    /// Creates the transform for records of `samples` samples with the step `step` \[s\], and the lines below `top_hz`.
    ///
    /// # Errors
    /// [`InputError`] if a value is not positive.
    pub fn new(samples: usize, step: f64, top_hz: f64) -> Result<Self, InputError> {
        positive("sampling interval [s]", step)?;
        positive("highest frequency [Hz]", top_hz)?;
        let length = fast_length(2 * samples.max(1));
        let period = length as f64 * step;
        let lines = length / 2 + 1;
        Ok(Self {
            fft: RealTransform::new(length),
            samples,
            step,
            sigma: -WRAP_AROUND.ln() / period,
            bins: ((top_hz * period).ceil() as usize).clamp(1, lines),
        })
    }

    /// Number of lines.
    pub fn bins(&self) -> usize {
        self.bins
    }

    /// Length of the period \[samples\].
    pub fn length(&self) -> usize {
        self.fft.length()
    }

    /// sigma \[1/s\].
    pub fn sigma(&self) -> f64 {
        self.sigma
    }

    /// Frequency of a line \[Hz\].
    pub fn hz(&self, bin: usize) -> f64 {
        bin as f64 / (self.length() as f64 * self.step)
    }

    /// s = sigma + j omega of a line \[1/s\].
    pub fn s(&self, bin: usize) -> Complex<f64> {
        Complex::new(self.sigma, TAU * self.hz(bin))
    }

    /// Lines sum_n (x_n - x_0) e^{-s t_n} of the records in the columns of `motion` (samples x records), records x
    /// lines. They represent changes from a record's first value. The record is assumed to have had that value before
    /// its start.
    ///
    /// After its end, a record is continued as 2 x_N - x_{2N-n}, without a jump in value or slope, and fades to its
    /// first value by the end of the period. For a causal system, this has no effect before the end of the record.
    pub(crate) fn lines(&self, motion: &DMatrix<f64>) -> DMatrix<Complex<f64>> {
        let columns: Vec<Vec<Complex<f64>>> = motion
            .as_slice()
            .par_chunks(motion.nrows().max(1))
            .map(|record| {
                let mut lines = self.fft.lines(&self.prolonged(record));
                lines.truncate(self.bins);
                lines
            })
            .collect();
        DMatrix::from_fn(motion.ncols(), self.bins, |record, bin| columns[record][bin])
    }

    /// The record of some lines, x_n = e^{sigma t_n}/N sum_k X_k e^{j omega_k t_n}, summed over both signs of the
    /// frequency.
    pub fn record(&self, lines: &[Complex<f64>]) -> Vec<f64> {
        let mut all = lines.to_vec();
        all.resize(self.length() / 2 + 1, Complex::default());
        let mut record = self.fft.signal(all);
        record.truncate(self.samples);
        for (n, x) in record.iter_mut().enumerate() {
            *x *= (self.sigma * self.step * n as f64).exp();
        }
        record
    }

    fn prolonged(&self, record: &[f64]) -> Vec<f64> {
        let (length, count) = (self.length(), record.len());
        let first = record.first().copied().unwrap_or(0.0);
        let at = |n: usize| {
            if n < count {
                return record[n] - first;
            }
            let last = count - 1;
            let mirrored = (2 * last).saturating_sub(n).min(last);
            let goes_on = 2.0 * record[last] - record[mirrored] - first;
            let share = (n - last) as f64 / (length - last) as f64;
            0.5 * (1.0 + (PI * share).cos()) * goes_on
        };
        (0..length)
            .map(|n| at(n) * (-self.sigma * self.step * n as f64).exp())
            .collect()
    }
}
