//! Fields per unit of the modes' accelerations over a range of frequencies.

use crate::error::AcousticsError;
use crate::signals::interpolation::{Grid, Piece, Plan, WIDEST, each, field_misfit, pieces, sample};
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Largest estimated interpolation error, relative to the largest entry of a field.
const TOLERANCE: f64 = 1e-3;

/// Number of samples added to an interval at a time.
const ROUND: usize = 4;

/// Largest number of samples in a range.
const MOST: usize = 2000;

/// Largest number of half-waves over the frequencies of one interval.
const HALF_WAVES: f64 = 40.0;

/// A field at many places (rows) per unit of the modes' accelerations (columns).
pub(crate) type Field = DMatrix<Complex<f64>>;

/// Several fields, sampled at the same frequencies.
pub(crate) struct Fields {
    grid: Grid,
    /// All fields, by sample.
    samples: Vec<Vec<Field>>,
}

impl Fields {
    /// Samples the fields given by `at`. The travel times that remain in the fields correspond to path lengths between
    /// -`path` and `path` \[m\].
    ///
    /// # Errors
    /// Errors of `at`, and [`SamplingError`](crate::SamplingError).
    pub(crate) fn new(
        [low, high]: [f64; 2],
        (path, sound_speed): (f64, f64),
        at: impl Fn(f64) -> Result<Vec<Field>, AcousticsError> + Sync,
    ) -> Result<Self, AcousticsError> {
        // The number of half-waves of e^{jkr} over a range must not exceed the number that a polynomial of the order
        // tau = (k_2 - k_1) r / 2 can represent.
        let tau = PI * (high - low) * path / sound_speed;
        let count = (tau / HALF_WAVES).ceil();
        let part = |i: usize| low + (high - low) * i as f64 / count;
        let parts: Vec<f64> = (1..count as usize).map(part).collect();
        let plan = Plan {
            tolerance: TOLERANCE,
            round: ROUND,
            most_samples: MOST,
            near_zero: false,
            cautious: false,
        };
        let pieces: Vec<Piece> = pieces([low, high], WIDEST, &parts)?;
        let (grid, samples) = sample(&pieces, &plan, each(at), |interval, samples: &[Vec<Field>]| {
            let of_field = |field: usize| field_misfit(interval, |node| &samples[node][field]);
            (0..samples[0].len())
                .into_par_iter()
                .map(of_field)
                .reduce(|| 0.0, f64::max)
        })?;
        Ok(Self { grid, samples })
    }

    /// Number of frequencies sampled.
    pub(crate) fn samples(&self) -> usize {
        self.samples.len()
    }

    /// Estimated interpolation error, relative to the largest entry of a field.
    pub(crate) fn error(&self) -> f64 {
        self.grid.error
    }

    /// A field for modal accelerations (modes x bins) at the frequency of each bin, rows x bins.
    pub(crate) fn product(&self, field: usize, frequency: &[f64], accelerations: &Field) -> Field {
        let mut product = Field::zeros(self.samples[0][field].nrows(), frequency.len());
        for run in self.grid.runs(frequency) {
            let (first, count) = (run.bins.start, run.bins.len());
            let motion = accelerations.columns(first, count).into_owned();
            // Bins just below the range belong to its first interval.
            let interval = run.interval.or(Some(0));
            let sample = |node: usize| &self.samples[node][field];
            let found = self.grid.product(interval, &frequency[run.bins], sample, &motion);
            product.columns_mut(first, count).copy_from(&found);
        }
        product
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waves_are_interpolated_to_every_frequency() {
        let (path, c) = (3.0, 343.0);
        let wave = |hz: f64, r: f64| Complex::from_polar(1.0, -2.0 * PI * hz * r / c);
        let at = |hz: f64| {
            Ok(vec![Field::from_fn(4, 1, |i, _| {
                wave(hz, path * (i as f64 / 1.5 - 1.0))
            })])
        };
        for range in [[40.0, 160.0], [500.0, 2500.0]] {
            let fields = Fields::new(range, (path, c), at).unwrap();
            let frequency: Vec<f64> = (0..57)
                .map(|i| range[0] + (range[1] - range[0]) * i as f64 / 56.0)
                .collect();
            let found = fields.product(
                0,
                &frequency,
                &Field::from_element(1, frequency.len(), Complex::from(1.0)),
            );
            let mut worst: f64 = 0.0;
            for (bin, &hz) in frequency.iter().enumerate() {
                for i in 0..4 {
                    worst = worst.max((found[(i, bin)] - wave(hz, path * (i as f64 / 1.5 - 1.0))).norm());
                }
            }
            println!(
                "{range:?}: {} samples, {worst:.1e}, estimated {:.1e}",
                fields.samples(),
                fields.error()
            );
            assert!(worst < 1e-3, "{range:?}: {worst:e}");
            assert!(
                fields.error() < 1e-3 && fields.error() > 1e-2 * worst,
                "{:e}",
                fields.error()
            );
        }
    }
}
