//! Information gained by a further measurement, from draws and their outputs, without another simulation.
//!
//! A measurement with the error s is made on each draw j in turn, y_j = f_j + s e_j. The other draws, weighted by the
//! density of (y_j - f_i)/s, are then draws from the posterior with that reading (importance sampling; a preposterior
//! analysis as in Raiffa and Schlaifer, "Applied statistical decision theory", 1961). The value of the measurement is
//! the mean gain over j: a narrower interval, or a more certain order of the sources.

use crate::likelihood::ErrorLaw;
use crate::random::Stream;
use crate::statistics::{effective_size, quantile_of, weighted_quantile};

/// Ends of the interval that becomes narrower.
const ENDS: [f64; 2] = [0.05, 0.95];

/// Maximum number of draws on which the measurement is made.
const MOST: usize = 256;

/// Minimum effective number of draws after a measurement. A more precise measurement is weighed with a larger error
/// that leaves this number; its gain is then a lower bound.
const FEW: f64 = 20.0;

/// Most doublings of an error for that.
const DOUBLINGS: u32 = 60;

/// A measurement that could be made.
#[derive(Debug, Clone, Copy)]
pub struct Further<'a> {
    /// Its reading f in each draw; NaN if there is no reading.
    pub predictions: &'a [f64],
    /// s, the standard deviation of its error including that of the model, in the unit of the predictions; above 0.
    pub scale: f64,
    /// Law of the error by which the reading would be weighed.
    pub law: ErrorLaw,
}

/// Outputs of the draws.
#[derive(Debug, Clone, Copy)]
pub struct Outputs<'a> {
    /// The output whose interval is of interest, in each draw.
    pub output: &'a [f64],
    /// Number of the source that is first in each draw.
    pub first: &'a [usize],
}

/// The value of a measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gain {
    /// Width between P5 and P95 of the output now, and the mean width with the measurement, in the unit of the output.
    pub width: [f64; 2],
    /// Probability of the source that is most likely to be first: now, and the mean with the measurement.
    pub first: [f64; 2],
    /// Whether there are too few draws for such a precise measurement. The gain is then a lower bound.
    pub is_bound: bool,
}

/// The value of a measurement; none with fewer than two draws that have a prediction.
pub fn gain(further: Further<'_>, outputs: Outputs<'_>, seed: u64) -> Option<Gain> {
    let known: Vec<usize> = (0..further.predictions.len())
        .filter(|&k| further.predictions[k].is_finite() && outputs.output[k].is_finite())
        .collect();
    if known.len() < 2 {
        return None;
    }
    let values: Vec<f64> = known.iter().map(|&k| outputs.output[k]).collect();
    let first: Vec<usize> = known.iter().map(|&k| outputs.first[k]).collect();
    let predictions: Vec<f64> = known.iter().map(|&k| further.predictions[k]).collect();
    let made = Made {
        predictions: &predictions,
        law: further.law,
        errors: (0..known.len().min(MOST))
            .map(|j| stream(seed).normal(j as u64))
            .collect(),
    };
    let scale = made.scale(further.scale);
    let width = |weights: &[f64]| {
        let [low, high] = ENDS.map(|p| weighted_quantile(&values, weights, p));
        high - low
    };
    let mut sums = [0.0; 2];
    for j in 0..made.errors.len() {
        let weights = made.weights(j, scale);
        sums = [sums[0] + width(&weights), sums[1] + surest(&first, &weights)];
    }
    let equal = vec![1.0; known.len()];
    let [narrower, surer] = sums.map(|sum| sum / made.errors.len() as f64);
    Some(Gain {
        width: [width(&equal), narrower],
        first: [surest(&first, &equal), surer],
        is_bound: scale > further.scale,
    })
}

fn stream(seed: u64) -> Stream {
    Stream::new(seed, &[])
}

/// A measurement made on each of the first draws.
struct Made<'a> {
    predictions: &'a [f64],
    law: ErrorLaw,
    /// e_j.
    errors: Vec<f64>,
}

impl Made<'_> {
    /// Weights of the draws given the reading on draw `j`, which is not counted.
    fn weights(&self, j: usize, scale: f64) -> Vec<f64> {
        let reading = self.predictions[j] + scale * self.errors[j];
        let weight = |(i, f): (usize, &f64)| match i == j {
            true => 0.0,
            false => self.law.log_density((reading - f) / scale).exp(),
        };
        self.predictions.iter().enumerate().map(weight).collect()
    }

    /// The smallest error, not below `scale`, that leaves enough draws. With too few draws, intervals would be too
    /// narrow, so that even an irrelevant measurement would seem informative.
    fn scale(&self, scale: f64) -> f64 {
        let is_enough = |scale: f64| {
            let size = |j| effective_size(&self.weights(j, scale));
            let mut sizes: Vec<f64> = (0..self.errors.len()).map(size).collect();
            quantile_of(&mut sizes, 0.5) >= FEW.min(0.5 * self.predictions.len() as f64)
        };
        let (mut low, mut high) = (scale, scale);
        for _ in 0..DOUBLINGS {
            if is_enough(high) {
                break;
            }
            (low, high) = (high, 2.0 * high);
        }
        while high > 1.05 * low {
            let middle = (low * high).sqrt();
            if is_enough(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        high
    }
}

/// Probability of the source that is most probably first.
fn surest(first: &[usize], weights: &[f64]) -> f64 {
    let total: f64 = weights.iter().sum();
    let mut shares = vec![0.0; first.iter().max().map_or(0, |most| most + 1)];
    first
        .iter()
        .zip(weights)
        .for_each(|(&own, weight)| shares[own] += weight);
    shares.into_iter().fold(0.0, f64::max) / total
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    /// Prediction f and output of jointly normal draws with this squared correlation.
    fn draws(n: usize, squared: f64) -> [Vec<f64>; 2] {
        let stream = |k: usize| Stream::new(11, &[k as u64]);
        let f: Vec<f64> = (0..n).map(|k| stream(k).normal(0)).collect();
        let output = |k: usize| squared.sqrt() * f[k] + (1.0 - squared).sqrt() * stream(k).normal(1);
        [(0..n).map(output).collect(), f.clone()]
    }

    /// For Gaussian draws and errors, the ratio is sqrt(1 - rho^2/(1 + s^2)).
    #[test]
    fn the_width_of_normal_draws_falls_as_the_closed_form_states() {
        const S: f64 = 0.3;
        for squared in [0.3, 0.6, 0.9] {
            let [output, predictions] = draws(512, squared);
            let first = vec![0; output.len()];
            let outputs = Outputs {
                output: &output,
                first: &first,
            };
            let further = Further {
                predictions: &predictions,
                scale: S,
                law: ErrorLaw::Gaussian,
            };
            let gain = gain(further, outputs, 1).unwrap();
            let expected = (1.0 - squared / (1.0 + S * S)).sqrt();
            let ratio = gain.width[1] / gain.width[0];
            assert!(
                (ratio - expected).abs() < 0.05,
                "{squared}: {ratio}, expected {expected}"
            );
            assert!(!gain.is_bound && gain.first == [1.0, 1.0]);
        }
    }

    #[test]
    fn a_measurement_of_the_difference_of_two_sources_tells_which_is_first() {
        let [_, difference] = draws(400, 0.0);
        let first: Vec<usize> = difference.iter().map(|own| usize::from(*own > 0.0)).collect();
        let of = |scale: f64| {
            let outputs = Outputs {
                output: &difference,
                first: &first,
            };
            let further = Further {
                predictions: &difference,
                scale,
                law: ErrorLaw::Student,
            };
            gain(further, outputs, 3).unwrap()
        };
        let [sharp, blunt] = [0.1, 30.0].map(of);
        assert!(
            (sharp.first[0] - 0.5).abs() < 0.05 && sharp.first[1] > 0.93,
            "{sharp:?}"
        );
        assert!((blunt.first[1] - blunt.first[0]).abs() < 0.02, "{blunt:?}");
        assert!((blunt.width[1] / blunt.width[0] - 1.0).abs() < 0.03, "{blunt:?}");
        assert!(of(1e-3).is_bound);
    }

    /// The few draws near a sharp reading span a narrow interval by chance.
    #[test]
    fn a_sharp_measurement_of_something_irrelevant_is_worth_nothing() {
        let [output, _] = draws(128, 0.0);
        let irrelevant: Vec<f64> = (0..128).map(|k| Stream::new(5, &[k]).normal(9)).collect();
        let first = vec![0; 128];
        let outputs = Outputs {
            output: &output,
            first: &first,
        };
        let further = Further {
            predictions: &irrelevant,
            scale: 1e-6,
            law: ErrorLaw::Student,
        };
        let gain = gain(further, outputs, 1).unwrap();
        assert!(
            gain.is_bound && (gain.width[1] / gain.width[0] - 1.0).abs() < 0.1,
            "{gain:?}"
        );
    }
}
