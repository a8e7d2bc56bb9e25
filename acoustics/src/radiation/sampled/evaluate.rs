//! Energies and signals of motions from a sampled radiation resistance.

use super::SampledRadiation;
use crate::radiation::resistance::{ModalRadiation, Resistance};
use crate::radiation::roots::image;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use nalgebra::{Complex, ComplexField, DMatrix};
use rayon::prelude::*;
use std::borrow::Cow;
use std::f64::consts::PI;

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
