//! Resistances in the mean over neighbouring frequencies.

use super::archive::{Archive, ArchiveReader, ArchiveWriter};
use super::resistance::{Resistance, sparse_form};
use super::roots::{apply, hermitian_root};
use crate::error::AcousticsError;
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Real resistances of every patch at a few rising frequencies, each the mean over a range around its own; between them
/// linear in the logarithm of frequency, constant beyond the first and the last:
///
/// ```text
/// R(f) = sum_n h_n(ln f) R_n        h_n >= 0, sum_n h_n = 1
/// ```
///
/// so that R stays positive semidefinite, and no more than two of them count at a frequency.
#[derive(Debug, Clone)]
pub(crate) struct Means {
    hz: Vec<f64>,
    /// Node by node, every patch.
    patches: Vec<Vec<Resistance>>,
    /// Root of all patches together, node by node.
    roots: Vec<DMatrix<f64>>,
}

impl Means {
    /// From nodes that rise; at least one.
    pub(crate) fn new(nodes: Vec<(f64, Vec<Resistance>)>) -> Self {
        let (hz, patches): (Vec<f64>, Vec<Vec<Resistance>>) = nodes.into_iter().unzip();
        // As files keep them: a result does not depend on whether they were kept.
        let patches: Vec<Vec<Resistance>> = patches
            .into_iter()
            .map(|node| node.into_iter().map(Resistance::single).collect())
            .collect();
        let roots = patches
            .par_iter()
            .map(|node| hermitian_root(&sum(node)).single().real)
            .collect();
        Self { hz, patches, roots }
    }

    /// Where they are known \[Hz\].
    pub(crate) fn hz(&self) -> &[f64] {
        &self.hz
    }

    /// Weights h_n of the nodes that count at a frequency, each with its number.
    pub(crate) fn weights(&self, hz: f64) -> impl Iterator<Item = (usize, f64)> + use<> {
        let above = self.hz.partition_point(|node| *node <= hz);
        let pair = match above {
            0 => [(0, 1.0), (0, 0.0)],
            n if n == self.hz.len() => [(n - 1, 1.0), (0, 0.0)],
            n => {
                let t = (hz / self.hz[n - 1]).ln() / (self.hz[n] / self.hz[n - 1]).ln();
                [(n - 1, 1.0 - t), (n, t)]
            }
        };
        pair.into_iter().filter(|(_, weight)| *weight > 0.0)
    }

    /// R of the whole surface.
    pub(crate) fn resistance(&self, hz: f64) -> Resistance {
        let mut whole = Resistance::zeros(self.roots.first().map_or(0, DMatrix::nrows));
        for (node, weight) in self.weights(hz) {
            self.patches[node].iter().for_each(|r| whole.add_scaled(weight, r));
        }
        whole
    }

    /// v^T R v of the whole surface for the modes of a real motion v that are not at rest.
    pub(crate) fn sparse_form(&self, hz: f64, v: &[(usize, f64)]) -> f64 {
        let of_node = |(node, weight): (usize, f64)| {
            let entry = |i: usize, j: usize| self.patches[node].iter().map(|r| r.real[(i, j)]).sum::<f64>();
            weight * sparse_form(v, entry)
        };
        self.weights(hz).map(of_node).sum()
    }

    /// Adds `share` times a^H (R_p / omega²) a to every patch's row of `forms`, at all bins (columns).
    pub(crate) fn add_forms(
        &self,
        (frequency, share): (&[f64], &[f64]),
        accelerations: &DMatrix<Complex<f64>>,
        forms: &mut DMatrix<f64>,
    ) {
        for (node, bins) in self.counting(frequency, share).iter().enumerate() {
            let [re, im] = parts_of(accelerations, bins);
            for (p, r) in self.patches[node].iter().enumerate() {
                if r.real.iter().all(|x| *x == 0.0) {
                    continue;
                }
                let (on_re, on_im) = (&r.real * &re, &r.real * &im);
                for (column, (bin, factor)) in bins.iter().enumerate() {
                    let form =
                        re.column(column).dot(&on_re.column(column)) + im.column(column).dot(&on_im.column(column));
                    forms[(p, *bin)] += factor * form;
                }
            }
        }
    }

    /// Adds `share` times (R / omega²) a of the whole surface.
    pub(crate) fn add_images(
        &self,
        (frequency, share): (&[f64], &[f64]),
        accelerations: &DMatrix<Complex<f64>>,
        images: &mut DMatrix<Complex<f64>>,
    ) {
        for (node, bins) in self.counting(frequency, share).iter().enumerate() {
            let part = accelerations.select_columns(bins.iter().map(|(bin, _)| bin));
            let image = apply(&sum(&self.patches[node]).real, &part);
            for (column, (bin, factor)) in image.column_iter().zip(bins) {
                images
                    .column_mut(*bin)
                    .axpy(Complex::from(*factor), &column, Complex::from(1.0));
            }
        }
    }

    /// Signals whose squared sum is `share` times a^H (R / omega²) a: even nodes in `signals[0]`, odd ones in the other,
    /// each modes x bins.
    pub(crate) fn root_signals(
        &self,
        (frequency, share): (&[f64], &[f64]),
        accelerations: &DMatrix<Complex<f64>>,
    ) -> [DMatrix<Complex<f64>>; 2] {
        let mut signals = [0, 1].map(|_| DMatrix::zeros(accelerations.nrows(), frequency.len()));
        for (node, bins) in self.counting(frequency, share).iter().enumerate() {
            let part = accelerations.select_columns(bins.iter().map(|(bin, _)| bin));
            let signal = apply(&self.roots[node], &part);
            for (column, (bin, factor)) in signal.column_iter().zip(bins) {
                let scaled = column * Complex::from(factor.sqrt());
                signals[node % 2].set_column(*bin, &scaled);
            }
        }
        signals
    }

    /// For every node the bins at which it counts, with its weight there times the share over omega².
    fn counting(&self, frequency: &[f64], share: &[f64]) -> Vec<Vec<(usize, f64)>> {
        let mut bins = vec![Vec::new(); self.hz.len()];
        for (bin, (&hz, &share)) in frequency.iter().zip(share).enumerate().filter(|(_, (_, s))| **s > 0.0) {
            for (node, weight) in self.weights(hz) {
                bins[node].push((bin, share * weight / (2.0 * PI * hz).powi(2)));
            }
        }
        bins
    }
}

fn sum(patches: &[Resistance]) -> Resistance {
    let mut whole = Resistance::zeros(patches.first().map_or(0, |r| r.real.nrows()));
    patches.iter().for_each(|r| whole.add_scaled(1.0, r));
    whole
}

fn parts_of(accelerations: &DMatrix<Complex<f64>>, bins: &[(usize, f64)]) -> [DMatrix<f64>; 2] {
    let part = |of: fn(&Complex<f64>) -> f64| {
        DMatrix::from_fn(accelerations.nrows(), bins.len(), |mode, column| {
            of(&accelerations[(mode, bins[column].0)])
        })
    };
    [part(|a| a.re), part(|a| a.im)]
}

impl Archive for Means {
    fn write(&self, to: &mut ArchiveWriter) {
        to.count(self.roots.first().map_or(0, DMatrix::nrows));
        to.count(self.hz.len());
        to.numbers(&self.hz);
        for (patches, root) in self.patches.iter().zip(&self.roots) {
            to.count(patches.len());
            patches.iter().for_each(|r| to.hermitian(r));
            to.hermitian(&Resistance {
                real: root.clone(),
                imaginary: None,
            });
        }
    }

    fn read(from: &mut ArchiveReader<'_>) -> Result<Self, AcousticsError> {
        let modes = from.count()?;
        let mut hz = Vec::new();
        for _ in 0..from.count()? {
            let [node] = from.numbers()?;
            hz.push(node);
        }
        if hz.is_empty() {
            return Err(from.damaged());
        }
        let (mut patches, mut roots) = (Vec::new(), Vec::new());
        for _ in 0..hz.len() {
            let mut node = Vec::new();
            for _ in 0..from.count()? {
                node.push(from.hermitian(modes)?);
            }
            patches.push(node);
            roots.push(from.hermitian(modes)?.real);
        }
        Ok(Self { hz, patches, roots })
    }
}
