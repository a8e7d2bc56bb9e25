//! The polynomial through the samples of one interval of the frequency axis.

use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Number of candidate points for the Leja sequence.
const CANDIDATES: usize = 2048;

/// Products of distances whose logarithms differ by less than this count as equal.
const TIE: f64 = 1e-9;

/// Smallest factor by which a round of samples is assumed to reduce the error.
const GAIN: f64 = 0.1;

/// An interval of the frequency axis with samples at the first points of a Leja sequence.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Interval {
    pub(crate) low: f64,
    pub(crate) high: f64,
    /// Indices of its samples, in the order of the sequence.
    pub(crate) nodes: Vec<usize>,
    /// Their frequencies \[Hz\].
    hz: Vec<f64>,
    /// Their barycentric weights.
    weights: Vec<f64>,
    /// Number of final samples that test the interpolant through the preceding ones.
    tests: usize,
}

impl Interval {
    /// Creates an interval with samples at these frequencies \[Hz\], in order.
    pub(super) fn new([low, high]: [f64; 2], nodes: Vec<usize>, hz: Vec<f64>, tests: usize) -> Self {
        let x: Vec<f64> = hz.iter().map(|&hz| scaled([low, high], hz)).collect();
        let weight = |j: usize| {
            let others = x.iter().enumerate().filter(|(i, _)| *i != j);
            // The interval is scaled to a logarithmic capacity of 1/2, so that products remain close to one.
            1.0 / others.map(|(_, xi)| 2.0 * (x[j] - xi)).product::<f64>()
        };
        Self {
            low,
            high,
            weights: (0..x.len()).map(weight).collect(),
            hz,
            nodes,
            tests,
        }
    }

    /// The same interval with only its first samples.
    fn with_first(&self, count: usize, tests: usize) -> Self {
        let (nodes, hz) = (self.nodes[..count].to_vec(), self.hz[..count].to_vec());
        Self::new([self.low, self.high], nodes, hz, tests)
    }

    /// Multiplies all frequencies by `by`.
    pub(super) fn stretch(&mut self, by: f64) {
        let ends = [&mut self.low, &mut self.high];
        ends.into_iter().chain(&mut self.hz).for_each(|hz| *hz *= by);
    }

    /// The same samples, with the last `tests` of them as test samples for the others. If all are test samples, they
    /// are compared with zero.
    pub(super) fn tested_by(&self, tests: usize) -> Self {
        Self { tests, ..self.clone() }
    }

    /// The same samples under other indices.
    pub(super) fn with_nodes(&self, nodes: Vec<usize>) -> Self {
        Self { nodes, ..self.clone() }
    }

    /// The interval before its last round of samples, if there were at least two rounds before it.
    pub(super) fn before(&self) -> Option<Self> {
        let fewer = self.nodes.len() - self.tests;
        (fewer > self.tests).then(|| self.with_first(fewer, self.tests))
    }

    /// Frequencies of the samples, in sample order \[Hz\].
    pub(crate) fn samples_hz(&self) -> &[f64] {
        &self.hz
    }

    /// Frequencies of the samples rearranged as a Leja sequence \[Hz\]. It begins with both ends, so that its first few
    /// members also define an interpolant.
    pub(crate) fn samples_in_leja_order(&self) -> Vec<f64> {
        let x: Vec<f64> = self.hz.iter().map(|&hz| scaled([self.low, self.high], hz)).collect();
        let mut left: Vec<usize> = (0..x.len()).collect();
        let mut order: Vec<usize> = Vec::with_capacity(x.len());
        while !left.is_empty() {
            let merit = |i: usize| match order.len() {
                0 => -x[i],
                1 => x[i],
                _ => order.iter().map(|&j| (x[i] - x[j]).abs().ln()).sum(),
            };
            // If two candidates differ only by rounding, the earlier one is taken.
            let better = |best: usize, place: usize| {
                if merit(left[place]) > merit(left[best]) + TIE {
                    place
                } else {
                    best
                }
            };
            let best = (1..left.len()).fold(0, better);
            order.push(left.remove(best));
        }
        order.into_iter().map(|i| self.hz[i]).collect()
    }

    /// Samples that test the others.
    pub(crate) fn test_nodes(&self) -> &[usize] {
        &self.nodes[self.nodes.len() - self.tests..]
    }

    /// Weights of the samples at a frequency \[Hz\]; they sum to one.
    pub(crate) fn weights(&self, hz: f64) -> Vec<f64> {
        if let Some(hit) = self.hz.iter().position(|&node| node == hz) {
            return (0..self.hz.len()).map(|i| f64::from(u8::from(i == hit))).collect();
        }
        let terms: Vec<f64> = self.hz.iter().zip(&self.weights).map(|(x, w)| w / (hz - x)).collect();
        let sum: f64 = terms.iter().sum();
        terms.into_iter().map(|t| t / sum).collect()
    }

    /// Differences between the test samples and the interpolant through the others: weights of all samples for each.
    pub(crate) fn defects(&self) -> Vec<Vec<f64>> {
        let count = self.nodes.len();
        let others = self.with_first(count - self.tests, 0);
        let defect = |j: usize| {
            let own = others.weights(self.hz[j]);
            let mut weights: Vec<f64> = own.into_iter().map(|w| -w).collect();
            weights.resize(count, 0.0);
            weights[j] = 1.0;
            weights
        };
        (count - self.tests..count).map(defect).collect()
    }
}

/// Estimated error including the samples of a round, given the misfit `found` without them and the misfit one round
/// before. Each round is assumed to reduce the error by the same factor as the previous one, but by no more than
/// [`GAIN`]. An exact result has no error.
pub(super) fn extrapolated(found: f64, before: Option<f64>) -> f64 {
    match before {
        Some(before) if found > 0.0 => found * (found / before).clamp(GAIN, 1.0),
        _ => found,
    }
}

/// Largest number of samples in an interval.
pub(super) const MOST: usize = 96;

/// Leja sequence on \[-1, 1\] (Leja 1957): each point maximises the product of the distances to the previous ones. Each
/// sample raises the order of the polynomial by one, and all earlier samples are reused.
fn leja() -> &'static [f64] {
    static POINTS: LazyLock<Vec<f64>> = LazyLock::new(|| leja_from(Vec::new(), MOST));
    &POINTS
}

/// Leja sequence of `count` points that begins with the given ones.
fn leja_from(mut points: Vec<f64>, count: usize) -> Vec<f64> {
    let at = |i: usize| -(PI * i as f64 / CANDIDATES as f64).cos();
    let distance = |i: usize, x: f64| (at(i) - x).abs().ln();
    let mut product: Vec<f64> = (0..=CANDIDATES)
        .map(|i| points.iter().map(|&x| distance(i, x)).sum())
        .collect();
    while points.len() < count {
        let best = match points.len() {
            0 => 0,
            _ => (0..=CANDIDATES).fold(0, |best, i| if product[i] > product[best] { i } else { best }),
        };
        let x = at(best);
        for (i, p) in product.iter_mut().enumerate() {
            *p += distance(i, x);
        }
        points.push(x);
    }
    points
}

/// Position of a frequency in an interval scaled to \[-1, 1\].
fn scaled([low, high]: [f64; 2], hz: f64) -> f64 {
    ((hz - low) - (high - hz)) / (high - low)
}

/// The first frequencies of a Leja sequence on an interval, beginning with `known` ones; the ends are exact.
pub(super) fn leja_hz([low, high]: [f64; 2], known: &[f64], count: usize) -> Vec<f64> {
    let place = |x: &f64| match *x {
        -1.0 => low,
        1.0 => high,
        x => 0.5 * (low + high) + 0.5 * (high - low) * x,
    };
    if known.is_empty() {
        return leja()[..count].iter().map(place).collect();
    }
    let first = &known[..count.min(known.len())];
    if first.len() == count {
        return first.to_vec();
    }
    let points = leja_from(first.iter().map(|&hz| scaled([low, high], hz)).collect(), count);
    first
        .iter()
        .copied()
        .chain(points[first.len()..].iter().map(place))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The right half of an interval with 48 samples, with four more samples.
    fn half() -> Interval {
        let (low, middle, high) = (100.0, 150.0, 200.0);
        let parent = leja_hz([low, high], &[], 48);
        let known: Vec<f64> = parent.into_iter().filter(|hz| *hz >= middle).collect();
        let hz = leja_hz([middle, high], &known, known.len() + 4);
        assert_eq!(hz[..known.len()], known);
        Interval::new([middle, high], (0..hz.len()).collect(), hz, 4)
    }

    #[test]
    fn the_first_samples_in_leja_order_are_the_ends_and_the_middle() {
        let half = half();
        let first = &half.samples_in_leja_order()[..3];
        for (hz, expected) in first.iter().zip([150.0, 200.0, 175.0]) {
            assert!((hz - expected).abs() < 3.0, "{hz} Hz instead of {expected} Hz");
        }
    }

    #[test]
    fn the_sequence_of_a_whole_interval_is_in_leja_order() {
        let hz = leja_hz([40.0, 143.0], &[], 24);
        let whole = Interval::new([40.0, 143.0], (0..24).collect(), hz.clone(), 4);
        assert_eq!(whole.samples_in_leja_order(), hz);
    }

    #[test]
    fn a_half_with_known_samples_reproduces_a_polynomial_of_its_order() {
        let half = half();
        let polynomial = |hz: f64| {
            (0..half.hz.len())
                .map(|n| scaled([150.0, 200.0], hz).powi(n as i32))
                .sum::<f64>()
        };
        for hz in [150.3, 163.0, 187.7, 199.9] {
            let found: f64 = half
                .weights(hz)
                .iter()
                .zip(&half.hz)
                .map(|(w, &x)| w * polynomial(x))
                .sum();
            assert!((found / polynomial(hz) - 1.0).abs() < 1e-6, "{hz} Hz: {found}");
        }
    }
}
