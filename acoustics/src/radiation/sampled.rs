use super::archive::{Archive, ArchiveReader, ArchiveWriter};
use super::interval::{Interval, ORDERS, check_range, lobatto};
use super::resistance::{ModalRadiation, Resistance};
use super::roots::{hermitian_root, image};
use crate::error::{AcousticsError, positive};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use nalgebra::{Complex, ComplexField, DMatrix};
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Where and how finely a radiation resistance is sampled over frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampling {
    /// Lowest and highest sample \[Hz\]. Below the lowest every entry follows its own power law.
    pub range_hz: [f64; 2],
    /// Largest interpolation error of an entry R_ij, relative to sqrt(R_ii R_jj).
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
    /// Hermitian roots of the samples' whole Q that intervals use, where they have been taken.
    roots: Vec<Option<Resistance>>,
}

/// Q of every patch at one frequency.
#[derive(Debug, Clone)]
pub(super) struct Sample {
    hz: f64,
    patches: Vec<Resistance>,
}

impl Sample {
    pub(super) fn new(hz: f64, patches: Vec<Resistance>) -> Self {
        Self { hz, patches }
    }

    /// Q of all patches together.
    pub(super) fn whole(&self, modes: usize) -> Resistance {
        let mut whole = Resistance::zeros(modes);
        self.patches.iter().for_each(|q| whole.add_scaled(1.0, q));
        whole
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
        let (mut intervals, mut error) = (Vec::new(), 0.0f64);
        while !pending.is_empty() {
            let mut wanted: Vec<f64> = pending.iter().flat_map(|&(a, b, o)| lobatto(a, b, ORDERS[o])).collect();
            wanted.retain(|hz| !index.contains_key(&hz.to_bits()));
            wanted.sort_by(f64::total_cmp);
            wanted.dedup();
            let take = |&hz: &f64| {
                let inverse = (2.0 * PI * hz).powi(-2);
                Sample {
                    hz,
                    patches: resistance(hz).into_iter().map(|r| r.scaled(inverse)).collect(),
                }
            };
            for sample in wanted.par_iter().map(take).collect::<Vec<_>>() {
                index.insert(sample.hz.to_bits(), samples.len());
                samples.push(sample);
            }
            let judged: Vec<(Interval, f64)> = pending
                .par_iter()
                .map(|&(low, high, order)| {
                    let nodes = lobatto(low, high, ORDERS[order]);
                    let nodes = nodes.map(|hz| index[&hz.to_bits()]).collect();
                    let interval = Interval::chebyshev(low, high, nodes);
                    let error = interval.error(|s| samples[s].whole(modes), modes, sampling.floor);
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

    /// Estimated largest interpolation error of an entry R_ij, relative to sqrt(R_ii R_jj).
    pub fn interpolation_error(&self) -> f64 {
        self.error
    }

    /// Frequencies in the order of the samples \[Hz\].
    pub(crate) fn samples_hz(&self) -> Vec<f64> {
        self.samples.iter().map(|s| s.hz).collect()
    }

    /// A quantity linear in the modes' accelerations, sampled beside R at all frequencies (rows x modes each), between
    /// them; below the lowest sample every mode's amplitude follows the power law of its resistance.
    pub(crate) fn interpolated(
        &self,
        hz: f64,
        samples: &[DMatrix<Complex<f64>>],
        accelerations: &[Complex<f64>],
    ) -> Vec<Complex<f64>> {
        let (nodes, weights) = if hz < self.lowest() {
            (vec![self.lowest_sample()], vec![1.0])
        } else {
            let interval = &self.intervals[self.interval(hz)];
            (interval.nodes.clone(), interval.weights(hz))
        };
        let scaled = |(mode, a): (usize, &Complex<f64>)| {
            if hz < self.lowest() {
                a * self.low_factor(hz, mode)
            } else {
                *a
            }
        };
        let a: Vec<Complex<f64>> = accelerations.iter().enumerate().map(scaled).collect();
        let mut sum = vec![Complex::default(); samples[nodes[0]].nrows()];
        for (node, weight) in nodes.iter().zip(weights) {
            for (column, a) in samples[*node].column_iter().zip(&a) {
                let a = a * weight;
                sum.iter_mut().zip(column.iter()).for_each(|(sum, x)| *sum += x * a);
            }
        }
        sum
    }

    /// Its interpolation error, judged as that of R, relative to the largest entry in the interval. A row may be zero
    /// but for rounding, as in a mirror plane that a mode is odd about.
    pub(crate) fn error_of(&self, samples: &[DMatrix<Complex<f64>>]) -> f64 {
        let size = |m: &DMatrix<Complex<f64>>| m.iter().map(|z| z.norm()).fold(0.0, f64::max);
        let mut worst: f64 = 0.0;
        for interval in &self.intervals {
            let defect = |weights: Vec<f64>| {
                let mut sum = samples[interval.nodes[0]].scale(0.0);
                for (weight, &node) in weights.into_iter().zip(&interval.nodes) {
                    sum += samples[node].scale(weight);
                }
                size(&sum)
            };
            let largest = interval.nodes.iter().map(|&n| size(&samples[n])).fold(0.0, f64::max);
            if largest > 0.0 {
                worst = worst.max(interval.together(interval.defects().into_iter().map(defect)) / largest);
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

    /// Runs of bins that share an interval, cut into chunks: the interval and the bins' half-open range. No interval
    /// is below the lowest sample.
    fn runs(&self, frequency: &[f64]) -> Vec<Run> {
        const CHUNK: usize = 256;
        let place = |&hz: &f64| (hz >= self.lowest()).then(|| self.interval(hz));
        let mut runs: Vec<Run> = Vec::new();
        for (bin, at) in frequency.iter().map(place).enumerate() {
            match runs.last_mut() {
                Some((last, start, end)) if *last == at && bin - *start < CHUNK => *end = bin + 1,
                _ => runs.push((at, bin, bin + 1)),
            }
        }
        runs
    }

    /// Q of a sample, all patches together.
    fn whole(&self, sample: usize) -> Resistance {
        self.samples[sample].whole(self.modes)
    }

    /// Its Hermitian root.
    fn root(&self, sample: usize) -> Resistance {
        hermitian_root(&self.whole(sample))
    }

    /// Index of the sample at the lowest frequency.
    fn lowest_sample(&self) -> usize {
        self.intervals[0].nodes[0]
    }
}

impl ModalRadiation for SampledRadiation {
    fn method(&self) -> &str {
        &self.method
    }

    fn modes(&self) -> usize {
        self.modes
    }

    fn patches(&self) -> &[String] {
        &self.patches
    }

    fn highest_hz(&self) -> f64 {
        self.intervals.last().map_or(0.0, |i| i.high)
    }

    fn resistance(&self, hz: f64) -> Resistance {
        let omega2 = (2.0 * PI * hz).powi(2);
        let mut result = Resistance::zeros(self.modes);
        if hz < self.lowest() {
            for patch in &self.samples[self.lowest_sample()].patches {
                result.add_scaled(omega2, patch);
            }
            let scale = |m: &mut DMatrix<f64>| {
                for j in 0..self.modes {
                    for i in 0..self.modes {
                        m[(i, j)] *= self.low_factor(hz, i) * self.low_factor(hz, j);
                    }
                }
            };
            scale(&mut result.real);
            result.imaginary.as_mut().map(scale);
            return result;
        }
        let interval = &self.intervals[self.interval(hz)];
        for (node, weight) in interval.nodes.iter().zip(interval.weights(hz)) {
            for patch in &self.samples[*node].patches {
                result.add_scaled(omega2 * weight, patch);
            }
        }
        result
    }

    /// One product for an interval: its samples, packed by the pairs of modes, times the pairs' products.
    fn energy_forms(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<f64> {
        let patches = self.patches.len();
        let runs = self.runs(frequency);
        let mut wanted: Vec<Option<usize>> = runs.iter().map(|run| run.0).collect();
        wanted.sort_unstable();
        wanted.dedup();
        let skew = self
            .samples
            .iter()
            .flat_map(|s| &s.patches)
            .any(|q| q.imaginary.is_some());
        let packed: Vec<Mat<f64>> = wanted.par_iter().map(|&at| self.packed(at, skew)).collect();
        let evaluate = |&(at, start, end): &Run| {
            let packed = &packed[wanted.partition_point(|w| *w < at)];
            let mut products = Mat::zeros(packed.ncols(), end - start);
            for (column, bin) in (start..end).enumerate() {
                let a: Vec<Complex<f64>> = (0..self.modes)
                    .map(|i| match at {
                        None => accelerations[(i, bin)] * self.low_factor(frequency[bin], i),
                        Some(_) => accelerations[(i, bin)],
                    })
                    .collect();
                let mut to = products.col_mut(column).iter_mut();
                for j in 0..self.modes {
                    for i in 0..=j {
                        let product = a[i].re * a[j].re + a[i].im * a[j].im;
                        to.next()
                            .into_iter()
                            .for_each(|to| *to = if i == j { product } else { 2.0 * product });
                    }
                }
                for j in 0..if skew { self.modes } else { 0 } {
                    for i in 0..j {
                        let product = 2.0 * (a[i].im * a[j].re - a[j].im * a[i].re);
                        to.next().into_iter().for_each(|to| *to = product);
                    }
                }
            }
            let mut forms = Mat::zeros(packed.nrows(), end - start);
            matmul(
                forms.as_mut(),
                Accum::Replace,
                packed.as_ref(),
                products.as_ref(),
                1.0,
                Par::Seq,
            );
            let weights = |bin: usize| match at {
                None => vec![1.0],
                Some(i) => self.intervals[i].weights(frequency[bin]),
            };
            let mut result = DMatrix::zeros(patches, end - start);
            for column in 0..end - start {
                for (n, weight) in weights(start + column).into_iter().enumerate() {
                    for p in 0..patches {
                        result[(p, column)] += weight * forms[(n * patches + p, column)];
                    }
                }
            }
            result
        };
        side_by_side(patches, frequency.len(), &runs, evaluate)
    }

    fn images(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let runs = self.runs(frequency);
        let evaluate = |&(at, start, end): &Run| {
            let mut motion = accelerations.columns(start, end - start).into_owned();
            let Some(i) = at else {
                let scale = |motion: &mut DMatrix<Complex<f64>>| {
                    for (mut bin, &hz) in motion.column_iter_mut().zip(&frequency[start..end]) {
                        for (mode, a) in bin.iter_mut().enumerate() {
                            *a *= self.low_factor(hz, mode);
                        }
                    }
                };
                scale(&mut motion);
                let mut result = image(&self.whole(self.lowest_sample()), &motion);
                scale(&mut result);
                return result;
            };
            self.intervals[i].blend(&frequency[start..end], |node| image(&self.whole(node), &motion))
        };
        side_by_side(self.modes, frequency.len(), &runs, evaluate)
    }

    /// S is interpolated as Q is, entry by entry with the same polynomials; below the lowest sample it is D S(f_0) with
    /// the power laws D on the diagonal, whose energy is exact.
    fn root_signals(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let runs = self.runs(frequency);
        let mut wanted: Vec<usize> = runs
            .iter()
            .flat_map(|&(at, _, _)| match at {
                None => vec![self.lowest_sample()],
                Some(i) => self.intervals[i].nodes.clone(),
            })
            .collect();
        wanted.sort_unstable();
        wanted.dedup();
        let kept = |sample: usize| self.roots.get(sample).and_then(Option::as_ref);
        let roots: Vec<Cow<'_, Resistance>> = wanted
            .par_iter()
            .map(|&sample| kept(sample).map_or_else(|| Cow::Owned(self.root(sample)), Cow::Borrowed))
            .collect();
        let root_of = |sample: usize| &*roots[wanted.partition_point(|&w| w < sample)];
        let evaluate = |&(at, start, end): &Run| {
            let mut motion = accelerations.columns(start, end - start).into_owned();
            let Some(i) = at else {
                for (mut bin, &hz) in motion.column_iter_mut().zip(&frequency[start..end]) {
                    for (mode, a) in bin.iter_mut().enumerate() {
                        *a *= self.low_factor(hz, mode);
                    }
                }
                return image(root_of(self.lowest_sample()), &motion);
            };
            self.intervals[i].blend(&frequency[start..end], |node| image(root_of(node), &motion))
        };
        side_by_side(self.modes, frequency.len(), &runs, evaluate)
    }
}

/// Bins that one interval serves, none below the lowest sample: the interval, the first bin and the one after the last.
type Run = (Option<usize>, usize, usize);

/// The blocks of all runs, evaluated in parallel, in the order of their bins.
fn side_by_side<T: ComplexField>(
    rows: usize,
    bins: usize,
    runs: &[Run],
    evaluate: impl Fn(&Run) -> DMatrix<T> + Sync + Send,
) -> DMatrix<T> {
    let blocks: Vec<DMatrix<T>> = runs.par_iter().map(evaluate).collect();
    let mut all = DMatrix::zeros(rows, bins);
    for (&(_, start, end), block) in runs.iter().zip(&blocks) {
        all.columns_mut(start, end - start).copy_from(block);
    }
    all
}

impl SampledRadiation {
    /// Samples of an interval (the lowest sample, without one) and their patches, row by row: the upper triangle column
    /// by column, then with `skew` the imaginary one without its diagonal.
    fn packed(&self, at: Option<usize>, skew: bool) -> Mat<f64> {
        let lowest = [self.lowest_sample()];
        let nodes = at.map_or(&lowest[..], |i| &self.intervals[i].nodes);
        let (modes, patches) = (self.modes, self.patches.len());
        let pairs = modes * (modes + 1) / 2;
        let columns = pairs + if skew { pairs - modes } else { 0 };
        let mut packed = Mat::zeros(nodes.len() * patches, columns);
        for (row, q) in nodes.iter().flat_map(|&node| &self.samples[node].patches).enumerate() {
            let upper = (0..modes).flat_map(|j| (0..=j).map(move |i| (i, j)));
            for (column, at) in upper.enumerate() {
                packed[(row, column)] = q.real[at];
            }
            let Some(imaginary) = q.imaginary.as_ref().filter(|_| skew) else {
                continue;
            };
            let upper = (0..modes).flat_map(|j| (0..j).map(move |i| (i, j)));
            for (column, at) in upper.enumerate() {
                packed[(row, pairs + column)] = imaginary[at];
            }
        }
        packed
    }
}

/// Power laws of the diagonal of R at the lowest sample, rounded to even numbers from 2 up.
fn low_slopes(interval: &Interval, samples: &[Sample], modes: usize) -> Vec<f64> {
    let diagonal = |s: &Sample, i: usize| s.patches.iter().map(|p| p.real[(i, i)]).sum::<f64>();
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

/// Samples and their roots, kept in single precision.
impl Archive for SampledRadiation {
    fn write(&self, to: &mut ArchiveWriter) {
        to.texts(std::slice::from_ref(&self.method));
        to.count(self.modes);
        to.texts(&self.patches);
        to.count(self.samples.len());
        for sample in &self.samples {
            to.numbers(&[sample.hz]);
            // R fits single precision; Q = R / omega² at high frequencies may not.
            let omega2 = (2.0 * PI * sample.hz).powi(2);
            sample
                .patches
                .iter()
                .for_each(|q| to.hermitian(&q.clone().scaled(omega2)));
        }
        to.count(self.roots.len());
        for (root, sample) in self.roots.iter().zip(&self.samples) {
            to.count(usize::from(root.is_some()));
            if let Some(root) = root {
                to.hermitian(&root.clone().scaled(2.0 * PI * sample.hz));
            }
        }
        to.count(self.intervals.len());
        for interval in &self.intervals {
            to.numbers(&[interval.low, interval.high]);
            to.count(interval.tried);
            to.count(interval.nodes.len());
            interval.nodes.iter().for_each(|node| to.count(*node));
        }
        to.numbers(&self.slopes);
        to.numbers(&[self.error]);
    }

    fn read(from: &mut ArchiveReader<'_>) -> Result<Self, AcousticsError> {
        let method = from.texts()?.pop().ok_or_else(|| from.damaged())?;
        let modes = from.count()?;
        let patches = from.texts()?;
        let mut samples = Vec::new();
        for _ in 0..from.count()? {
            let [hz] = from.numbers()?;
            let inverse = (2.0 * PI * hz).powi(-2);
            let mut of_patches = Vec::new();
            for _ in &patches {
                of_patches.push(from.hermitian(modes)?.scaled(inverse));
            }
            samples.push(Sample {
                hz,
                patches: of_patches,
            });
        }
        let mut roots = Vec::new();
        for sample in 0..from.count()? {
            let hz = samples.get(sample).map(|sample: &Sample| sample.hz);
            let inverse = (2.0 * PI * hz.ok_or_else(|| from.damaged())?).recip();
            roots.push(match from.count()? {
                0 => None,
                _ => Some(from.hermitian(modes)?.scaled(inverse)),
            });
        }
        let mut intervals = Vec::new();
        for _ in 0..from.count()? {
            let [low, high] = from.numbers()?;
            let tried = from.count()?;
            let count = from.count()?;
            let nodes = (0..count).map(|_| from.count()).collect::<Result<Vec<_>, _>>()?;
            let known = nodes.iter().all(|n| *n < samples.len());
            let interval = Interval::kept(low, high, nodes, tried).filter(|_| known);
            intervals.push(interval.ok_or_else(|| from.damaged())?);
        }
        let mut slopes = Vec::new();
        for _ in 0..modes {
            let [slope] = from.numbers()?;
            slopes.push(slope);
        }
        let [error] = from.numbers()?;
        if intervals.is_empty() {
            return Err(from.damaged());
        }
        Ok(Self {
            method,
            modes,
            patches,
            intervals,
            samples,
            slopes,
            error,
            roots,
        })
    }
}
