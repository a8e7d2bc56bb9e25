//! Converts signals to another sampling rate.

use nailnoise_acoustics::signals::ChirpTransform;
use nailnoise_acoustics::signals::fourier::RealTransform;
use nalgebra::Complex;

/// A plan that converts band-limited records of one length from one rate to another, starting at their first sample.
///
/// The spectrum up to half the lower rate is summed at the new instants. The record is padded to twice its length, so
/// that its end does not reach its beginning.
pub(super) struct Resampling {
    from: f64,
    kept: usize,
    forward: RealTransform,
    back: ChirpTransform,
}

impl Resampling {
    /// For records of `count` samples at `from` \[1/s\], converted to `samples` samples at `to` \[1/s\].
    pub(super) fn new((count, from): (usize, f64), (samples, to): (usize, f64)) -> Self {
        let length = (2 * count.max(4)).next_power_of_two();
        let df = from / length as f64;
        let kept = ((0.5 * from.min(to) / df).ceil() as usize).min(length / 2);
        let frequency: Vec<f64> = (0..kept).map(|k| k as f64 * df).collect();
        Self {
            from,
            kept,
            forward: RealTransform::new(length),
            back: ChirpTransform::new(&frequency, to, samples),
        }
    }

    /// The record at the new rate.
    pub(super) fn apply(&self, record: &[f64]) -> Vec<f64> {
        let mut lines = self.forward.lines(record);
        lines.truncate(self.kept);
        lines.iter_mut().for_each(|x| *x /= self.from);
        // The sum counts each line twice, to include its negative frequency; the line at 0 Hz has none.
        if let Some(mean) = lines.first_mut() {
            *mean *= Complex::from(0.5);
        }
        self.back.signal(&lines)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn burst(t: f64) -> f64 {
        (-((t - 0.05) / 4e-3).powi(2)).exp() * (2.0 * PI * 3000.0 * t).cos()
    }

    #[test]
    fn a_band_limited_signal_is_the_same_at_another_rate() {
        let record: Vec<f64> = (0..4800).map(|n| burst(f64::from(n) / 48e3)).collect();
        for to in [160e3, 51.2e3, 44.1e3] {
            let samples = (0.1 * to) as usize;
            let found = Resampling::new((record.len(), 48e3), (samples, to)).apply(&record);
            let error = |(n, x): (usize, &f64)| (x - burst(n as f64 / to)).abs();
            assert!(found.iter().enumerate().map(error).fold(0.0, f64::max) < 1e-6, "{to}");
        }
    }
}
