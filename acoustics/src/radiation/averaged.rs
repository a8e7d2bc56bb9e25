//! Radiation resistances averaged over neighbouring frequencies.

use super::hermitian_root::hermitian_root;
use super::packed::{Motions, PackedHermitian};
use super::products::{forms, real_images};
use super::resistance::Resistance;
use crate::matrix::real_product;
use faer::Mat;
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::ops::Range;

/// Number of bins evaluated together.
const CHUNK: usize = 64;

/// Real resistances of every patch at a few ascending frequencies, each averaged over a band around its frequency.
/// Between these nodes they are linear in the logarithm of frequency; outside they are constant.
///
/// ```text
/// R(f) = sum_n h_n(ln f) R_n        h_n >= 0, sum_n h_n = 1
/// ```
///
/// R thus remains positive semidefinite, and at most two nodes contribute at any frequency.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct AveragedResistance {
    hz: Vec<f64>,
    /// All patches, by node.
    patches: Vec<PackedHermitian>,
    /// Root of the sum over patches, by node.
    roots: Vec<PackedHermitian>,
}

/// Consecutive bins between the same nodes.
struct Run {
    bins: Range<usize>,
    nodes: Range<usize>,
    /// Weight of each node at every bin, times the bin's share divided by omega².
    factors: Vec<Vec<f64>>,
}

impl AveragedResistance {
    /// Creates the resistance from at least one node, in ascending order.
    pub(crate) fn new(nodes: Vec<(f64, Vec<Resistance>)>) -> Self {
        let (hz, patches): (Vec<f64>, Vec<Vec<Resistance>>) = nodes.into_iter().unzip();
        let modes = |node: &[Resistance]| node.first().map_or(0, |r| r.real.nrows());
        let patches: Vec<PackedHermitian> = patches
            .iter()
            .map(|node| PackedHermitian::new(modes(node), node.iter()))
            .collect();
        // Computed from the stored precision, so that results do not depend on whether they were stored.
        let roots = patches
            .par_iter()
            .map(|node| PackedHermitian::new(node.modes(), std::iter::once(&hermitian_root(&node.sum(1.0)))))
            .collect();
        Self { hz, patches, roots }
    }

    /// Combines the first `count` patches into one.
    #[must_use]
    pub(crate) fn with_sum_of_patches(&self, count: usize) -> Self {
        Self {
            hz: self.hz.clone(),
            patches: self.patches.iter().map(|node| node.with_sum_of(count)).collect(),
            roots: self.roots.clone(),
        }
    }

    /// Frequencies of the nodes \[Hz\].
    pub(crate) fn hz(&self) -> &[f64] {
        &self.hz
    }

    /// Nonzero weights h_n at a frequency, each with the index of its node.
    fn weights(&self, hz: f64) -> impl Iterator<Item = (usize, f64)> + use<> {
        let nodes = self.nodes(hz);
        let t = match self.hz[nodes.clone()] {
            [low, high] => (hz / low).ln() / (high / low).ln(),
            _ => 0.0,
        };
        nodes.zip([1.0 - t, t])
    }

    /// The nodes around a frequency: two, or only the first or last one outside their range.
    fn nodes(&self, hz: f64) -> Range<usize> {
        let above = self.hz.partition_point(|node| *node <= hz);
        above.saturating_sub(1)..self.hz.len().min(above + 1)
    }

    /// R of the complete surface.
    pub(crate) fn resistance(&self, hz: f64) -> Resistance {
        let mut whole = Resistance::zeros(self.modes());
        for (node, weight) in self.weights(hz) {
            whole.add_scaled(1.0, &self.patches[node].sum(weight));
        }
        whole
    }

    /// v^T R v of the complete surface for a sparse real motion v, given by its nonzero entries.
    pub(crate) fn sparse_form(&self, hz: f64, v: &[(usize, f64)]) -> f64 {
        let of_node = |(node, weight): (usize, f64)| weight * self.patches[node].sparse_form(v);
        self.weights(hz).map(of_node).sum()
    }

    /// Adds `share` times a^H (R_p / omega²) a to the row of each patch in `forms`, for all bins (columns).
    pub(crate) fn add_forms(
        &self,
        (frequency, share): (&[f64], &[f64]),
        accelerations: &DMatrix<Complex<f64>>,
        to: &mut DMatrix<f64>,
    ) {
        for run in self.runs(frequency, share) {
            let motions = motions(accelerations, &run);
            let nodes: Vec<&PackedHermitian> = self.patches[run.nodes.clone()].iter().collect();
            let mut found = forms(&nodes, &motions).into_iter();
            for (node, factors) in nodes.iter().zip(&run.factors) {
                for p in 0..node.matrices() {
                    let of_bins = run.bins.clone().zip(factors).zip(&mut found).enumerate();
                    for (motion, ((bin, factor), form)) in of_bins {
                        to[(p, bin)] += factor * form * motions.scale(motion).powi(2);
                    }
                }
            }
        }
    }

    /// Adds `share` times (R / omega²) a of the complete surface, in double precision.
    pub(crate) fn add_images(
        &self,
        (frequency, share): (&[f64], &[f64]),
        accelerations: &DMatrix<Complex<f64>>,
        images: &mut DMatrix<Complex<f64>>,
    ) {
        for run in self.runs(frequency, share) {
            let motions = accelerations.columns(run.bins.start, run.bins.len()).into_owned();
            for (node, factors) in self.patches[run.nodes.clone()].iter().zip(&run.factors) {
                let products = real_product(&node.sum(1.0).real, &motions);
                for ((bin, factor), product) in run.bins.clone().zip(factors).zip(products.column_iter()) {
                    images
                        .column_mut(bin)
                        .axpy(Complex::from(*factor), &product, Complex::from(1.0));
                }
            }
        }
    }

    /// Adds signals whose sum of squares is `share` times a^H (R / omega²) a. Signals of odd-numbered nodes are added
    /// to the first half of the rows of `signals`, and those of even-numbered ones to the second half. Each half is
    /// modes x bins.
    pub(crate) fn add_root_signals(
        &self,
        (frequency, share): (&[f64], &[f64]),
        accelerations: &DMatrix<Complex<f64>>,
        signals: &mut DMatrix<Complex<f64>>,
    ) {
        for run in self.runs(frequency, share) {
            let motions = motions(accelerations, &run);
            for (node, factors) in run.nodes.clone().zip(&run.factors) {
                let first = (1 - node % 2) * self.modes();
                let factors: Vec<f64> = factors.iter().map(|factor| factor.sqrt()).collect();
                let root = self.roots[node].dense();
                add(&root, &motions, (&run.bins, &factors), (first, signals));
            }
        }
    }

    /// The runs of all bins with a nonzero share.
    fn runs(&self, frequency: &[f64], share: &[f64]) -> Vec<Run> {
        let mut runs: Vec<Run> = Vec::new();
        for (bin, (&hz, &share)) in frequency.iter().zip(share).enumerate().filter(|(_, (_, s))| **s > 0.0) {
            let nodes = self.nodes(hz);
            let next = |run: &Run| run.nodes == nodes && run.bins.end == bin && run.bins.len() < CHUNK;
            if !runs.last().is_some_and(next) {
                let factors = vec![Vec::new(); nodes.len()];
                let bins = bin..bin;
                runs.push(Run { bins, nodes, factors });
            }
            if let Some(run) = runs.last_mut() {
                run.bins.end = bin + 1;
                let of_nodes = run.factors.iter_mut().zip(self.weights(hz));
                of_nodes.for_each(|(to, (_, weight))| to.push(share * weight / (2.0 * PI * hz).powi(2)));
            }
        }
        runs
    }

    fn modes(&self) -> usize {
        self.roots.first().map_or(0, PackedHermitian::modes)
    }
}

fn motions(accelerations: &DMatrix<Complex<f64>>, run: &Run) -> Motions {
    Motions::new(&accelerations.columns(run.bins.start, run.bins.len()).into_owned())
}

/// Adds a matrix times the motion in some bins, each with a factor, to the rows of `to` starting at `first`.
fn add(
    matrix: &Mat<f32>,
    motions: &Motions,
    (bins, factors): (&Range<usize>, &[f64]),
    (first, to): (usize, &mut DMatrix<Complex<f64>>),
) {
    let [re, im] = real_images(matrix, motions);
    for (motion, (bin, factor)) in bins.clone().zip(factors).enumerate() {
        let factor = factor * motions.scale(motion);
        let parts = re.col(motion).iter().zip(im.col(motion).iter());
        for (to, (re, im)) in to.column_mut(bin).iter_mut().skip(first).zip(parts) {
            *to += Complex::new(f64::from(*re), f64::from(*im)) * factor;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODES: usize = 9;

    fn wave(i: usize, j: usize) -> f64 {
        ((i * 31 + j * 17) as f64 * 0.7).sin()
    }

    /// Three patches at three nodes, all positive semidefinite.
    fn means() -> AveragedResistance {
        let patch = |node: usize, p: usize| {
            let field = DMatrix::from_fn(2 * MODES, MODES, |i, j| wave(i + 5 * node, j + 3 * p));
            Resistance {
                real: field.transpose() * field,
                imaginary: None,
            }
        };
        let node = |n: usize| (1000.0 * 2f64.powi(n as i32), (0..3).map(|p| patch(n, p)).collect());
        AveragedResistance::new((0..3).map(node).collect())
    }

    /// Covers frequencies below the first node, at nodes, between them and above the last, and more bins than are
    /// evaluated together.
    #[test]
    fn forms_images_and_signals_are_those_of_the_resistance() {
        let means = means();
        let between = (0..100).map(|i| 1500.0 + 4.0 * f64::from(i));
        let frequency: Vec<f64> = [500.0, 1000.0, 1001.0]
            .into_iter()
            .chain(between)
            .chain([2000.0, 3000.0, 4000.0, 9000.0])
            .collect();
        let share: Vec<f64> = (0..frequency.len()).map(|bin| (bin % 5) as f64 / 4.0).collect();
        let a = DMatrix::from_fn(MODES, frequency.len(), |i, b| {
            10f64.powi((b % 7) as i32 - 3) * Complex::new(wave(i, b), wave(b, i + 2))
        });
        let mut forms = DMatrix::zeros(3, frequency.len());
        means.add_forms((&frequency, &share), &a, &mut forms);
        let mut images = DMatrix::zeros(MODES, frequency.len());
        means.add_images((&frequency, &share), &a, &mut images);
        let mut signals = DMatrix::zeros(2 * MODES, frequency.len());
        means.add_root_signals((&frequency, &share), &a, &mut signals);
        for (bin, (hz, share)) in frequency.iter().zip(&share).enumerate() {
            let factor = share / (2.0 * PI * hz).powi(2);
            let a = a.column(bin);
            let image = means.resistance(*hz).real.map(Complex::from) * a * Complex::from(factor);
            let form = a.dotc(&image).re;
            let size = image.norm() * a.norm() + f64::MIN_POSITIVE;
            assert!((forms.column(bin).sum() - form).abs() < 1e-6 * size, "{hz} Hz");
            assert!((images.column(bin) - &image).norm() * a.norm() < 1e-6 * size, "{hz} Hz");
            let power: f64 = signals.column(bin).iter().map(Complex::norm_sqr).sum();
            assert!((power - form).abs() < 1e-5 * size, "{hz} Hz: {power:e} {form:e}");
        }
        // Linear in the logarithm of frequency.
        let [low, middle, high] = [1000.0, 1000.0 * 2f64.sqrt(), 2000.0].map(|hz| means.resistance(hz).real);
        assert!((middle - (low + high) * 0.5).norm() < 1e-12 * means.resistance(2000.0).real.norm());
    }

    #[test]
    fn kept_and_read_back_they_are_the_same() {
        let means = means();
        let bytes = postcard::to_stdvec(&means).unwrap();
        let back = postcard::from_bytes(&bytes);
        let back = back
            .ok()
            .map(|back: AveragedResistance| (back.hz, back.patches, back.roots));
        assert_eq!(back, Some((means.hz, means.patches, means.roots)));
        assert!(postcard::from_bytes::<AveragedResistance>(&bytes[..bytes.len() - 4]).is_err());
    }
}
