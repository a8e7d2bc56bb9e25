//! Samples over frequency, and interpolation of quantities that are linear in modal motions.

use super::interval::{Interval, extrapolated};
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use nalgebra::{Complex, DMatrix};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Number of bins evaluated together.
const CHUNK: usize = 64;

/// The frequencies of samples, and the intervals whose polynomials interpolate them.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Grid {
    /// Frequencies of the samples, in sample order \[Hz\].
    hz: Vec<f64>,
    /// Intervals in ascending order without gaps.
    intervals: Vec<Interval>,
    /// Estimated interpolation error.
    pub(crate) error: f64,
}

/// Consecutive bins in one interval; none below the lowest sample.
#[derive(Debug, Clone)]
pub(crate) struct Run {
    pub(crate) interval: Option<usize>,
    pub(crate) bins: Range<usize>,
}

impl Grid {
    /// Creates a grid from intervals in any order.
    pub(super) fn new(hz: Vec<f64>, mut intervals: Vec<Interval>, error: f64) -> Self {
        intervals.sort_by(|a, b| a.low.total_cmp(&b.low));
        Self { hz, intervals, error }
    }

    /// Frequencies of the samples, in sample order \[Hz\].
    pub(crate) fn hz(&self) -> &[f64] {
        &self.hz
    }

    pub(crate) fn intervals(&self) -> &[Interval] {
        &self.intervals
    }

    pub(crate) fn lowest_hz(&self) -> f64 {
        self.intervals.first().map_or(0.0, |i| i.low)
    }

    pub(crate) fn highest_hz(&self) -> f64 {
        self.intervals.last().map_or(0.0, |i| i.high)
    }

    /// Index of the sample at the lowest frequency.
    pub(crate) fn lowest_sample(&self) -> usize {
        self.intervals[0].nodes[0]
    }

    /// The interval that contains a frequency; `None` below the lowest sample. The last interval also covers all
    /// frequencies above.
    pub(crate) fn interval(&self, hz: f64) -> Option<usize> {
        let last = self.intervals.len() - 1;
        (hz >= self.lowest_hz()).then(|| self.intervals.partition_point(|i| i.high <= hz).min(last))
    }

    /// Samples of an interval; the lowest sample for `None`.
    pub(crate) fn nodes(&self, interval: Option<usize>) -> Vec<usize> {
        interval.map_or_else(|| vec![self.lowest_sample()], |i| self.intervals[i].nodes.clone())
    }

    /// Weights of [`Grid::nodes`] at a frequency \[Hz\].
    pub(crate) fn weights(&self, interval: Option<usize>, hz: f64) -> Vec<f64> {
        interval.map_or_else(|| vec![1.0], |i| self.intervals[i].weights(hz))
    }

    /// Samples with their weights at a frequency \[Hz\].
    pub(crate) fn weighted(&self, hz: f64) -> impl Iterator<Item = (usize, f64)> + use<> {
        let interval = self.interval(hz);
        self.nodes(interval).into_iter().zip(self.weights(interval, hz))
    }

    /// Runs of bins in the same interval, with at most 64 bins.
    pub(crate) fn runs(&self, frequency: &[f64]) -> Vec<Run> {
        let mut runs: Vec<Run> = Vec::new();
        for (bin, interval) in frequency.iter().map(|hz| self.interval(*hz)).enumerate() {
            match runs.last_mut() {
                Some(run) if run.interval == interval && run.bins.len() < CHUNK => run.bins.end = bin + 1,
                _ => runs.push(Run {
                    interval,
                    bins: bin..bin + 1,
                }),
            }
        }
        runs
    }

    /// A quantity given by a matrix for each sample, times the `motion` in the bins of a run, interpolated to each bin:
    ///
    /// ```text
    /// x(f) = sum_n w_n(f) X_n a(f)
    /// ```
    pub(crate) fn product<'a>(
        &self,
        interval: Option<usize>,
        frequency: &[f64],
        sample: impl Fn(usize) -> &'a DMatrix<Complex<f64>>,
        motion: &DMatrix<Complex<f64>>,
    ) -> DMatrix<Complex<f64>> {
        let weights: Vec<Vec<f64>> = frequency.iter().map(|&hz| self.weights(interval, hz)).collect();
        let mut product = DMatrix::zeros(0, 0);
        let (modes, bins) = motion.shape();
        for (n, node) in self.nodes(interval).into_iter().enumerate() {
            let sample = sample(node);
            if n == 0 {
                product = DMatrix::zeros(sample.nrows(), bins);
            }
            let weighted = DMatrix::from_fn(modes, bins, |mode, bin| motion[(mode, bin)] * weights[bin][n]);
            let rows = sample.nrows();
            matmul(
                MatMut::from_column_major_slice_mut(product.as_mut_slice(), rows, bins),
                Accum::Add,
                MatRef::from_column_major_slice(sample.as_slice(), rows, modes),
                MatRef::from_column_major_slice(weighted.as_slice(), modes, bins),
                Complex::from(1.0),
                Par::Seq,
            );
        }
        product
    }

    /// Estimated interpolation error of another quantity sampled at the same frequencies.
    pub(crate) fn error_of(&self, misfit: impl Fn(&Interval) -> f64) -> f64 {
        let error = |i: &Interval| extrapolated(misfit(i), i.before().as_ref().map(&misfit));
        self.intervals.iter().map(error).fold(0.0, f64::max)
    }

    /// Same as `error_of` for a field given by a matrix for each sample, relative to the largest entry in an interval.
    pub(crate) fn error_of_fields(&self, samples: &[DMatrix<Complex<f64>>]) -> f64 {
        self.error_of(|interval| field_misfit(interval, |node| &samples[node]))
    }

    /// Multiplies all frequencies by `by`.
    pub(crate) fn stretch(&mut self, by: f64) {
        self.hz.iter_mut().for_each(|hz| *hz *= by);
        self.intervals.iter_mut().for_each(|i| i.stretch(by));
    }

    /// Largest relative error of a factor interpolated like the samples, evaluated half way between them.
    pub(crate) fn error_of_factor(&self, factor: impl Fn(f64) -> f64) -> f64 {
        let of_interval = |interval: &Interval| {
            let hz = interval.samples_hz();
            let mut rising = hz.to_vec();
            rising.sort_by(f64::total_cmp);
            let known: Vec<f64> = hz.iter().map(|&hz| factor(hz)).collect();
            let at = |ends: &[f64]| {
                let middle = 0.5 * (ends[0] + ends[1]);
                let found: f64 = interval.weights(middle).iter().zip(&known).map(|(w, f)| w * f).sum();
                (found / factor(middle) - 1.0).abs()
            };
            rising.windows(2).map(at).fold(0.0, f64::max)
        };
        self.intervals.iter().map(of_interval).fold(0.0, f64::max)
    }

    /// Appends the intervals of `above` that end above this grid; returns the indices there of the samples they need,
    /// in the order of appending.
    pub(crate) fn extend(&mut self, above: &Self) -> Vec<usize> {
        let end = self.highest_hz();
        let later = || above.intervals.iter().filter(|i| i.high > end);
        let taken: Vec<usize> = (0..above.hz.len())
            .filter(|sample| later().any(|i| i.nodes.contains(sample)))
            .collect();
        let own = self.hz.len();
        self.hz.extend(taken.iter().map(|&sample| above.hz[sample]));
        for interval in later() {
            let place = |node: &usize| taken.binary_search(node).ok().map(|at| own + at);
            let nodes = interval.nodes.iter().filter_map(place).collect();
            self.intervals.push(interval.with_nodes(nodes));
        }
        self.error = self.error.max(above.error);
        taken
    }
}

/// Replaces a misfit that is NaN by infinity. An interpolant through few samples may be undefined.
pub(crate) fn or_infinite(misfit: f64) -> f64 {
    if misfit.is_nan() { f64::INFINITY } else { misfit }
}

/// Misfit of a field's test samples, relative to its largest entry in the interval. A row may be zero up to rounding,
/// for example in a mirror plane about which a mode is odd.
pub(crate) fn field_misfit<'a>(interval: &Interval, sample: impl Fn(usize) -> &'a DMatrix<Complex<f64>>) -> f64 {
    let size = |m: &DMatrix<Complex<f64>>| m.iter().map(Complex::norm_sqr).fold(0.0, f64::max).sqrt();
    let largest = interval
        .nodes
        .iter()
        .map(|&node| size(sample(node)))
        .fold(0.0, f64::max);
    let defect = |weights: Vec<f64>| {
        let mut sum = sample(interval.nodes[0]) * Complex::from(weights[0]);
        for (weight, &node) in weights.iter().zip(&interval.nodes).skip(1).filter(|(w, _)| **w != 0.0) {
            sum.zip_apply(sample(node), |to, x| *to += x * *weight);
        }
        size(&sum)
    };
    if largest > 0.0 {
        interval
            .defects()
            .into_iter()
            .map(defect)
            .map(or_infinite)
            .fold(0.0, f64::max)
            / largest
    } else {
        0.0
    }
}
