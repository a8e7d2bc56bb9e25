//! Evaluates energies and signals of motions from a sampled radiation resistance.

use super::{Run, SampledRadiation, per_omega2};
use crate::radiation::operator::ModalRadiation;
use crate::radiation::packed::{self, Motions, PackedHermitian};
use crate::radiation::products::{forms, image};
use crate::radiation::resistance::Resistance;
use faer::linalg::matmul::matmul;
use faer::traits::RealField;
use faer::traits::math_utils::from_f64;
use faer::{Accum, Mat, Par};
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
        self.grid.highest_hz()
    }

    fn resistance(&self, hz: f64) -> Resistance {
        let mut result = Resistance::zeros(self.modes);
        for (node, weight) in self.grid.weighted(hz) {
            let factor = weight * (hz / self.grid.hz()[node]).powi(2);
            result.add_scaled(1.0, &self.samples[node].sum(factor));
        }
        if hz < self.grid.lowest_hz() {
            let factors: Vec<f64> = (0..self.modes).map(|mode| self.low_factor(hz, mode)).collect();
            for m in std::iter::once(&mut result.real).chain(&mut result.imaginary) {
                for (mut column, factor) in m.column_iter_mut().zip(&factors) {
                    column.iter_mut().zip(&factors).for_each(|(r, f)| *r *= f * factor);
                }
            }
        }
        result
    }

    fn sparse_forms(&self, motions: &[(f64, Vec<(usize, f64)>)]) -> Vec<f64> {
        let form = |(hz, v): &(f64, Vec<(usize, f64)>)| {
            let mut v = v.clone();
            if *hz < self.grid.lowest_hz() {
                v.iter_mut().for_each(|(mode, a)| *a *= self.low_factor(*hz, *mode));
            }
            let of_node = |(node, weight): (usize, f64)| {
                weight * (hz / self.grid.hz()[node]).powi(2) * self.samples[node].sparse_form(&v)
            };
            self.grid.weighted(*hz).map(of_node).sum()
        };
        motions.par_iter().map(form).collect()
    }

    fn energy_forms(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<f64> {
        let patches = self.patches.len();
        let evaluate = |run: &Run| {
            let hz = &frequency[run.bins.clone()];
            let motions = Motions::new(&self.motion(run, frequency, accelerations));
            let nodes = self.grid.nodes(run.interval);
            let samples: Vec<&PackedHermitian> = nodes.iter().map(|&node| &self.samples[node]).collect();
            let found = forms(&samples, &motions);
            let mut result = DMatrix::zeros(patches, hz.len());
            for (bin, mut result) in result.column_iter_mut().enumerate() {
                for (n, (node, weight)) in nodes.iter().zip(self.grid.weights(run.interval, hz[bin])).enumerate() {
                    let factor = weight * per_omega2(self.grid.hz()[*node]);
                    for (p, result) in result.iter_mut().enumerate() {
                        *result += factor * found[(n * patches + p) * hz.len() + bin];
                    }
                }
                result *= motions.scale(bin).powi(2);
            }
            result
        };
        side_by_side(patches, frequency.len(), &self.grid.runs(frequency), evaluate)
    }

    /// Evaluated in double precision, because other terms cancel most of it in the equations of a fluid-loaded
    /// structure.
    fn images(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let runs = self.grid.runs(frequency);
        let rows = self.rows_of(&runs, |sample| Cow::Owned(self.samples[sample].summed()));
        let evaluate = |run: &Run| {
            let matrices = self.matrices(&rows, 2, run, frequency);
            let skew = self.is_skew(run);
            let mut images = self.motion(run, frequency, accelerations);
            for ((bin, matrix), mut image) in run.bins.clone().zip(matrices.col_iter()).zip(images.column_iter_mut()) {
                let row: Vec<f64> = matrix.iter().copied().collect();
                let product = packed::product(self.modes, skew, &row, image.as_slice());
                image.copy_from(&(product * Complex::from(per_omega2(frequency[bin]))));
            }
            self.extrapolate(run, frequency, &mut images);
            images
        };
        side_by_side(self.modes, frequency.len(), &runs, evaluate)
    }

    /// S is interpolated like Q, entry by entry with the same polynomials. Below the lowest sample it is D S(f_0),
    /// where D is the diagonal matrix of the power laws; its energy is exact.
    fn root_signals(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let runs = self.grid.runs(frequency);
        let stored = |sample: usize| self.roots.get(sample).and_then(Option::as_ref);
        let row = |sample: usize| match stored(sample) {
            Some(root) => Cow::Borrowed(root.row(0)),
            None => Cow::Owned(self.root(sample).row(0).to_vec()),
        };
        let rows = self.rows_of(&runs, row);
        let evaluate = |run: &Run| self.root_products(&rows, run, frequency, accelerations);
        side_by_side(self.modes, frequency.len(), &runs, evaluate)
    }
}

/// A packed row for each sample needed, by index.
type Rows<'a, T> = BTreeMap<usize, Cow<'a, [T]>>;

/// Evaluates all runs in parallel and joins the results in the order of their bins.
fn side_by_side<T: ComplexField>(
    rows: usize,
    bins: usize,
    runs: &[Run],
    evaluate: impl Fn(&Run) -> DMatrix<T> + Sync + Send,
) -> DMatrix<T> {
    let blocks: Vec<DMatrix<T>> = runs.par_iter().map(evaluate).collect();
    let mut all = DMatrix::zeros(rows, bins);
    for (run, block) in runs.iter().zip(&blocks) {
        all.columns_mut(run.bins.start, run.bins.len()).copy_from(block);
    }
    all
}

impl SampledRadiation {
    /// Interpolates a quantity that is linear in the modal accelerations (modes x bins) and given at the samples of R
    /// (rows x modes each); returns rows x bins. Below the lowest sample the amplitude of every mode follows the power
    /// law of its resistance.
    pub(crate) fn interpolated(
        &self,
        frequency: &[f64],
        samples: &[DMatrix<Complex<f64>>],
        accelerations: &DMatrix<Complex<f64>>,
    ) -> DMatrix<Complex<f64>> {
        let evaluate = |run: &Run| {
            let motion = self.motion(run, frequency, accelerations);
            self.grid.product(
                run.interval,
                &frequency[run.bins.clone()],
                |node| &samples[node],
                &motion,
            )
        };
        let rows = samples.first().map_or(0, DMatrix::nrows);
        side_by_side(rows, frequency.len(), &self.grid.runs(frequency), evaluate)
    }

    /// The motion in the bins of a run, scaled by the modes' power laws below the lowest sample.
    fn motion(&self, run: &Run, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let mut motion = accelerations.columns(run.bins.start, run.bins.len()).into_owned();
        self.extrapolate(run, frequency, &mut motion);
        motion
    }

    /// Multiplies each mode's amplitude by its power law if a run lies below the lowest sample.
    fn extrapolate(&self, run: &Run, frequency: &[f64], motion: &mut DMatrix<Complex<f64>>) {
        if run.interval.is_none() {
            for (mut bin, &hz) in motion.column_iter_mut().zip(&frequency[run.bins.clone()]) {
                bin.iter_mut()
                    .enumerate()
                    .for_each(|(mode, a)| *a *= self.low_factor(hz, mode));
            }
        }
    }

    /// Rows of all samples needed by some runs.
    fn rows_of<'a, T: Clone + Send + Sync>(
        &self,
        runs: &[Run],
        row: impl Fn(usize) -> Cow<'a, [T]> + Sync,
    ) -> Rows<'a, T> {
        let mut wanted: Vec<usize> = runs.iter().flat_map(|run| self.grid.nodes(run.interval)).collect();
        wanted.sort_unstable();
        wanted.dedup();
        wanted.par_iter().map(|&sample| (sample, row(sample))).collect()
    }

    /// Whether any sample of a run has an imaginary part; if sand moves only in part of the range, not all samples have
    /// one.
    fn is_skew(&self, run: &Run) -> bool {
        let nodes = self.grid.nodes(run.interval);
        nodes.iter().any(|&node| self.samples[node].is_skew())
    }

    /// omega^power times M / omega^power, interpolated between rows of matrices, with one column for each bin of a run.
    /// This scaling keeps values within the range of single precision.
    fn matrices<T: RealField + Copy>(&self, rows: &Rows<'_, T>, power: i32, run: &Run, frequency: &[f64]) -> Mat<T> {
        let hz = &frequency[run.bins.clone()];
        let nodes = self.grid.nodes(run.interval);
        let rows: Vec<&[T]> = nodes.iter().map(|node| &*rows[node]).collect();
        let length = rows.iter().map(|row| row.len()).max().unwrap_or(0);
        let mut samples = Mat::<T>::zeros(length, nodes.len());
        for (row, column) in rows.iter().zip(samples.col_iter_mut()) {
            column.iter_mut().zip(*row).for_each(|(to, v)| *to = *v);
        }
        let mut weights = Mat::<T>::zeros(nodes.len(), hz.len());
        for (bin, &f) in hz.iter().enumerate() {
            for (n, (node, weight)) in nodes.iter().zip(self.grid.weights(run.interval, f)).enumerate() {
                weights[(n, bin)] = from_f64(weight * (f / self.grid.hz()[*node]).powi(power));
            }
        }
        let mut matrices = Mat::<T>::zeros(length, hz.len());
        let whole = from_f64(1.0);
        matmul(
            matrices.as_mut(),
            Accum::Replace,
            samples.as_ref(),
            weights.as_ref(),
            whole,
            Par::Seq,
        );
        matrices
    }

    /// S a for the bins of a run, in single precision.
    fn root_products(
        &self,
        rows: &Rows<'_, f32>,
        run: &Run,
        frequency: &[f64],
        accelerations: &DMatrix<Complex<f64>>,
    ) -> DMatrix<Complex<f64>> {
        let hz = &frequency[run.bins.clone()];
        let motions = Motions::new(&self.motion(run, frequency, accelerations));
        let matrices = self.matrices(rows, 1, run, frequency);
        let skew = self.is_skew(run);
        let mut products = DMatrix::zeros(self.modes, hz.len());
        for (bin, mut product) in products.column_iter_mut().enumerate() {
            let Some(row) = matrices.col(bin).try_as_col_major() else {
                continue;
            };
            let scale = motions.scale(bin) / (2.0 * PI * hz[bin]);
            let [re, im] = image(self.modes, skew, row.as_slice(), motions.part(bin));
            for (to, (re, im)) in product.iter_mut().zip(re.into_iter().zip(im)) {
                *to = Complex::new(f64::from(re), f64::from(im)) * scale;
            }
        }
        products
    }
}
