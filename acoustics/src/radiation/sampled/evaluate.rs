//! Energies and signals of motions from a sampled radiation resistance.

use super::SampledRadiation;
use crate::radiation::packed::{Motions, Packed};
use crate::radiation::products::{forms, image};
use crate::radiation::resistance::{ModalRadiation, Resistance};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use nalgebra::{Complex, ComplexField, DMatrix};
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::BTreeMap;
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
        if hz < self.lowest() {
            let mut result = self.whole(self.lowest_sample()).scaled(omega2);
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
        let mut result = Resistance::zeros(self.modes);
        let interval = &self.intervals[self.interval(hz)];
        for (node, weight) in interval.nodes.iter().zip(interval.weights(hz)) {
            result.add_scaled(omega2 * weight, &self.whole(*node));
        }
        result
    }

    fn sparse_forms(&self, motions: &[(f64, Vec<(usize, f64)>)]) -> Vec<f64> {
        let form = |(hz, v): &(f64, Vec<(usize, f64)>)| {
            let of_sample = |sample: usize, v: &[(usize, f64)]| {
                let sample = &self.samples[sample];
                (hz / sample.hz).powi(2) * sample.patches.sparse_form(v)
            };
            if *hz < self.lowest() {
                let scaled: Vec<(usize, f64)> = v.iter().map(|&(i, a)| (i, a * self.low_factor(*hz, i))).collect();
                return of_sample(self.lowest_sample(), &scaled);
            }
            let interval = &self.intervals[self.interval(*hz)];
            let parts = interval.nodes.iter().zip(interval.weights(*hz));
            parts.map(|(node, weight)| weight * of_sample(*node, v)).sum()
        };
        motions.par_iter().map(form).collect()
    }

    fn energy_forms(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<f64> {
        let patches = self.patches.len();
        let evaluate = |&(at, start, end): &Run| {
            let hz = &frequency[start..end];
            let motions = Motions::new(&self.in_the_law(at, hz, accelerations, start));
            let nodes = self.nodes(at);
            let samples: Vec<&Packed> = nodes.iter().map(|&node| &self.samples[node].patches).collect();
            let found = forms(&samples, &motions);
            let mut result = DMatrix::zeros(patches, hz.len());
            for (bin, mut result) in result.column_iter_mut().enumerate() {
                for (n, (node, weight)) in nodes.iter().zip(self.weights(at, hz[bin])).enumerate() {
                    let factor = weight * self.samples[*node].inverse();
                    for (p, result) in result.iter_mut().enumerate() {
                        *result += factor * found[(n * patches + p) * hz.len() + bin];
                    }
                }
                result *= motions.scale(bin).powi(2);
            }
            result
        };
        side_by_side(patches, frequency.len(), &self.runs(frequency), evaluate)
    }

    fn images(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let runs = self.runs(frequency);
        let rows = self.rows_of(&runs, |sample| Cow::Owned(self.samples[sample].patches.sum_row()));
        let evaluate = |run: &Run| {
            let hz = &frequency[run.1..run.2];
            let mut images = self.carried(&rows, 2, run, frequency, accelerations);
            if run.0.is_none() {
                self.follow_the_law(hz, &mut images);
            }
            images
        };
        side_by_side(self.modes, frequency.len(), &runs, evaluate)
    }

    /// S is interpolated as Q is, entry by entry with the same polynomials; below the lowest sample it is D S(f_0) with
    /// the power laws D on the diagonal, whose energy is exact.
    fn root_signals(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let runs = self.runs(frequency);
        let kept = |sample: usize| self.roots.get(sample).and_then(Option::as_ref);
        let row = |sample: usize| match kept(sample) {
            Some(root) => Cow::Borrowed(root.row(0)),
            None => Cow::Owned(self.root(sample).row(0).to_vec()),
        };
        let rows = self.rows_of(&runs, row);
        let evaluate = |run: &Run| self.carried(&rows, 1, run, frequency, accelerations);
        side_by_side(self.modes, frequency.len(), &runs, evaluate)
    }
}

/// A row of [`Packed`] form for every sample that is wanted, by its number.
type Rows<'a> = BTreeMap<usize, Cow<'a, [f32]>>;

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
    /// A quantity linear in the modes' accelerations (modes x bins), sampled beside R at all frequencies (rows x modes
    /// each), between them, rows x bins; below the lowest sample every mode's amplitude follows the power law of its
    /// resistance.
    pub(crate) fn interpolated(
        &self,
        frequency: &[f64],
        samples: &[DMatrix<Complex<f64>>],
        accelerations: &DMatrix<Complex<f64>>,
    ) -> DMatrix<Complex<f64>> {
        let rows = samples.first().map_or(0, DMatrix::nrows);
        let evaluate = |&(at, start, end): &Run| {
            let motion = self.in_the_law(at, &frequency[start..end], accelerations, start);
            let of_node = |node: usize| {
                let sample = MatRef::from_column_major_slice(samples[node].as_slice(), rows, self.modes);
                let mut of_node = DMatrix::zeros(rows, end - start);
                matmul(
                    MatMut::from_column_major_slice_mut(of_node.as_mut_slice(), rows, end - start),
                    Accum::Replace,
                    sample,
                    MatRef::from_column_major_slice(motion.as_slice(), self.modes, end - start),
                    Complex::ONE,
                    Par::Seq,
                );
                of_node
            };
            match at {
                None => of_node(self.lowest_sample()),
                Some(i) => self.intervals[i].blend(&frequency[start..end], of_node),
            }
        };
        side_by_side(rows, frequency.len(), &self.runs(frequency), evaluate)
    }

    /// The motion at some bins from `start` on, below the lowest sample by the power laws of the modes.
    fn in_the_law(
        &self,
        at: Option<usize>,
        frequency: &[f64],
        accelerations: &DMatrix<Complex<f64>>,
        start: usize,
    ) -> DMatrix<Complex<f64>> {
        let mut motion = accelerations.columns(start, frequency.len()).into_owned();
        if at.is_none() {
            self.follow_the_law(frequency, &mut motion);
        }
        motion
    }

    /// Multiplies every mode's amplitude by what its power law says below the lowest sample.
    fn follow_the_law(&self, frequency: &[f64], motion: &mut DMatrix<Complex<f64>>) {
        for (mut bin, &hz) in motion.column_iter_mut().zip(frequency) {
            for (mode, a) in bin.iter_mut().enumerate() {
                *a *= self.low_factor(hz, mode);
            }
        }
    }

    /// Runs of bins that share an interval, cut into chunks: the interval and the bins' half-open range. No interval
    /// is below the lowest sample.
    fn runs(&self, frequency: &[f64]) -> Vec<Run> {
        const CHUNK: usize = 64;
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

    /// Samples of an interval; the lowest one, without.
    fn nodes(&self, at: Option<usize>) -> Vec<usize> {
        at.map_or_else(|| vec![self.lowest_sample()], |i| self.intervals[i].nodes.clone())
    }

    /// Their weights at a frequency.
    fn weights(&self, at: Option<usize>, hz: f64) -> Vec<f64> {
        at.map_or_else(|| vec![1.0], |i| self.intervals[i].weights(hz))
    }

    /// The rows of all samples that some runs need.
    fn rows_of<'a>(&self, runs: &[Run], row: impl Fn(usize) -> Cow<'a, [f32]> + Sync) -> Rows<'a> {
        let mut wanted: Vec<usize> = runs.iter().flat_map(|run| self.nodes(run.0)).collect();
        wanted.sort_unstable();
        wanted.dedup();
        wanted.par_iter().map(|&sample| (sample, row(sample))).collect()
    }

    /// M a for the bins of a run, with M / omega^power interpolated between rows of matrices.
    fn carried(
        &self,
        rows: &Rows<'_>,
        power: i32,
        &(at, start, end): &Run,
        frequency: &[f64],
        accelerations: &DMatrix<Complex<f64>>,
    ) -> DMatrix<Complex<f64>> {
        let hz = &frequency[start..end];
        let motions = Motions::new(&self.in_the_law(at, hz, accelerations, start));
        let nodes = self.nodes(at);
        let rows: Vec<&[f32]> = nodes.iter().map(|node| &*rows[node]).collect();
        // Sand that moves in a part of the range only has an imaginary part in some samples.
        let length = rows.iter().map(|row| row.len()).max().unwrap_or(0);
        let skew = nodes.iter().any(|&node| self.samples[node].patches.is_skew());
        let mut samples = Mat::<f32>::zeros(length, nodes.len());
        for (row, column) in rows.iter().zip(samples.col_iter_mut()) {
            column.iter_mut().zip(*row).for_each(|(to, v)| *to = *v);
        }
        // Relative to omega^power at the bin, which single precision holds.
        let mut weights = Mat::<f32>::zeros(nodes.len(), hz.len());
        for (bin, &f) in hz.iter().enumerate() {
            for (n, (node, weight)) in nodes.iter().zip(self.weights(at, f)).enumerate() {
                weights[(n, bin)] = (weight * (f / self.samples[*node].hz).powi(power)) as f32;
            }
        }
        let mut matrices = Mat::<f32>::zeros(length, hz.len());
        matmul(
            matrices.as_mut(),
            Accum::Replace,
            samples.as_ref(),
            weights.as_ref(),
            1.0,
            Par::Seq,
        );
        let mut carried = DMatrix::zeros(self.modes, hz.len());
        for (bin, mut carried) in carried.column_iter_mut().enumerate() {
            let Some(row) = matrices.col(bin).try_as_col_major() else {
                continue;
            };
            let scale = motions.scale(bin) / (2.0 * PI * hz[bin]).powi(power);
            let [re, im] = image(self.modes, skew, row.as_slice(), motions.part(bin));
            for (to, (re, im)) in carried.iter_mut().zip(re.into_iter().zip(im)) {
                *to = Complex::new(f64::from(re), f64::from(im)) * scale;
            }
        }
        carried
    }
}
