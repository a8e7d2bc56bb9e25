use nalgebra::Complex;
use rustfft::{Fft, FftPlanner};
use std::f64::consts::PI;
use std::sync::Arc;

/// The signal of a one-sided spectrum on uniformly spaced bins, at any sampling rate \[1/s\], starting at t = 0.
///
/// ```text
/// x(t_n) = 2 df Re sum_k X(f_k) e^{j 2 pi f_k t_n}
/// ```
///
/// Uses the chirp transform (Rabiner, Schafer and Rader 1969): k n = (k² + n² - (n - k)²) / 2 turns the sum into a
/// convolution. The bin spacing and the number of samples are thus independent. The sum is periodic with 1/df; the
/// result is set to zero after one period.
pub struct ChirpTransform {
    bins: usize,
    samples: usize,
    /// Number of nonzero samples.
    sounding: usize,
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
    /// e^{j pi k² df/rate} for the bins, and the factors applied to the samples after the convolution.
    before: Vec<Complex<f64>>,
    after: Vec<Complex<f64>>,
    /// Transform of e^{-j pi n² df/rate}.
    kernel: Vec<Complex<f64>>,
}

impl std::fmt::Debug for ChirpTransform {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ChirpTransform")
            .field("bins", &self.bins)
            .field("samples", &self.samples)
            .finish_non_exhaustive()
    }
}

impl ChirpTransform {
    /// Plans the transform of spectra at uniformly spaced frequencies \[Hz\] to `samples` samples.
    pub fn new(frequency: &[f64], rate: f64, samples: usize) -> Self {
        let bins = frequency.len();
        let df = match frequency {
            [first, .., last] => (last - first) / (bins - 1) as f64,
            _ => 0.0,
        };
        let sounding = if bins < 2 {
            0
        } else {
            samples.min((rate / df).ceil() as usize)
        };
        let step = df / rate;
        // pi step n² modulo 2 pi; n² is exact in f64.
        let chirp = |n: usize| Complex::from_polar(1.0, PI * ((n * n) as f64 * step).rem_euclid(2.0));
        let chirps: Vec<Complex<f64>> = (0..bins.max(sounding)).map(chirp).collect();
        let length = (bins + sounding).saturating_sub(1).next_power_of_two();
        let mut planner = FftPlanner::new();
        let (forward, inverse) = (planner.plan_fft_forward(length), planner.plan_fft_inverse(length));
        let mut kernel = vec![Complex::default(); length];
        for (n, chirp) in chirps.iter().enumerate() {
            if n < sounding {
                kernel[n] = chirp.conj();
            }
            if (1..bins).contains(&n) {
                kernel[length - n] = chirp.conj();
            }
        }
        forward.process(&mut kernel);
        let scale = 2.0 * df / length as f64;
        let first = frequency.first().map_or(0.0, |hz| hz / rate);
        let turn = |n: usize| Complex::from_polar(scale, 2.0 * PI * (n as f64 * first).rem_euclid(1.0));
        Self {
            bins,
            samples,
            sounding,
            forward,
            inverse,
            after: (0..sounding).map(|n| chirps[n] * turn(n)).collect(),
            before: chirps.into_iter().take(bins).collect(),
            kernel,
        }
    }

    /// The signal of one spectrum; values beyond the last frequency are ignored.
    pub fn signal(&self, spectrum: &[Complex<f64>]) -> Vec<f64> {
        let mut record = vec![0.0; self.samples];
        if self.sounding == 0 {
            return record;
        }
        let mut signal = vec![Complex::default(); self.kernel.len()];
        for (x, (value, chirp)) in signal.iter_mut().zip(spectrum.iter().zip(&self.before)) {
            *x = value * chirp;
        }
        self.forward.process(&mut signal);
        signal.iter_mut().zip(&self.kernel).for_each(|(x, h)| *x *= h);
        self.inverse.process(&mut signal);
        for (sample, (x, after)) in record.iter_mut().zip(signal.iter().zip(&self.after)) {
            *sample = (x * after).re;
        }
        record
    }
}
