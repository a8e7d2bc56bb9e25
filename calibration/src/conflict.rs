//! Detects readings that contradict each other or the model.
//!
//! If readings contradict each other, the posterior may be narrow but wrong: its draws lie between values that the
//! model cannot reach together. Three tests find such readings. [`unreached`] compares each reading with the prior's
//! predictions. [`left_out_probability`] predicts each reading from the others: the draws are weighted by 1/L_k, cut at
//! sqrt(N) times the mean weight (Ionides, "Truncated importance sampling", Journal of Computational and Graphical
//! Statistics 17, 295 (2008)). [`at_ends`] names the inputs and shared errors that the draws press against the ends of
//! their ranges.

use serde::{Deserialize, Serialize};

use crate::likelihood::{Likelihood, Prediction, Reading};
use crate::normal;
use crate::sampler::{Candidate, Particle};
use crate::statistics::moments;

/// Predictive probability below which a reading conflicts with the others.
pub const CONFLICT: f64 = 0.01;

/// A reading with a predictive probability below this may be the partner of a conflicting one. Errors are widened until
/// both readings reach it.
const SURPRISING: f64 = 0.05;

/// A reading that lies further than this many error scales from all predictions is out of reach.
const OUT_OF_REACH: f64 = 3.0;

/// Fraction of a distribution next to each end, and the share of draws within it above which an input counts as pressed
/// against the end.
const END: f64 = 0.05;
const PRESSED: f64 = 0.25;

/// Mean of a shared error, in standard deviations, above which it counts as extreme.
const LARGE_ERROR: f64 = 2.0;

/// Largest factor by which errors may be widened.
const MOST_WIDENED: f64 = 1e3;

/// A reading that no candidate approaches.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Unreached {
    /// The nearest predicted value.
    pub nearest: f64,
    /// Its distance in standard deviations of the reading, shared errors included.
    pub distance: f64,
}

/// Tests whether a reading lies more than three standard deviations beyond the predictions of all candidates; none if
/// it does not.
pub fn unreached(likelihood: &Likelihood, datum: usize, candidates: &[Candidate]) -> Option<Unreached> {
    let own = &likelihood.data()[datum];
    let variance = own.scale.powi(2) + own.shared.iter().map(|shared| shared.coefficient.powi(2)).sum::<f64>();
    let deviation = variance.sqrt();
    let mut nearest: Option<Unreached> = None;
    let mut sides = [false; 2];
    for candidate in candidates {
        let value = match candidate.predictions[datum] {
            Prediction::Value(value) => value,
            // The true value may be anything from the bound upwards.
            Prediction::AtLeast(bound) => match own.reading {
                Reading::Value(y) | Reading::AtMost(y) | Reading::Within([_, y]) => bound.max(y),
                Reading::AtLeast(_) => return None,
            },
            Prediction::Missing => continue,
        };
        let distance = (own.reading.nearest(value) - value) / deviation;
        sides[usize::from(distance > 0.0)] = true;
        if nearest.is_none_or(|known| distance.abs() < known.distance) {
            nearest = Some(Unreached {
                nearest: value,
                distance: distance.abs(),
            });
        }
    }
    nearest.filter(|own| own.distance > OUT_OF_REACH && sides[0] != sides[1])
}

/// Weights of the draws without the readings `left_out`: the inverse of their likelihood, truncated and normalised.
pub fn weights_without(likelihood: &Likelihood, particles: &[Particle], left_out: &[usize]) -> Vec<f64> {
    let counting = || left_out.iter().filter(|&&k| likelihood.data()[k].counts);
    let log = |own: &Particle| -> f64 {
        counting()
            .map(|&k| -likelihood.of_datum(k, &own.z, own.predictions[k]))
            .sum()
    };
    let log: Vec<f64> = particles.iter().map(log).collect();
    let weights = normalised(&log);
    let limit = 1.0 / (weights.len() as f64).sqrt();
    let sum: f64 = weights.iter().map(|weight| weight.min(limit)).sum();
    weights.iter().map(|weight| weight.min(limit) / sum).collect()
}

/// Converts log weights to weights that sum to 1.
pub fn normalised(log: &[f64]) -> Vec<f64> {
    let most = log.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = log.iter().map(|l| (l - most).exp()).collect();
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|weight| weight / sum).collect()
}

/// Two-sided predictive probability, estimated from weighted draws, of a reading at least as extreme as the actual one;
/// for a censored reading, the probability of the observed interval. `factor` widens the independent error.
pub fn probability(likelihood: &Likelihood, datum: usize, particles: &[Particle], weights: &[f64], factor: f64) -> f64 {
    let own = &likelihood.data()[datum];
    let mut sides = [0.0; 2];
    for (particle, weight) in particles.iter().zip(weights) {
        let prediction = particle.predictions[datum];
        match (own.reading, prediction) {
            (_, Prediction::Missing) => {}
            (Reading::Value(y), _) => {
                let residual = y - prediction.value() - likelihood.shared(datum, &particle.z);
                let below = likelihood.law().cumulative(residual / (factor * own.scale));
                sides[0] += weight * below;
                sides[1] += weight * (1.0 - below);
            }
            _ => {
                let inside = likelihood.widened(datum, factor, &particle.z, prediction).exp();
                sides[0] += weight * inside;
                sides[1] += weight;
            }
        }
    }
    match own.reading {
        Reading::Value(_) => 2.0 * sides[0].min(sides[1]),
        _ => sides[0],
    }
}

/// Predictive probability of a reading, from draws conditioned on neither that reading nor `others`.
pub fn left_out_probability(likelihood: &Likelihood, particles: &[Particle], datum: usize, others: &[usize]) -> f64 {
    let left_out = [&[datum], others].concat();
    let weights = weights_without(likelihood, particles, &left_out);
    probability(likelihood, datum, particles, &weights, 1.0)
}

/// A reading that the others contradict.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Conflict {
    /// The reading.
    pub datum: usize,
    /// Its predictive probability given the others.
    pub probability: f64,
    /// The reading whose removal resolves the conflict; none if the reading contradicts several others together.
    pub partner: Option<usize>,
}

/// The worst conflict among the readings used for calibration; none if each is predicted with a probability of at least
/// 1 %.
///
/// If two readings contradict only each other, the data cannot show which one is wrong, and they are reported as a
/// pair. A reading that remains improbable whichever single other reading is removed contradicts the rest.
pub fn worst(likelihood: &Likelihood, particles: &[Particle]) -> Option<Conflict> {
    worst_of_weighted(likelihood, particles, |left_out| {
        weights_without(likelihood, particles, left_out)
    })
}

/// The same for draws whose weights, conditioned on all readings but those left out, are given by `weights`.
pub fn worst_of_weighted(
    likelihood: &Likelihood,
    particles: &[Particle],
    weights: impl Fn(&[usize]) -> Vec<f64>,
) -> Option<Conflict> {
    let data = likelihood.data();
    let counting: Vec<usize> = (0..data.len()).filter(|&k| data[k].counts).collect();
    let of = |k: usize, others: &[usize]| {
        let weights = weights(&[&[k], others].concat());
        probability(likelihood, k, particles, &weights, 1.0)
    };
    let alone: Vec<(usize, f64)> = counting.iter().map(|&k| (k, of(k, &[]))).collect();
    let &(datum, probability) = alone.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
    if probability >= CONFLICT {
        return None;
    }
    let partners = alone.iter().filter(|(k, own)| *k != datum && *own < SURPRISING);
    let without = partners.map(|&(k, _)| (k, of(datum, &[k])));
    let partner = without
        .filter(|(_, own)| *own >= CONFLICT)
        .max_by(|a, b| a.1.total_cmp(&b.1));
    Some(Conflict {
        datum,
        probability,
        partner: partner.map(|(k, _)| k),
    })
}

/// The factor by which the independent errors of one or two readings must be widened so that each has a predictive
/// probability of 5 % given the remaining data.
pub fn widening(likelihood: &Likelihood, particles: &[Particle], datum: usize, partner: Option<usize>) -> f64 {
    widening_of_weighted(likelihood, particles, &vec![0.0; particles.len()], datum, partner)
}

/// The same for draws with these logarithms of weights, which do not depend on the one or two readings.
pub fn widening_of_weighted(
    likelihood: &Likelihood,
    particles: &[Particle],
    log_weights: &[f64],
    datum: usize,
    partner: Option<usize>,
) -> f64 {
    let agree = |factor: f64| {
        let of = |k: usize, other: Option<usize>| {
            let log = |(own, base): (&Particle, &f64)| {
                base + other.map_or(0.0, |j| likelihood.widened(j, factor, &own.z, own.predictions[j]))
            };
            let log: Vec<f64> = particles.iter().zip(log_weights).map(log).collect();
            probability(likelihood, k, particles, &normalised(&log), factor) >= SURPRISING
        };
        of(datum, partner) && partner.is_none_or(|other| of(other, Some(datum)))
    };
    let (mut low, mut high) = (1.0, 2.0);
    while !agree(high) && high < MOST_WIDENED {
        (low, high) = (high, 2.0 * high);
    }
    for _ in 0..40 {
        let middle: f64 = (low * high).sqrt();
        if agree(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

/// A variable whose draws are pressed against an end of its distribution.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Pressed {
    /// Index of the variable.
    pub variable: usize,
    /// Whether it is pressed against the upper end.
    pub is_upper: bool,
    /// Share of the draws in the last 5 % before that end.
    pub share: f64,
}

/// The variables that have more than a quarter of the weighted draws in the last 5 % of their distribution, the most
/// pressed first. Shared errors, listed in `errors`, are included if their mean exceeds two standard deviations.
pub fn at_ends(particles: &[Particle], weights: &[f64], errors: &[usize]) -> Vec<Pressed> {
    let variables = particles.first().map_or(0, |own| own.z.len());
    let limit = normal::quantile(END);
    let mut found = Vec::new();
    for variable in 0..variables {
        for is_upper in [false, true] {
            let is_beyond = |z: f64| if is_upper { z > -limit } else { z < limit };
            let (mut share, mut mean) = (0.0, 0.0);
            for (own, weight) in particles.iter().zip(weights) {
                mean += own.z[variable] * weight;
                share += if is_beyond(own.z[variable]) { *weight } else { 0.0 };
            }
            let is_pressed = match errors.contains(&variable) {
                true if is_upper => mean > LARGE_ERROR,
                true => mean < -LARGE_ERROR,
                false => share > PRESSED,
            };
            if is_pressed {
                found.push(Pressed {
                    variable,
                    is_upper,
                    share,
                });
            }
        }
    }
    found.sort_by(|a, b| b.share.total_cmp(&a.share));
    found
}

/// Residual of the mean prediction of a reading, divided by the combined standard deviation of reading and predictions;
/// 0 inside a censored interval.
pub fn left_over(likelihood: &Likelihood, datum: usize, particles: &[Particle]) -> f64 {
    let own = &likelihood.data()[datum];
    let value = |own: &Particle| own.predictions[datum].value() + likelihood.shared(datum, &own.z);
    let [mean, deviation] = moments(&particles.iter().map(value).collect::<Vec<_>>());
    (own.reading.nearest(mean) - mean) / own.scale.hypot(deviation)
}
