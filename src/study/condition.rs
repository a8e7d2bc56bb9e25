//! Inputs that determine whether a shot counts: first-order contributions to the variance of this indicator, over all
//! candidates with a shot.
//!
//! Y is 1 if a shot counts, else 0, and S_i = Var E[Y|X_i]/Var Y. E[Y|X_i] is the fraction of candidates that count in
//! each of [`BINS`] equal parts of the input's distribution, so that a study stores counts instead of candidates. The
//! scatter of these fractions is corrected as for the levels (Kelley 1935). Resamples draw the number of counting shots
//! in each part from its binomial distribution; they scatter around those of the sample, so that the correction is
//! applied twice to them. For an input without effect, n times the uncorrected estimate has the chi-squared
//! distribution of `BINS` - 1 degrees of freedom.

use nailnoise_acoustics::random::uniform;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::correlation_ratio::corrected;
use super::normal;
use super::statistics::{Estimate, RESAMPLES, interval};
use super::variables::Variable;

/// Number of parts of a distribution.
const BINS: usize = 16;

/// Probability that any of the inputs is above the limit by chance.
const CHANCE: f64 = 0.05;

/// Minimum number of shots for an estimate of contributions, and minimum number of those that count or do not.
const FEWEST: u64 = 200;
const FEWEST_OF_A_KIND: u64 = 20;

/// Variance above which a binomial number is approximated by a normal one.
const NORMAL: f64 = 50.0;

const SEED: u64 = 0x5EED_C0DE;

/// Number of candidates with a shot in each part of each input's distribution, and number of those that count.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Counts {
    inputs: Vec<[[u64; 2]; BINS]>,
    shots: u64,
    counting: u64,
}

impl Counts {
    /// Adds a candidate, given the positions of its inputs in their distributions; NaN for an input that is not drawn.
    pub(super) fn add(&mut self, shares: &[f64], counts: bool) {
        self.inputs.resize(shares.len(), [[0; 2]; BINS]);
        self.shots += 1;
        self.counting += u64::from(counts);
        for (bins, share) in self.inputs.iter_mut().zip(shares).filter(|(_, share)| !share.is_nan()) {
            let bin = &mut bins[((share * BINS as f64) as usize).min(BINS - 1)];
            bin[0] += 1;
            bin[1] += u64::from(counts);
        }
    }
}

/// Number of all shots in some parts, and of those that count.
fn sum(bins: &[[u64; 2]]) -> [u64; 2] {
    bins.iter()
        .fold([0, 0], |sums, bin| [sums[0] + bin[0], sums[1] + bin[1]])
}

/// S of an input without the correction, and its degrees of freedom; `None` for a fixed input.
fn explained(bins: &[[u64; 2]]) -> Option<(f64, f64)> {
    let occupied = || bins.iter().filter(|[shots, _]| *shots > 0);
    let degrees = occupied().count().checked_sub(1).filter(|degrees| *degrees > 0)?;
    let [shots, counting] = sum(bins);
    let (n, share) = (shots as f64, counting as f64 / shots as f64);
    let between: f64 = occupied()
        .map(|&[shots, counting]| shots as f64 * (counting as f64 / shots as f64 - share).powi(2))
        .sum();
    let variance = n * share * (1.0 - share);
    Some((if variance > 0.0 { between / variance } else { 0.0 }, degrees as f64))
}

/// 90 % interval of S of an input after the correction for chance, which is applied twice.
fn interval_of(bins: &[[u64; 2]], chance: f64) -> [Option<f64>; 2] {
    let resample = |resample: usize| {
        let drawn = |(place, &[shots, counting]): (usize, &[u64; 2])| {
            let share = counting as f64 / shots.max(1) as f64;
            [
                shots,
                binomial(shots, share, uniform(SEED, resample as u64, place as u64)),
            ]
        };
        let bins: Vec<[u64; 2]> = bins.iter().enumerate().map(drawn).collect();
        let explained = explained(&bins).map_or(0.0, |(explained, _)| explained);
        corrected(explained, chance, 2)
    };
    interval((0..RESAMPLES).map(resample).collect())
}

/// The number of successes in `n` trials at the quantile `u` of the binomial distribution.
fn binomial(n: u64, p: f64, u: f64) -> u64 {
    let trials = n as f64;
    if p > 0.5 {
        return n - binomial(n, 1.0 - p, 1.0 - u);
    }
    let variance = trials * p * (1.0 - p);
    if variance > NORMAL {
        let value = trials * p + normal::quantile(u.clamp(1e-12, 1.0 - 1e-12)) * variance.sqrt();
        return value.round().clamp(0.0, trials) as u64;
    }
    let (mut number, mut probability) = (0, (1.0 - p).powf(trials));
    let mut below = probability;
    while below < u && number < n {
        probability *= (n - number) as f64 / (number + 1) as f64 * p / (1.0 - p);
        number += 1;
        below += probability;
    }
    number
}

/// Inputs that determine whether a shot counts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Condition {
    /// Number of candidates with a shot.
    pub shots: u64,
    /// Fraction of them that counts.
    pub share: f64,
    /// First-order contribution that any input exceeds by chance with a probability of 5 %.
    pub by_chance: f64,
    /// Inputs above this limit, largest first.
    pub inputs: Vec<ConditionInput>,
}

/// Contribution of an input to whether a shot counts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ConditionInput {
    /// The variable.
    pub variable: String,
    /// Fraction of the variance that it explains alone \[-\].
    pub first_order: Estimate,
    /// Fractions of shots that count in the lower and upper half of its distribution.
    pub halves: [f64; 2],
}

/// The quantile `p` of the chi-squared distribution (Wilson and Hilferty 1931).
fn chi_squared(degrees: f64, p: f64) -> f64 {
    let part = 2.0 / (9.0 * degrees);
    degrees * (1.0 - part + normal::quantile(p) * part.sqrt()).powi(3)
}

/// The inputs that determine whether a shot counts; `None` if there are too few shots, or if nearly all or none of them
/// count.
pub(super) fn condition(counts: &Counts, variables: &[Variable]) -> Option<Condition> {
    let (shots, counting) = (counts.shots, counts.counting);
    if shots < FEWEST || counting.min(shots - counting) < FEWEST_OF_A_KIND {
        return None;
    }
    let n = shots as f64;
    let known: Vec<(usize, f64, f64)> = (0..variables.len().min(counts.inputs.len()))
        .filter_map(|input| explained(&counts.inputs[input]).map(|(explained, degrees)| (input, explained, degrees)))
        .collect();
    let chance = |degrees: f64| degrees / (n - 1.0);
    let limit = |degrees: f64| {
        let largest = chi_squared(degrees, 1.0 - CHANCE / known.len().max(1) as f64) / n;
        corrected(largest, chance(degrees), 1)
    };
    let share_of = |bins: &[[u64; 2]]| {
        let [shots, counting] = sum(bins);
        counting as f64 / shots.max(1) as f64
    };
    let above = known.iter().filter_map(|&(input, explained, degrees)| {
        let value = corrected(explained, chance(degrees), 1);
        (value > limit(degrees)).then(|| ConditionInput {
            variable: variables[input].name.clone(),
            first_order: Estimate {
                value: Some(value),
                interval: interval_of(&counts.inputs[input], chance(degrees)),
            },
            halves: [0..BINS / 2, BINS / 2..BINS].map(|half| share_of(&counts.inputs[input][half])),
        })
    });
    let mut inputs: Vec<ConditionInput> = above.collect();
    let value = |input: &ConditionInput| input.first_order.value.unwrap_or_default();
    inputs.sort_by(|a, b| value(b).total_cmp(&value(a)));
    Some(Condition {
        shots,
        share: counting as f64 / n,
        by_chance: limit((BINS - 1) as f64),
        inputs,
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::study::variables::{Scope, VariableKind};

    /// A shot counts if X_0 < 5/16 and X_1 < 1/2; X_2 has no effect.
    fn found(seed: u64, n: u64) -> Condition {
        let variables = ["a", "b", "c"].map(|name| Variable {
            name: name.to_owned(),
            scope: Scope::Shot,
            kind: VariableKind::LawScore,
        });
        let mut counts = Counts::default();
        for draw in 0..n {
            let shares: Vec<f64> = (0..3).map(|input| uniform(seed, input, draw)).collect();
            counts.add(&shares, shares[0] < 5.0 / 16.0 && shares[1] < 0.5);
        }
        condition(&counts, &variables).unwrap()
    }

    /// Var Y = p (1 - p), Var E[Y|X_0] = (1/2)^2 q (1 - q), Var E[Y|X_1] = q^2/4, with q = 5/16 and p = q/2.
    fn expected() -> [f64; 2] {
        let q: f64 = 5.0 / 16.0;
        let variance = 0.5 * q * (1.0 - 0.5 * q);
        [0.25 * q * (1.0 - q) / variance, 0.25 * q * q / variance]
    }

    #[test]
    fn contributions_to_a_condition_are_the_analytic_ones() {
        let found = found(1, 20_000);
        assert_eq!(found.inputs.len(), 2);
        for (input, expected) in found.inputs.iter().zip(expected()) {
            let value = input.first_order.value.unwrap();
            assert!((value - expected).abs() < 0.015, "{value}, expected {expected}");
        }
        assert!((found.inputs[1].halves[0] - 5.0 / 16.0).abs() < 0.01 && found.inputs[1].halves[1] == 0.0);
    }

    #[test]
    fn an_input_that_does_nothing_is_seldom_above_the_limit() {
        let above = (0..200).filter(|seed| found(*seed, 1000).inputs.iter().any(|own| own.variable == "c"));
        // For one of three inputs, 5/3 % of 200 are three to four; eleven or more have a probability of 0.1 %.
        assert!(above.count() < 11);
    }

    /// Intervals stated as 90 % contain the true value in 84 to 96 % of 200 repetitions.
    #[test]
    fn intervals_cover_as_stated() {
        let mut covered = [0; 2];
        for seed in 0..200 {
            let found = found(1000 + seed, 2000);
            for ((covered, name), expected) in covered.iter_mut().zip(["a", "b"]).zip(expected()) {
                let own = found.inputs.iter().find(|own| own.variable == name).unwrap();
                let [low, high] = own.first_order.interval.map(Option::unwrap);
                *covered += u32::from((low..=high).contains(&expected));
            }
        }
        assert!(
            covered.iter().all(|own| (168..=192).contains(own)),
            "{covered:?} of 200"
        );
    }

    #[test]
    fn binomial_numbers_have_their_distribution() {
        for (n, p) in [(40, 0.1), (40, 0.95), (1000, 0.3)] {
            let count = 4000;
            let drawn: Vec<f64> = (0..count)
                .map(|k| binomial(n, p, (f64::from(k) + 0.5) / f64::from(count)) as f64)
                .collect();
            let mean = drawn.iter().sum::<f64>() / f64::from(count);
            let variance = drawn.iter().map(|own| (own - mean).powi(2)).sum::<f64>() / f64::from(count);
            let (trials, expected) = (n as f64 * p, n as f64 * p * (1.0 - p));
            assert!(
                (mean - trials).abs() < 0.02 && (variance / expected - 1.0).abs() < 0.01,
                "{n} {p}: {mean} {variance}"
            );
        }
    }

    #[test]
    fn too_few_shots_state_nothing() {
        assert_eq!(condition(&Counts::default(), &[]), None);
    }
}
