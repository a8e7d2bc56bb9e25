//! A radiation resistance sampled over frequency and interpolated.

mod air;
mod evaluate;
mod file;

use super::interval::{Interval, ORDERS, check_range, gained, lobatto};
use super::packed::{self, Packed};
use super::resistance::Resistance;
use super::roots::hermitian_root;
use crate::error::{AcousticsError, positive};
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Where and how finely a radiation resistance is sampled over frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampling {
    /// Lowest and highest sample \[Hz\]. Below the lowest every entry follows its own power law.
    pub range_hz: [f64; 2],
    /// Largest interpolation error, relative to sqrt(R_ii R_jj): of any entry R_ij, or root mean square over them where
    /// [`SampledRadiation::together`] takes the samples.
    pub tolerance: f64,
    /// A mode that radiates less than this share of the best radiator at a frequency is judged against that share: its
    /// resistance is a small difference of large numbers, and the motion hardly sounds.
    pub floor: f64,
    /// Most samples taken.
    pub most_samples: usize,
}

impl Default for Sampling {
    /// 40 Hz to 10 kHz, 1e-4, judged down to 1e-6 of the best radiator, 400 samples.
    fn default() -> Self {
        Self {
            range_hz: [40.0, 10_000.0],
            tolerance: 1e-4,
            floor: 1e-6,
            most_samples: 400,
        }
    }
}

/// A radiation resistance sampled at a few frequencies and interpolated between them.
///
/// Q = R / omega² is interpolated entrywise by Chebyshev polynomials on intervals of the frequency axis, of one octave
/// at first; rules are nested, so that raising the order keeps the samples taken. Below the lowest sample f_0
///
/// ```text
/// R_ij(f) = R_ij(f_0) (f/f_0)^{(n_i + n_j)/2}      n_i = 2, 4, 6: the slope of R_ii at f_0, rounded to even
/// ```
///
/// which keeps R positive semidefinite.
#[derive(Debug, Clone)]
pub struct SampledRadiation {
    method: String,
    modes: usize,
    patches: Vec<String>,
    intervals: Vec<Interval>,
    samples: Vec<Sample>,
    slopes: Vec<f64>,
    error: f64,
    /// Hermitian roots of the samples' whole R that intervals use, where they have been taken.
    roots: Vec<Option<Packed>>,
}

/// R of every patch at one frequency, in single precision: a result does not depend on whether it was kept.
#[derive(Debug, Clone)]
pub(super) struct Sample {
    hz: f64,
    patches: Packed,
}

impl Sample {
    pub(super) fn new(hz: f64, patches: &[Resistance]) -> Self {
        let modes = patches.first().map_or(0, |r| r.real.nrows());
        Self {
            hz,
            patches: Packed::new(modes, patches.iter()),
        }
    }

    pub(super) fn hz(&self) -> f64 {
        self.hz
    }

    /// 1 / omega².
    fn inverse(&self) -> f64 {
        (2.0 * PI * self.hz).powi(-2)
    }

    /// Q of one patch.
    fn patch(&self, patch: usize) -> Resistance {
        self.patches.matrix(patch, self.inverse())
    }

    /// Q of all patches together.
    pub(super) fn whole(&self) -> Resistance {
        self.patches.sum(self.inverse())
    }
}

impl SampledRadiation {
    /// Samples `resistance`, which returns R(f) of every patch, until the tolerance is met; frequencies in parallel.
    ///
    /// # Errors
    /// An empty range, a tolerance that is not positive, or [`AcousticsError::Unresolved`].
    pub fn new(
        method: impl Into<String>,
        modes: usize,
        patches: Vec<String>,
        sampling: &Sampling,
        resistance: impl Fn(f64) -> Vec<Resistance> + Sync,
    ) -> Result<Self, AcousticsError> {
        Self::with_kinks(method, modes, patches, (sampling, &[]), resistance)
    }

    /// The same for a resistance with kinks at some frequencies \[Hz\], which no polynomial follows: intervals end there.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_kinks(
        method: impl Into<String>,
        modes: usize,
        patches: Vec<String>,
        (sampling, kinks): (&Sampling, &[f64]),
        resistance: impl Fn(f64) -> Vec<Resistance> + Sync,
    ) -> Result<Self, AcousticsError> {
        let [low, high] = sampling.range_hz;
        positive("interpolation tolerance", sampling.tolerance)?;
        check_range(sampling.range_hz)?;
        let octaves = (high / low).log2().ceil().max(1.0) as usize;
        let edge = |i: usize| {
            if i == octaves {
                high
            } else {
                low * (high / low).powf(i as f64 / octaves as f64)
            }
        };
        let mut edges: Vec<f64> = (0..=octaves).map(edge).collect();
        edges.extend(kinks.iter().filter(|&&hz| low < hz && hz < high));
        edges.sort_by(f64::total_cmp);
        edges.dedup();
        let mut pending: Vec<(f64, f64, usize)> = edges.windows(2).map(|ends| (ends[0], ends[1], 0)).collect();
        let (mut samples, mut index) = (Vec::<Sample>::new(), BTreeMap::<u64, usize>::new());
        let mut wholes = Vec::<Vec<f64>>::new();
        let (mut intervals, mut error) = (Vec::new(), 0.0f64);
        while !pending.is_empty() {
            let mut wanted: Vec<f64> = pending.iter().flat_map(|&(a, b, o)| lobatto(a, b, ORDERS[o])).collect();
            wanted.retain(|hz| !index.contains_key(&hz.to_bits()));
            wanted.sort_by(f64::total_cmp);
            wanted.dedup();
            // Judged before they are rounded.
            let take = |&hz: &f64| {
                let patches = resistance(hz);
                (Sample::new(hz, &patches), packed::whole(modes, &patches))
            };
            for (sample, whole) in wanted.par_iter().map(take).collect::<Vec<_>>() {
                index.insert(sample.hz.to_bits(), samples.len());
                samples.push(sample);
                wholes.push(whole);
            }
            let judged: Vec<(Interval, f64)> = pending
                .par_iter()
                .map(|&(low, high, order)| {
                    let nodes = lobatto(low, high, ORDERS[order]);
                    let nodes = nodes.map(|hz| index[&hz.to_bits()]).collect();
                    let interval = Interval::chebyshev(low, high, nodes);
                    let whole = |s: usize| (&wholes[s][..], samples[s].inverse());
                    let error = interval.error(whole, modes, sampling.floor);
                    (interval, error)
                })
                .collect();
            let mut next = Vec::new();
            for ((interval, estimate), (low, high, order)) in judged.into_iter().zip(pending) {
                if estimate <= sampling.tolerance {
                    error = error.max(estimate);
                    intervals.push(interval);
                } else if samples.len() >= sampling.most_samples {
                    let (hz, samples, tolerance) = ((low * high).sqrt(), samples.len(), sampling.tolerance);
                    return Err(AcousticsError::Unresolved {
                        hz,
                        error: estimate,
                        samples,
                        tolerance,
                    });
                } else if order + 1 < ORDERS.len() {
                    next.push((low, high, order + 1));
                } else {
                    let middle = 0.5 * (low + high);
                    next.extend([(low, middle, 1), (middle, high, 1)]);
                }
            }
            pending = next;
        }
        intervals.sort_by(|a, b| a.low.total_cmp(&b.low));
        Ok(Self::of(&method.into(), modes, &patches, intervals, samples, error))
    }

    /// From intervals that rise.
    pub(super) fn of(
        method: &str,
        modes: usize,
        patches: &[String],
        intervals: Vec<Interval>,
        samples: Vec<Sample>,
        error: f64,
    ) -> Self {
        Self {
            method: method.to_owned(),
            modes,
            patches: patches.to_vec(),
            slopes: low_slopes(&intervals[0], &samples, modes),
            intervals,
            samples,
            error,
            roots: Vec::new(),
        }
    }

    pub(super) fn intervals(&self) -> &[Interval] {
        &self.intervals
    }

    pub(super) fn whole_sample(&self, sample: usize) -> Resistance {
        self.whole(sample)
    }

    /// Adds to every sample what `accurate` samples differ from those at the same frequencies, interpolated on `coarser`
    /// intervals through the first nodes of the `own` ones.
    pub(super) fn add_differences(&mut self, own: &[Interval], coarser: &[Interval], accurate: &[Sample], error: f64) {
        let mut differences: Vec<Vec<Vec<Resistance>>> = Vec::new();
        for (own, coarser) in own.iter().zip(coarser) {
            let of_node = |(&cheap, &node): (&usize, &usize)| {
                let difference = |patch: usize| {
                    let mut d = accurate[node].patch(patch);
                    d.add_scaled(-1.0, &self.samples[cheap].patch(patch));
                    d
                };
                (0..self.patches.len()).map(difference).collect::<Vec<_>>()
            };
            differences.push(own.nodes.iter().zip(&coarser.nodes).map(of_node).collect());
        }
        for sample in &mut self.samples {
            let place = coarser.iter().position(|i| sample.hz <= i.high);
            let Some(place) = place.or(coarser.len().checked_sub(1)) else {
                continue;
            };
            let mut patches: Vec<Resistance> = (0..self.patches.len()).map(|patch| sample.patch(patch)).collect();
            for (weight, of_node) in coarser[place].weights(sample.hz).iter().zip(&differences[place]) {
                for (q, difference) in patches.iter_mut().zip(of_node) {
                    q.add_scaled(*weight, difference);
                }
            }
            let omega2 = (2.0 * PI * sample.hz).powi(2);
            let patches: Vec<Resistance> = patches.into_iter().map(|q| q.scaled(omega2)).collect();
            *sample = Sample::new(sample.hz, &patches);
        }
        self.error += error;
        self.slopes = low_slopes(&self.intervals[0], &self.samples, self.modes);
    }

    /// With the roots that signals need, which are then kept beside the resistances rather than taken for every motion.
    #[must_use]
    pub fn with_roots(mut self) -> Self {
        let used = |sample: usize| self.intervals.iter().any(|interval| interval.nodes.contains(&sample));
        self.roots = (0..self.samples.len())
            .into_par_iter()
            .map(|sample| used(sample).then(|| self.root(sample)))
            .collect();
        self
    }

    /// Frequencies sampled \[Hz\], rising.
    pub fn sampled_hz(&self) -> Vec<f64> {
        let mut hz: Vec<f64> = self.samples.iter().map(|s| s.hz).collect();
        hz.sort_by(f64::total_cmp);
        hz
    }

    /// Estimated largest interpolation error, relative to sqrt(R_ii R_jj), see [`Sampling::tolerance`].
    pub fn interpolation_error(&self) -> f64 {
        self.error
    }

    /// Frequencies in the order of the samples \[Hz\].
    pub(crate) fn samples_hz(&self) -> Vec<f64> {
        self.samples.iter().map(|s| s.hz).collect()
    }

    /// Its interpolation error, judged as that of R, relative to the largest entry in the interval. A row may be zero
    /// but for rounding, as in a mirror plane that a mode is odd about.
    pub(crate) fn error_of(&self, samples: &[DMatrix<Complex<f64>>]) -> f64 {
        let size = |m: &DMatrix<Complex<f64>>| m.iter().map(|z| z.norm()).fold(0.0, f64::max);
        let mut worst: f64 = 0.0;
        for interval in &self.intervals {
            let largest = interval.nodes.iter().map(|&n| size(&samples[n])).fold(0.0, f64::max);
            let misfit = |interval: &Interval| {
                let defect = |weights: Vec<f64>| {
                    let mut sum = samples[interval.nodes[0]].scale(0.0);
                    for (weight, &node) in weights.into_iter().zip(&interval.nodes) {
                        sum += samples[node].scale(weight);
                    }
                    size(&sum)
                };
                interval.together(interval.defects().into_iter().map(defect)) / largest
            };
            if largest > 0.0 {
                worst = worst.max(gained(misfit(interval), interval.sooner().as_ref().map(misfit)));
            }
        }
        worst
    }

    fn lowest(&self) -> f64 {
        self.intervals[0].low
    }

    fn interval(&self, hz: f64) -> usize {
        self.intervals
            .partition_point(|i| i.high <= hz)
            .min(self.intervals.len() - 1)
    }

    /// What each mode's amplitude is multiplied by to evaluate the lowest sample's Q at a lower frequency.
    fn low_factor(&self, hz: f64, mode: usize) -> f64 {
        (hz / self.lowest()).powf(0.5 * self.slopes[mode] - 1.0)
    }

    /// Q of a sample, all patches together.
    fn whole(&self, sample: usize) -> Resistance {
        self.samples[sample].whole()
    }

    /// The Hermitian root of its R.
    fn root(&self, sample: usize) -> Packed {
        let root = hermitian_root(&self.samples[sample].patches.sum(1.0));
        Packed::new(self.modes, std::iter::once(&root))
    }

    /// Index of the sample at the lowest frequency.
    fn lowest_sample(&self) -> usize {
        self.intervals[0].nodes[0]
    }
}

/// Power laws of the diagonal of R at the lowest sample, rounded to even numbers from 2 up.
fn low_slopes(interval: &Interval, samples: &[Sample], modes: usize) -> Vec<f64> {
    let diagonal = |s: &Sample, i: usize| s.inverse() * s.patches.diagonal(i);
    let mut rising = interval.nodes.clone();
    rising.sort_by(|&a, &b| samples[a].hz.total_cmp(&samples[b].hz));
    let (first, second) = (&samples[rising[0]], &samples[rising[1]]);
    let slope = |i: usize| {
        let ratio = diagonal(second, i) / diagonal(first, i);
        let slope = 2.0 + ratio.ln() / (second.hz / first.hz).ln();
        if slope.is_finite() {
            (2.0 * (slope / 2.0).round()).max(2.0)
        } else {
            2.0
        }
    };
    (0..modes).map(slope).collect()
}
