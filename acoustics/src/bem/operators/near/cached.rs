//! Matrices of expensive pairs, interpolated over the wavenumber.

use super::matrices::PairMatrices;
use rustfft::num_complex::Complex;
use std::f64::consts::PI;

/// Number of interpolation nodes.
pub(super) const KEPT: usize = 5;

/// Matrices of expensive pairs at [`KEPT`] wavenumbers.
///
/// ```text
/// M(k) = e^{-jkr_0} sum_n l_n(k) e^{jk_n r_0} M(k_n)        r_0: distance of the panels' centres
/// ```
///
/// Without the phase of r_0, the kernels vary as e^{-jk(r - r_0)}, where |r - r_0| is less than the sum s of the
/// panels' radii. The error is therefore less than 2 (k_max s / 4)^N / N!, which is 1e-4 at six panels per wavelength.
/// The measured error is a hundredth of that.
#[derive(Debug)]
pub(super) struct CachedPairs {
    highest: f64,
    nodes: [f64; KEPT],
    pub(super) matrices: Vec<[PairMatrices; KEPT]>,
}

impl CachedPairs {
    /// An empty set for wavenumbers up to `highest` \[1/m\].
    pub(super) fn up_to(highest: f64) -> Self {
        let node = |n: usize| 0.5 * highest * (1.0 - (PI * (n as f64 + 0.5) / KEPT as f64).cos());
        Self {
            highest,
            nodes: std::array::from_fn(node),
            matrices: Vec::new(),
        }
    }

    pub(super) fn covers(&self, k: f64) -> bool {
        k <= self.highest * (1.0 + 1e-9)
    }

    /// Matrices of a pair at the nodes; `apart` is the distance between the panel centres \[m\], and `at` evaluates M
    /// at a wavenumber.
    pub(super) fn at_nodes(&self, apart: f64, at: impl Fn(f64, &mut PairMatrices)) -> [PairMatrices; KEPT] {
        self.nodes.map(|k| {
            let (mut raw, mut turned) = (PairMatrices::default(), PairMatrices::default());
            at(k, &mut raw);
            turned.add_scaled(Complex::from_polar(1.0, k * apart), &raw);
            turned
        })
    }

    /// Adds M(k) of a pair.
    pub(super) fn add(&self, number: usize, apart: f64, k: f64, out: &mut PairMatrices) {
        let turn = Complex::from_polar(1.0, -k * apart);
        for (weight, matrices) in self.weights(k).iter().zip(&self.matrices[number]) {
            out.add_scaled(turn * weight, matrices);
        }
    }

    /// Barycentric weights of the Chebyshev nodes at k; they sum to one.
    fn weights(&self, k: f64) -> [f64; KEPT] {
        if let Some(hit) = self.nodes.iter().position(|node| *node == k) {
            return std::array::from_fn(|n| f64::from(u8::from(n == hit)));
        }
        let term = |n: usize| {
            let sine = (PI * (n as f64 + 0.5) / KEPT as f64).sin();
            let sign = if n.is_multiple_of(2) { 1.0 } else { -1.0 };
            sign * sine / (k - self.nodes[n])
        };
        let terms: [f64; KEPT] = std::array::from_fn(term);
        let sum: f64 = terms.iter().sum();
        terms.map(|t| t / sum)
    }
}
