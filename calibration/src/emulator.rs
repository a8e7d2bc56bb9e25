//! Quadratic emulators of the predictions, with automatic relevance determination.
//!
//! Each prediction is a Gaussian process with the kernel
//!
//! ```text
//! k(x, x') = a (1 + sum_j w_j^2 x_j x_j')^2
//! ```
//!
//! plus noise of variance v, which stands for what no quadratic function explains (Rasmussen and Williams, "Gaussian
//! processes for machine learning" (2006), sections 4.2.2 and 5.1). The relevances w_j, a and v maximise the marginal
//! likelihood times a log-normal density of each w_j. The predictive mean of this kernel is a quadratic polynomial, so
//! that its evaluation costs some hundred operations whatever the number of points.
//!
//! The probability of the observed outcomes is emulated in the same way: the values are 1 where a point has them and -1
//! where it has not (least-squares classification, Rasmussen and Williams, section 6.5). The emulated predictions are
//! further coordinates of this score, since outcomes are often intervals of a predicted quantity.
//!
//! By hand, as a general library of Gaussian processes evaluates the kernel at every training point: a thousand times
//! the cost in the inner loop of the sampler.

mod process;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::likelihood::{Likelihood, Prediction, Reading};
use crate::normal;
use process::{Hyperparameters, Training};

/// Points of a prediction that are fitted: those within this many scales of the reading, but not fewer than
/// `FEWEST_POINTS`; of these the latest `MOST_POINTS`.
const WINDOW: f64 = 10.0;
const FEWEST_POINTS: usize = 300;
const MOST_POINTS: usize = 1000;

/// Number of these points from which the hyperparameters are estimated.
const HYPER_POINTS: usize = 400;

/// Iterations of the first estimate, and of one that continues an earlier estimate.
const FIRST_ITERATIONS: usize = 40;
const FURTHER_ITERATIONS: usize = 10;

/// A coordinate is retained if its linear effect exceeds this share of the standard deviation of the noise.
const LEAST_EFFECT: f64 = 0.1;

/// Smallest emulated probability of the observed outcomes, and the smallest standard deviation of the error of its
/// score. A point that is wrongly excluded would otherwise never be left.
const LEAST_PROBABILITY: f64 = 0.02;
const LEAST_ERROR: f64 = 0.1;

/// Fewest points from which an emulator is fitted; with fewer, the mean is predicted.
const FEWEST: usize = 20;

/// A quadratic polynomial of some coordinates.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Quadratic {
    /// The coordinates on which it depends.
    active: Vec<usize>,
    constant: f64,
    linear: Vec<f64>,
    /// Upper triangle, by rows.
    quadratic: Vec<f64>,
    /// Variance of the error.
    variance: f64,
    hyperparameters: Option<Hyperparameters>,
}

impl Quadratic {
    fn at(&self, x: &[f64]) -> f64 {
        let mut sum = self.constant;
        let mut terms = self.quadratic.iter();
        for (row, (&j, linear)) in self.active.iter().zip(&self.linear).enumerate() {
            let of_row = self.active[row..].iter().zip(terms.by_ref());
            sum += x[j] * (linear + of_row.map(|(&k, q)| q * x[k]).sum::<f64>());
        }
        sum
    }

    /// The mean of some values, where no polynomial can be fitted.
    fn constant(values: &[f64]) -> Self {
        let [constant, deviation] = crate::statistics::moments(values);
        Self {
            active: Vec::new(),
            constant: if constant.is_finite() { constant } else { 0.0 },
            linear: Vec::new(),
            quadratic: Vec::new(),
            variance: if deviation.is_finite() { deviation.powi(2) } else { 0.0 },
            hyperparameters: None,
        }
    }

    fn fit(points: &[&[f64]], values: &[f64], before: Option<&Hyperparameters>) -> Self {
        let mean = Self::constant(values);
        let (centre, deviation) = (mean.constant, mean.variance.sqrt());
        if values.len() < FEWEST || deviation <= 0.0 {
            return mean;
        }
        let variables: Vec<usize> = (0..points[0].len()).collect();
        let scaled: Vec<f64> = values.iter().map(|y| (y - centre) / deviation).collect();
        let stride = points.len().div_ceil(HYPER_POINTS);
        let thin = |offset: usize| (offset..points.len()).step_by(stride);
        let some: Vec<&[f64]> = thin(0).map(|k| points[k]).collect();
        let of_some: Vec<f64> = thin(0).map(|k| scaled[k]).collect();
        let (start, iterations) = match before {
            Some(before) => (before.clone(), FURTHER_ITERATIONS),
            None => (Hyperparameters::of_prior(variables.len()), FIRST_ITERATIONS),
        };
        let hyperparameters = Training::new(&some, &variables, of_some).estimate(start, iterations);
        let active = hyperparameters.active(LEAST_EFFECT);
        let of_active = hyperparameters.of(&active);
        let training = Training::new(points, &active, scaled);
        let Some(polynomial) = training.polynomial(&of_active) else {
            return mean;
        };
        Self {
            active,
            constant: centre + deviation * polynomial.constant,
            linear: polynomial.linear.iter().map(|own| deviation * own).collect(),
            quadratic: polynomial.quadratic.iter().map(|own| deviation * own).collect(),
            variance: deviation.powi(2) * of_active.noise(),
            hyperparameters: Some(hyperparameters),
        }
    }
}

/// Distance of a prediction from its reading that is one unit of the coordinate of the score \[scales\], and the
/// largest magnitude of that coordinate.
const UNIT: f64 = 3.0;
const FARTHEST: f64 = 4.0;

/// The emulator of a reading.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Emulated {
    /// Index of the reading.
    index: usize,
    reading: Reading,
    scale: f64,
    polynomial: Quadratic,
}

impl Emulated {
    /// A prediction as a coordinate of the score of the outcomes.
    fn coordinate(&self, prediction: f64) -> f64 {
        let distance = (prediction - self.reading.nearest(prediction)) / (UNIT * self.scale);
        distance.clamp(-FARTHEST, FARTHEST)
    }
}

/// Emulators of the readings that count.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Emulator {
    readings: Vec<Emulated>,
    /// Score of the outcomes; none where too few points have others than the observed ones.
    outcome: Option<Quadratic>,
}

/// A point in the coordinates of the emulators, and its predictions of all readings.
pub(crate) struct Example {
    pub(crate) coordinates: Vec<f64>,
    pub(crate) predictions: Vec<f64>,
}

impl Emulator {
    /// Fits the readings `counting` to points with the observed outcomes, in the order of their age; `predictions` are
    /// in the order of `counting`. `refused` are the coordinates of points with other outcomes. `before` supplies the
    /// hyperparameters from which the estimate continues.
    pub(crate) fn fit(
        (examples, refused): (&[Example], &[Vec<f64>]),
        counting: &[usize],
        likelihood: &Likelihood,
        before: Option<&Self>,
    ) -> Self {
        let fitted = |(place, &reading): (usize, &usize)| {
            let datum = &likelihood.data()[reading];
            let distance = |own: &Example| {
                let value = own.predictions[place];
                ((datum.reading.nearest(value) - value) / datum.scale).abs()
            };
            let mut near: Vec<(f64, usize)> = examples.iter().map(distance).zip(0..).collect();
            near.retain(|(distance, _)| distance.is_finite());
            near.sort_by(|a, b| a.0.total_cmp(&b.0));
            let within = near.partition_point(|(distance, _)| *distance <= WINDOW);
            near.truncate(within.max(FEWEST_POINTS));
            let mut chosen: Vec<usize> = near.into_iter().map(|(_, own)| own).collect();
            chosen.sort_unstable();
            let latest = &chosen[chosen.len().saturating_sub(MOST_POINTS)..];
            let points: Vec<&[f64]> = latest.iter().map(|&k| examples[k].coordinates.as_slice()).collect();
            let values: Vec<f64> = latest.iter().map(|&k| examples[k].predictions[place]).collect();
            let before = before.and_then(|own| own.readings.get(place)?.polynomial.hyperparameters.as_ref());
            Emulated {
                index: reading,
                reading: datum.reading,
                scale: datum.scale,
                polynomial: Quadratic::fit(&points, &values, before),
            }
        };
        let mut made = Self {
            readings: counting.par_iter().enumerate().map(fitted).collect(),
            outcome: None,
        };
        let extended = |coordinates: &[f64]| {
            let mut own = coordinates.to_vec();
            made.extend(&mut own, coordinates.len(), |_, _| ());
            own
        };
        let with: Vec<Vec<f64>> = examples.iter().map(|own| extended(&own.coordinates)).collect();
        let without: Vec<Vec<f64>> = refused.iter().map(|own| extended(own)).collect();
        let before = before.and_then(|own| own.outcome.as_ref()?.hyperparameters.as_ref());
        made.outcome = score(&with, &without, before);
        made
    }

    /// Variance of the error of each of `count` readings; 0 for those that are not emulated.
    pub(crate) fn variances(&self, count: usize) -> Vec<f64> {
        let mut variances = vec![0.0; count];
        for own in &self.readings {
            variances[own.index] = own.polynomial.variance;
        }
        variances
    }

    /// Writes the emulated predictions, as coordinates of the score, behind the coordinates of the `variables`, and
    /// gives each with the index of its reading.
    fn extend(&self, coordinates: &mut Vec<f64>, variables: usize, mut give: impl FnMut(usize, f64)) {
        coordinates.truncate(variables);
        for own in &self.readings {
            let prediction = own.polynomial.at(coordinates);
            coordinates.push(own.coordinate(prediction));
            give(own.index, prediction);
        }
    }

    /// Writes the predictions at a point of `variables` coordinates, and returns the logarithm of the probability of
    /// the observed outcomes there. The coordinates are extended as the score needs them.
    pub(crate) fn predict(&self, coordinates: &mut Vec<f64>, variables: usize, predictions: &mut [Prediction]) -> f64 {
        self.extend(coordinates, variables, |reading, value| {
            predictions[reading] = Prediction::Value(value);
        });
        self.outcome.as_ref().map_or(0.0, |own| {
            let score = own.at(coordinates) / own.variance.sqrt().max(LEAST_ERROR);
            (LEAST_PROBABILITY + (1.0 - LEAST_PROBABILITY) * normal::cumulative(score)).ln()
        })
    }
}

/// Fits 1 to the latest points with the observed outcomes and -1 to the latest of the others.
fn score(with: &[Vec<f64>], without: &[Vec<f64>], before: Option<&Hyperparameters>) -> Option<Quadratic> {
    if with.len().min(without.len()) < FEWEST {
        return None;
    }
    let most = MOST_POINTS / 2;
    let with = with[with.len().saturating_sub(most)..]
        .iter()
        .map(|own| (own.as_slice(), 1.0));
    let without = without[without.len().saturating_sub(most)..]
        .iter()
        .map(|own| (own.as_slice(), -1.0));
    // Every subset that the hyperparameters are estimated from contains both.
    let order = |k: u64| crate::random::Stream::new(0, &[k]).uniform(0);
    let mut shares: Vec<(f64, (&[f64], f64))> = (0..).map(order).zip(with.chain(without)).collect();
    shares.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (points, values): (Vec<&[f64]>, Vec<f64>) = shares.into_iter().map(|(_, row)| row).unzip();
    Some(Quadratic::fit(&points, &values, before))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::likelihood::{Datum, ErrorLaw};
    use crate::random::Stream;

    const VARIABLES: usize = 30;

    fn points(count: u64, seed: u64) -> Vec<Vec<f64>> {
        let point = |k: u64| {
            let stream = Stream::new(seed, &[k]);
            (0..VARIABLES as u64).map(|j| stream.normal(j)).collect()
        };
        (0..count).map(point).collect()
    }

    fn truth(x: &[f64]) -> f64 {
        2.0 + x[3] - 0.5 * x[7] + 0.4 * x[3] * x[11] + 0.3 * x[7] * x[7]
    }

    fn fitted(value: fn(&[f64]) -> f64) -> Quadratic {
        let points = points(400, 1);
        let rows: Vec<&[f64]> = points.iter().map(Vec::as_slice).collect();
        let values: Vec<f64> = rows.iter().map(|x| value(x)).collect();
        Quadratic::fit(&rows, &values, None)
    }

    #[test]
    fn a_quadratic_function_of_few_coordinates_is_found_among_many() {
        let found = fitted(truth);
        for j in [3, 7, 11] {
            assert!(found.active.contains(&j), "{:?}", found.active);
        }
        let error = points(200, 2)
            .iter()
            .map(|x| (found.at(x) - truth(x)).powi(2))
            .sum::<f64>()
            / 200.0;
        assert!(error.sqrt() < 0.03, "{error:e}, {:?}", found.active);
    }

    #[test]
    fn the_variance_is_that_of_what_is_not_quadratic() {
        let rough = |x: &[f64]| truth(x) + 0.3 * (9.0 * x[20]).sin();
        let found = fitted(rough);
        let error = points(400, 2)
            .iter()
            .map(|x| (found.at(x) - rough(x)).powi(2))
            .sum::<f64>()
            / 400.0;
        // The variance of the sine is 0.045.
        assert!((0.04..0.08).contains(&error), "{error}");
        assert!(
            (0.7..1.3).contains(&(found.variance / error)),
            "{} {error}",
            found.variance
        );
    }

    #[test]
    fn points_far_from_the_reading_are_not_fitted() {
        let datum = Datum {
            name: "y".to_owned(),
            condition: 0,
            reading: Reading::Value(2.0),
            scale: 0.5,
            shared: Vec::new(),
            counts: true,
        };
        let likelihood = Likelihood::new(vec![datum], 1, &[], ErrorLaw::Student);
        let jump = |x: &[f64]| if x[0] > 1.0 { -80.0 } else { truth(x) };
        let example = |x: Vec<f64>| Example {
            predictions: vec![jump(&x)],
            coordinates: x,
        };
        let examples: Vec<Example> = points(600, 1).into_iter().map(example).collect();
        let emulator = likelihood.map(|own| Emulator::fit((&examples, &[]), &[0], &own, None));
        let variance = emulator.map(|own| own.variances(1)[0]);
        assert!(variance.is_ok_and(|own| own < 0.01));
    }

    #[test]
    fn values_that_do_not_vary_are_predicted_as_they_are() {
        let found = fitted(|_| 4.0);
        assert!((found.at(&[0.0; VARIABLES]) - 4.0).abs() < 1e-12 && found.active.is_empty());
    }

    #[test]
    fn outcomes_that_a_sum_decides_are_separated() {
        let drives = |x: &[f64]| x[2] + 0.5 * x[5] > 0.8;
        let (with, without): (Vec<_>, Vec<_>) = points(1500, 1).into_iter().partition(|x| drives(x));
        let emulator = Emulator {
            readings: Vec::new(),
            outcome: score(&with, &without, None),
        };
        let is_right = |x: &&Vec<f64>| {
            let probability = emulator.predict(&mut x.to_vec(), VARIABLES, &mut []);
            (probability > 0.5_f64.ln()) == drives(x)
        };
        let right = points(1000, 2).iter().filter(is_right).count();
        assert!(right > 930, "{right}");
    }
}
