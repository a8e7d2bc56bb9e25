//! Polynomials through the samples of an interval of the frequency axis.

use super::packed;
use super::resistance::Resistance;
use crate::error::AcousticsError;
use nalgebra::{Complex, DMatrix};
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Orders of the nested Chebyshev-Lobatto rules tried on an interval before it is halved.
pub(super) const ORDERS: [usize; 4] = [4, 8, 16, 32];

/// Most that a round of samples is trusted to have gained.
const GAIN: f64 = 0.1;

/// Points among which Leja's sequence chooses.
const CANDIDATES: usize = 2048;

/// Points of the sequence that are kept: as many as one interval has.
const USUALLY: usize = 64;

/// An interval of the frequency axis with its samples.
#[derive(Debug, Clone)]
pub(super) struct Interval {
    pub(super) low: f64,
    pub(super) high: f64,
    /// Numbers of its samples.
    pub(super) nodes: Vec<usize>,
    /// Their frequencies \[Hz\].
    hz: Vec<f64>,
    /// Their barycentric weights.
    weights: Vec<f64>,
    /// Samples at the end of Leja's sequence on which the interpolant without them was tried; 0 on Chebyshev's nodes.
    pub(super) tried: usize,
}

impl Interval {
    /// On the Chebyshev-Lobatto nodes, rising.
    pub(super) fn chebyshev(low: f64, high: f64, nodes: Vec<usize>) -> Self {
        let order = nodes.len() - 1;
        let weight = |i: usize| {
            let sign = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
            sign * if i == 0 || i == order { 0.5 } else { 1.0 }
        };
        Self {
            low,
            high,
            hz: lobatto(low, high, order).collect(),
            weights: (0..=order).map(weight).collect(),
            nodes,
            tried: 0,
        }
    }

    /// On the first points of Leja's sequence, in its order.
    pub(super) fn leja(low: f64, high: f64, nodes: Vec<usize>, tried: usize) -> Self {
        let x = leja(nodes.len());
        let weight = |j: usize| {
            let others = x.iter().enumerate().filter(|(i, _)| *i != j);
            // The interval's logarithmic capacity is 1/2: products stay near one.
            1.0 / others.map(|(_, xi)| 2.0 * (x[j] - xi)).product::<f64>()
        };
        Self {
            low,
            high,
            hz: x.iter().map(|x| place(low, high, *x)).collect(),
            weights: (0..x.len()).map(weight).collect(),
            nodes,
            tried,
        }
    }

    /// As read from a file.
    pub(super) fn kept(low: f64, high: f64, nodes: Vec<usize>, tried: usize) -> Option<Self> {
        match tried {
            0 if nodes.len().checked_sub(1).is_some_and(|order| ORDERS.contains(&order)) => {
                Some(Self::chebyshev(low, high, nodes))
            }
            1.. if tried < nodes.len() => Some(Self::leja(low, high, nodes, tried)),
            _ => None,
        }
    }

    /// With all frequencies times `by`.
    pub(super) fn stretched(&self, by: f64) -> Self {
        let (low, high, nodes) = (by * self.low, by * self.high, self.nodes.clone());
        match self.tried {
            0 => Self::chebyshev(low, high, nodes),
            tried => Self::leja(low, high, nodes, tried),
        }
    }

    /// Frequencies of its samples \[Hz\], in their order.
    pub(super) fn samples_hz(&self) -> &[f64] {
        &self.hz
    }

    /// The interval before the samples on which it was tried.
    fn before(&self) -> Self {
        let fewer = self.nodes.len() - self.tried;
        Self::leja(self.low, self.high, self.nodes[..fewer].to_vec(), 0)
    }

    /// The interval one round of samples ago, if there were others before.
    pub(super) fn sooner(&self) -> Option<Self> {
        let fewer = self.nodes.len() - self.tried;
        let known = self.tried > 0 && fewer > self.tried;
        known.then(|| Self::leja(self.low, self.high, self.nodes[..fewer].to_vec(), self.tried))
    }

    /// Weights of the samples at the frequency `hz` (they sum to one).
    pub(super) fn weights(&self, hz: f64) -> Vec<f64> {
        if let Some(hit) = self.hz.iter().position(|&node| node == hz) {
            return (0..self.hz.len()).map(|i| f64::from(u8::from(i == hit))).collect();
        }
        let terms: Vec<f64> = self.hz.iter().zip(&self.weights).map(|(x, w)| w / (hz - x)).collect();
        let sum: f64 = terms.iter().sum();
        terms.into_iter().map(|t| t / sum).collect()
    }

    /// What `part` gives at the samples, interpolated to the frequency of each of its columns.
    pub(super) fn blend(
        &self,
        frequency: &[f64],
        part: impl Fn(usize) -> DMatrix<Complex<f64>>,
    ) -> DMatrix<Complex<f64>> {
        let weights: Vec<Vec<f64>> = frequency.iter().map(|&hz| self.weights(hz)).collect();
        let parts = self.nodes.iter().map(|&node| part(node));
        let weighted = parts.enumerate().map(|(n, mut part)| {
            for (mut column, weights) in part.column_iter_mut().zip(&weights) {
                column.iter_mut().for_each(|x| *x *= weights[n]);
            }
            part
        });
        weighted.reduce(|sum, part| sum + part).unwrap_or_default()
    }

    /// What the sample at node j adds to the Chebyshev coefficient of order k.
    fn coefficient(&self, j: usize, k: usize) -> f64 {
        let order = self.nodes.len() - 1;
        let end = if j == 0 || j == order { 0.5 } else { 1.0 };
        let cosine = (PI * ((j * k) % (2 * order)) as f64 / order as f64).cos();
        2.0 / order as f64 * end * cosine
    }

    /// Combinations of the samples that measure the error, as weights by position in `nodes`: on Chebyshev's nodes the
    /// last two coefficients, whose magnitudes add up, beyond which those of an analytic function fall geometrically or
    /// faster; on Leja's the differences between the samples tried and the interpolant without them.
    pub(super) fn defects(&self) -> Vec<Vec<f64>> {
        let count = self.nodes.len();
        if self.tried == 0 {
            let order = count - 1;
            let coefficient = |k: usize| (0..count).map(|j| self.coefficient(j, k)).collect();
            return vec![coefficient(order), coefficient(order - 1)];
        }
        let before = self.before();
        let defect = |j: usize| {
            let mut weights = before.weights(self.hz[j]);
            weights.iter_mut().for_each(|w| *w = -*w);
            weights.resize(count, 0.0);
            weights[j] = 1.0;
            weights
        };
        (count - self.tried..count).map(defect).collect()
    }

    /// Adds up the defects' magnitudes, or takes the largest: see [`Interval::defects`].
    pub(super) fn together(&self, sizes: impl Iterator<Item = f64>) -> f64 {
        if self.tried == 0 {
            sizes.sum()
        } else {
            sizes.fold(0.0, f64::max)
        }
    }

    /// Estimated interpolation error of all patches together on Chebyshev's nodes, relative to the interval's least
    /// sqrt(Q_ii Q_jj). What patches exchange among themselves does not reach the level. `whole` is the sum over the
    /// patches of a sample as a row of a packed matrix, and what it is to be multiplied by.
    pub(super) fn error<'a>(&self, whole: impl Fn(usize) -> (&'a [f64], f64), modes: usize, floor: f64) -> f64 {
        let samples: Vec<(&[f64], f64)> = self.nodes.iter().map(|&node| whole(node)).collect();
        let mut least = vec![f64::INFINITY; modes];
        for (row, factor) in &samples {
            let diagonal = packed::diagonal(modes, row).map(|q| factor * q).collect();
            least
                .iter_mut()
                .zip(scales(diagonal, floor))
                .for_each(|(s, q)| *s = s.min(q));
        }
        let length = samples.iter().map(|(row, _)| row.len()).max().unwrap_or(0);
        let defect = |weights: Vec<f64>| {
            let mut defect = vec![0.0; length];
            for ((row, factor), weight) in samples.iter().zip(weights) {
                let weight = weight * factor;
                defect.iter_mut().zip(*row).for_each(|(d, q)| *d += weight * q);
            }
            defect
        };
        let defects: Vec<Vec<f64>> = self.defects().into_iter().map(defect).collect();
        let size = |entry: usize| self.together(defects.iter().map(|defect| defect[entry].abs()));
        packed::largest(&least, length, size)
    }

    /// How far the samples tried are from the interpolant without them: for each the squares of two Frobenius norms,
    /// of the defect of `value` and of the resistance `whole`, both with modes scaled to the same radiated power,
    ///
    /// ```text
    /// ||S D S||^2, ||S Q S||^2        S_ii = Q_ii^-1/2, no smaller resistance counted than `floor` of the largest
    /// ```
    ///
    /// Their ratio is the mean square error of one mode's energy where modes are many and radiate independently.
    pub(super) fn misfits(
        &self,
        value: impl Fn(usize) -> Resistance,
        whole: impl Fn(usize) -> Resistance,
        floor: f64,
    ) -> Vec<[f64; 2]> {
        let values: Vec<Resistance> = self.nodes.iter().map(|&node| value(node)).collect();
        let tried = &self.nodes[self.nodes.len() - self.tried..];
        let misfit = |(weights, &node): (&Vec<f64>, &usize)| {
            let (defect, whole) = (weighted(&values, weights), whole(node));
            let scale = scales(whole.real.diagonal().iter().copied().collect(), floor);
            [scaled_norm(&defect, &scale), scaled_norm(&whole, &scale)]
        };
        self.defects().iter().zip(tried).map(misfit).collect()
    }
}

/// Error with a round's samples, from the misfit `found` without them and the one a round before: what a round gains, a
/// factor of ten at the most.
pub(super) fn gained(found: f64, previous: Option<f64>) -> f64 {
    found * previous.map_or(1.0, |previous| (found / previous).clamp(GAIN, 1.0))
}

/// Roots of a diagonal, none smaller than that of `floor` times the largest.
fn scales(diagonal: Vec<f64>, floor: f64) -> Vec<f64> {
    let floor = floor * diagonal.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    diagonal.into_iter().map(|q| q.max(floor).sqrt()).collect()
}

fn weighted(samples: &[Resistance], weights: &[f64]) -> Resistance {
    let mut sum = Resistance::zeros(samples.first().map_or(0, |s| s.real.nrows()));
    for (sample, weight) in samples.iter().zip(weights) {
        sum.add_scaled(*weight, sample);
    }
    sum
}

/// Square of the Frobenius norm with rows and columns divided by `scale`.
fn scaled_norm(r: &Resistance, scale: &[f64]) -> f64 {
    let norm = |m: &DMatrix<f64>| {
        let columns = m.column_iter().zip(scale);
        let squares = columns.map(|(column, sj)| {
            let entries = column.iter().zip(scale);
            entries.map(|(x, si)| (x / (si * sj)).powi(2)).sum::<f64>()
        });
        squares.sum::<f64>()
    };
    norm(&r.real) + r.imaginary.as_ref().map_or(0.0, norm)
}

/// Chebyshev-Lobatto nodes of \[low, high\], rising; the ends are exact.
pub(super) fn lobatto(low: f64, high: f64, order: usize) -> impl Iterator<Item = f64> {
    // The finest order's index makes nested rules agree bit for bit.
    let finest = ORDERS[ORDERS.len() - 1];
    (0..=order).map(move |i| match i {
        0 => low,
        i if i == order => high,
        i => 0.5 * (low + high) - 0.5 * (high - low) * (PI * (i * (finest / order)) as f64 / finest as f64).cos(),
    })
}

/// The first points of Leja's sequence on \[-1, 1\] (Leja 1957): each where the product of the distances to those before
/// is largest, so that a polynomial gains one order a sample and no sample is wasted.
fn leja(count: usize) -> Vec<f64> {
    // Every sequence begins a longer one.
    static USUAL: LazyLock<Vec<f64>> = LazyLock::new(|| sequence(USUALLY));
    match USUAL.get(..count) {
        Some(points) => points.to_vec(),
        None => sequence(count),
    }
}

fn sequence(count: usize) -> Vec<f64> {
    let at = |i: usize| -(PI * i as f64 / CANDIDATES as f64).cos();
    let mut product = vec![0.0; CANDIDATES + 1];
    let mut points: Vec<f64> = Vec::with_capacity(count);
    for next in 0..count {
        let best = match next {
            0 => 0,
            1 => CANDIDATES,
            _ => (0..=CANDIDATES).fold(0, |best, i| if product[i] > product[best] { i } else { best }),
        };
        let x = at(best);
        for (i, p) in product.iter_mut().enumerate() {
            *p += (at(i) - x).abs().ln();
        }
        points.push(x);
    }
    points
}

fn place(low: f64, high: f64, x: f64) -> f64 {
    match x {
        -1.0 => low,
        1.0 => high,
        x => 0.5 * (low + high) + 0.5 * (high - low) * x,
    }
}

/// The first frequencies of Leja's sequence on \[low, high\].
pub(super) fn leja_hz(low: f64, high: f64, count: usize) -> Vec<f64> {
    leja(count).into_iter().map(|x| place(low, high, x)).collect()
}

/// Whether a range can be sampled.
pub(super) fn check_range([low, high]: [f64; 2]) -> Result<(), AcousticsError> {
    if low > 0.0 && high > low && high.is_finite() {
        return Ok(());
    }
    Err(AcousticsError::Range {
        low,
        high,
        nyquist: f64::INFINITY,
    })
}
