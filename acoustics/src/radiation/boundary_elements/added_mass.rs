//! Added mass of the fluid for the modes, X/omega, as a function of frequency.
//!
//! It is finite at zero frequency and varies only on the scale of ka. A few of the frequencies of R therefore suffice:
//! linear interpolation in the logarithm of frequency, between nodes a quarter of an octave apart, has an error of
//! about 2 %. Outside the range of the nodes the value is constant. Above the highest node this is an upper bound,
//! because the mass decreases there.

use crate::matrix::real_product;
use nalgebra::{Complex, DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Smallest distance between nodes \[octaves\].
const APART: f64 = 0.25;

/// Lower triangle of a symmetric matrix, column by column, in single precision.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct PackedMass {
    modes: usize,
    #[serde(with = "crate::blocks")]
    entries: Vec<f32>,
}

impl PackedMass {
    pub(crate) fn new(mass: &DMatrix<f64>) -> Self {
        let n = mass.nrows();
        Self {
            modes: n,
            entries: (0..n)
                .flat_map(|j| (j..n).map(move |i| (i, j)))
                .map(|at| mass[at] as f32)
                .collect(),
        }
    }

    fn at(&self, i: usize, j: usize) -> f64 {
        let (i, j) = (i.max(j), i.min(j));
        f64::from(self.entries[j * self.modes - j * (j + 1) / 2 + i])
    }
}

/// Masses of every parity at the solved frequencies.
#[derive(Debug, Default)]
pub(crate) struct MassSamples(BTreeMap<u64, Vec<PackedMass>>);

impl MassSamples {
    /// Adds the masses at a frequency \[Hz\]; if two meshes provide them, the later one is used.
    pub(crate) fn insert(&mut self, hz: f64, masses: &[PackedMass]) {
        // Positive numbers are ordered like their bit patterns.
        self.0.insert(hz.to_bits(), masses.to_vec());
    }

    /// Selects some frequencies, and the parities with these numbers.
    pub(crate) fn thinned(self, parities: &[usize]) -> AddedMasses {
        let mut masses = AddedMasses::default();
        let mut from = 0.0;
        let last = self.0.keys().next_back().copied();
        for (bits, of_parities) in self.0 {
            let hz = f64::from_bits(bits);
            if hz >= from || last == Some(bits) {
                from = hz * 2f64.powf(APART);
                masses.hz.push(hz);
                let chosen = parities.iter().filter_map(|&parity| of_parities.get(parity).cloned());
                masses.parities.push(chosen.collect());
            }
        }
        masses
    }
}

/// Masses of every parity at ascending frequencies.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct AddedMasses {
    hz: Vec<f64>,
    /// By frequency and parity.
    parities: Vec<Vec<PackedMass>>,
}

impl AddedMasses {
    /// M v for one parity and a sparse motion, given by its nonzero entries.
    pub(crate) fn product(&self, parity: usize, hz: f64, motion: &[(usize, f64)]) -> DVector<f64> {
        let mut product = DVector::zeros(0);
        for (node, weight) in self.weights(hz) {
            let mass = &self.parities[node][parity];
            if product.is_empty() {
                product = DVector::zeros(mass.modes);
            }
            for &(mode, v) in motion {
                product
                    .iter_mut()
                    .enumerate()
                    .for_each(|(i, to)| *to += weight * v * mass.at(i, mode));
            }
        }
        product
    }

    /// M(f) v for one parity and a motion at each frequency \[Hz\], modes x frequencies.
    pub(crate) fn products(&self, parity: usize, hz: &[f64], motion: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let mut products = DMatrix::zeros(motion.nrows(), motion.ncols());
        let mut of_nodes: BTreeMap<usize, Vec<(usize, f64)>> = BTreeMap::new();
        for (column, &hz) in hz.iter().enumerate() {
            for (node, weight) in self.weights(hz) {
                of_nodes.entry(node).or_default().push((column, weight));
            }
        }
        for (node, columns) in of_nodes {
            let mass = &self.parities[node][parity];
            let mass = DMatrix::from_fn(mass.modes, mass.modes, |i, j| mass.at(i, j));
            let chosen: Vec<usize> = columns.iter().map(|(column, _)| *column).collect();
            let found = real_product(&mass, &motion.select_columns(&chosen));
            for ((column, weight), found) in columns.into_iter().zip(found.column_iter()) {
                products
                    .column_mut(column)
                    .axpy(Complex::from(weight), &found, Complex::from(1.0));
            }
        }
        products
    }

    /// Interpolation nodes with their weights.
    fn weights(&self, hz: f64) -> Vec<(usize, f64)> {
        let above = self.hz.partition_point(|&node| node < hz);
        if above == 0 || above == self.hz.len() {
            return vec![(above.saturating_sub(usize::from(above > 0)), 1.0)];
        }
        let [low, high] = [self.hz[above - 1], self.hz[above]];
        let share = (hz / low).ln() / (high / low).ln();
        vec![(above - 1, 1.0 - share), (above, share)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mass_is_that_of_its_node_and_lies_between_neighbours() {
        let mut samples = MassSamples::default();
        let of = |hz: f64| DMatrix::from_fn(3, 3, |i, j| hz * (1 + i + j) as f64);
        for hz in [100.0, 101.0, 200.0, 210.0] {
            samples.insert(hz, &[PackedMass::default(), PackedMass::new(&of(hz))]);
        }
        let masses = samples.thinned(&[1]);
        assert_eq!(masses.hz, [100.0, 200.0, 210.0]);
        for (hz, expected) in [
            (50.0, 100.0),
            (100.0, 100.0),
            (20_000f64.sqrt(), 150.0),
            (210.0, 210.0),
            (999.0, 210.0),
        ] {
            let found = masses.product(0, hz, &[(2, 1.0)]);
            let exact = DVector::from_fn(3, |i, _| expected * (3 + i) as f64);
            assert!((&found - exact).amax() < 1e-3, "{hz}");
            let unit = DMatrix::from_fn(3, 1, |i, _| Complex::new(0.0, if i == 2 { 1.0 } else { 0.0 }));
            let at_once = masses.products(0, &[hz], &unit).column(0).map(|m| m.im);
            assert!((found - at_once).amax() < 1e-9 * expected, "{hz}");
        }
    }
}
