//! Causal filters with a given magnitude.

use nailnoise_acoustics::signals::fourier::RealTransform;
use nalgebra::Complex;

/// A filter given at the lines of a transform of fixed length.
pub(super) struct MinimumPhase {
    transform: RealTransform,
    response: Vec<Complex<f64>>,
}

/// Minimum magnitude, so that its logarithm exists: -200 dB.
const LEAST: f64 = 1e-10;

impl MinimumPhase {
    /// The minimum-phase filter with the magnitude `magnitude(hz)`, for records of `samples` at `rate` \[1/s\]. The
    /// transform is padded to twice the record.
    ///
    /// The phase is the Hilbert transform of the logarithm of the magnitude, computed from its cepstrum by doubling the
    /// causal half (Oppenheim and Schafer, Discrete-Time Signal Processing, 3rd ed., 12.5).
    pub(super) fn new(samples: usize, rate: f64, magnitude: impl Fn(f64) -> f64) -> Self {
        let length = (2 * samples).next_power_of_two();
        let df = rate / length as f64;
        let transform = RealTransform::new(length);
        let log = |k: usize| Complex::from(magnitude(k as f64 * df).max(LEAST).ln());
        let mut cepstrum = transform.signal((0..=length / 2).map(log).collect());
        // The length is even, so lag 0 and the middle are their own mirror images.
        cepstrum[1..length / 2].iter_mut().for_each(|value| *value *= 2.0);
        cepstrum[length / 2 + 1..].fill(0.0);
        let response = transform.lines(&cepstrum).into_iter().map(Complex::exp).collect();
        Self { transform, response }
    }

    /// The filtered record.
    pub(super) fn apply(&self, record: &[f64]) -> Vec<f64> {
        let mut lines = self.transform.lines(record);
        lines.iter_mut().zip(&self.response).for_each(|(x, h)| *x *= h);
        let mut filtered = self.transform.signal(lines);
        filtered.truncate(record.len());
        filtered
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE: f64 = 48_000.0;

    fn impulse() -> Vec<f64> {
        let mut record = vec![0.0; 4096];
        record[100] = 1.0;
        record
    }

    #[test]
    fn a_constant_magnitude_has_no_phase() {
        let halved = MinimumPhase::new(4096, RATE, |_| 0.5).apply(&impulse());
        assert!(halved.iter().zip(&impulse()).all(|(a, b)| (a - 0.5 * b).abs() < 1e-12));
    }

    /// A first-order low-pass has minimum phase: its impulse response is w e^(-w t).
    #[test]
    fn a_low_pass_of_first_order_is_causal_and_decays() {
        let filter = MinimumPhase::new(4096, RATE, |hz| 1.0 / (1.0 + (hz / 500.0).powi(2)).sqrt());
        let response = filter.apply(&impulse());
        let before: f64 = response[..100].iter().map(|x| x * x).sum();
        let all: f64 = response.iter().map(|x| x * x).sum();
        assert!(before / all < 1e-4, "{}", before / all);
        let decay = (response[110] / response[130]).ln() / 20.0 * RATE;
        assert!(
            (decay / (2.0 * std::f64::consts::PI * 500.0) - 1.0).abs() < 0.02,
            "{decay}"
        );
    }
}
