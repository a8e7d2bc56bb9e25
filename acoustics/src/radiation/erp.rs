use super::hermitian_root::hermitian_root;
use super::operator::ModalRadiation;
use super::packed::{Motions, PackedHermitian};
use super::products::forms;
use super::resistance::Resistance;
use super::sampled::sum_of_names;
use super::surface::RadiatingSurface;
use crate::air::Air;
use crate::matrix::real_product;
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::sync::OnceLock;

/// Equivalent radiated power: every point radiates as in a plane wave.
///
/// ```text
/// R = rho0 c0 Phi_n^T S Phi_n
/// ```
///
/// This is the high-frequency limit and the sigma = 1 reference. It is not a bound: sigma reaches 1.8 near coincidence,
/// while at low frequencies the equivalent radiated power is too high by orders of magnitude.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Erp {
    patches: Vec<String>,
    #[serde(with = "crate::blocks")]
    resistances: Vec<DMatrix<f64>>,
    /// Packed matrices for the quadratic forms, and the root of the sum over patches; computed on first use.
    #[serde(skip)]
    packed: OnceLock<PackedHermitian>,
    #[serde(skip)]
    root: OnceLock<DMatrix<f64>>,
}

impl Erp {
    /// The equivalent radiated power of a surface of any shape.
    pub fn new(surface: &RadiatingSurface, air: &Air) -> Self {
        let of_patch = |p: usize| {
            let part = surface.filtered(|i| surface.patch()[i] == p);
            let mut weighted = part.normal_modes().clone();
            for (row, weight) in part.weights().iter().enumerate() {
                weighted.row_mut(row).scale_mut(air.impedance() * weight);
            }
            // nalgebra's `tr_mul` works column by column, whereas its product is blocked.
            part.normal_modes().transpose() * weighted
        };
        let resistances = (0..surface.patch_names().len()).map(of_patch).collect();
        Self::of(surface.patch_names().to_vec(), resistances)
    }

    fn of(patches: Vec<String>, resistances: Vec<DMatrix<f64>>) -> Self {
        Self {
            patches,
            resistances,
            packed: OnceLock::new(),
            root: OnceLock::new(),
        }
    }

    /// Adds a patch that radiates nothing, so that two operators have the same patches.
    #[must_use]
    pub(crate) fn with_silent_patch(mut self, name: &str) -> Self {
        let modes = self.modes();
        self.patches.push(name.to_owned());
        self.resistances.push(DMatrix::zeros(modes, modes));
        Self::of(self.patches, self.resistances)
    }

    /// Combines the first `count` patches into one called `name`.
    #[must_use]
    pub(crate) fn with_sum_of_patches(&self, count: usize, name: &str) -> Self {
        let modes = self.modes();
        let (first, others) = self.resistances.split_at(count.min(self.resistances.len()));
        let sum = first.iter().fold(DMatrix::zeros(modes, modes), |sum, r| sum + r);
        let resistances = std::iter::once(sum).chain(others.iter().cloned()).collect();
        Self::of(sum_of_names(&self.patches, count, name), resistances)
    }

    fn packed(&self) -> &PackedHermitian {
        self.packed.get_or_init(|| {
            let of_patch = |r: &DMatrix<f64>| Resistance {
                real: r.clone(),
                imaginary: None,
            };
            let resistances: Vec<Resistance> = self.resistances.iter().map(of_patch).collect();
            PackedHermitian::new(self.modes(), resistances.iter())
        })
    }

    /// R does not depend on frequency, so a single root suffices.
    fn root(&self) -> &DMatrix<f64> {
        self.root.get_or_init(|| hermitian_root(&self.resistance(0.0)).real)
    }
}

impl ModalRadiation for Erp {
    fn method(&self) -> &str {
        "ERP"
    }

    fn modes(&self) -> usize {
        self.resistances.first().map_or(0, DMatrix::ncols)
    }

    fn patches(&self) -> &[String] {
        &self.patches
    }

    fn highest_hz(&self) -> f64 {
        f64::INFINITY
    }

    fn resistance(&self, _hz: f64) -> Resistance {
        let mut whole = Resistance::zeros(self.modes());
        self.resistances.iter().for_each(|r| whole.real += r);
        whole
    }

    fn energy_forms(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<f64> {
        const CHUNK: usize = 64;
        let of_chunk = |first: usize| {
            let bins = CHUNK.min(frequency.len() - first);
            let motions = Motions::new(&accelerations.columns(first, bins).into_owned());
            let found = forms(&[self.packed()], &motions);
            DMatrix::from_fn(self.resistances.len(), bins, |p, b| {
                found[p * bins + b] * (motions.scale(b) / (2.0 * PI * frequency[first + b])).powi(2)
            })
        };
        let starts: Vec<usize> = (0..frequency.len()).step_by(CHUNK).collect();
        let chunks: Vec<DMatrix<f64>> = starts.par_iter().map(|&first| of_chunk(first)).collect();
        let mut all = DMatrix::zeros(self.resistances.len(), frequency.len());
        for (first, chunk) in starts.into_iter().zip(&chunks) {
            all.columns_mut(first, chunk.ncols()).copy_from(chunk);
        }
        all
    }

    fn sparse_forms(&self, motions: &[(f64, Vec<(usize, f64)>)]) -> Vec<f64> {
        let whole = self.resistance(0.0);
        motions.iter().map(|(_, v)| whole.sparse_form(v)).collect()
    }

    fn images(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let mut images = real_product(&self.resistance(0.0).real, accelerations);
        for (mut bin, hz) in images.column_iter_mut().zip(frequency) {
            bin /= Complex::from((2.0 * PI * hz).powi(2));
        }
        images
    }

    fn root_signals(&self, frequency: &[f64], accelerations: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let mut signals = real_product(self.root(), accelerations);
        for (mut bin, hz) in signals.column_iter_mut().zip(frequency) {
            bin /= Complex::from(2.0 * PI * hz);
        }
        signals
    }
}
