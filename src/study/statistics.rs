//! Quantiles, probabilities of orders and losses of decisions from draws, each with its bootstrap interval.
//!
//! Levels are in dB re 1 pW s; minus infinity is silence. Quantiles of draws interpolate linearly between adjacent
//! ones, at the position p (n + 1). A further draw is then lower with the probability p, whatever the distribution.
//! This is type 6 of Hyndman and Fan, "Sample quantiles in statistical packages", The American Statistician 50, 361
//! (1996). Those of resamples are of type 7.

use std::collections::BTreeMap;

use nailnoise_acoustics::random::uniform;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::decibels::energy_sum;

/// Number of bootstrap resamples.
pub(super) const RESAMPLES: usize = 1000;

/// Seed of the resamples, so that the same draws have the same intervals.
const SEED: u64 = 0x0B00_7577;

/// An estimate with the 90 % interval of its sampling error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Estimate {
    /// The estimate; null for silence.
    pub value: Option<f64>,
    /// 5th and 95th percentile over resampled draws; null if silence is among them.
    pub interval: [Option<f64>; 2],
}

impl Estimate {
    /// Half the width of the interval; `None` if it includes silence.
    pub fn half_width(&self) -> Option<f64> {
        let [low, high] = self.interval;
        Some(0.5 * (high? - low?))
    }
}

/// Levels below which 5, 50 and 95 % of the draws lie \[dB re 1 pW s\].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Quantiles {
    /// 5 %.
    pub p05: Estimate,
    /// Half.
    pub p50: Estimate,
    /// 95 %.
    pub p95: Estimate,
}

/// The quantile `p` of sorted values.
pub(super) fn quantile(sorted: &[f64], p: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else {
        return f64::NAN;
    };
    let at = p * last as f64;
    let (low, part) = (at.floor() as usize, at.fract());
    interpolated(sorted[low.min(last)], sorted[(low + 1).min(last)], part)
}

/// Interpolates between two values, both of which may be minus infinity.
fn interpolated(below: f64, above: f64, part: f64) -> f64 {
    if part == 0.0 || below == above {
        below
    } else {
        below + part * (above - below)
    }
}

/// The mean of figures that may count several times.
pub(super) fn weighted_mean(figures: &[f64], counts: &[u32]) -> f64 {
    let weighted = figures
        .iter()
        .zip(counts)
        .map(|(figure, &count)| f64::from(count) * figure);
    weighted.sum::<f64>() / f64::from(counts.iter().sum::<u32>())
}

/// Resampled draws. A resample is made on demand: the count of each draw takes 4 bytes while one estimate uses it,
/// whereas all resamples together would take 4 kB per draw.
pub(super) struct Bootstrap {
    /// Draws of each cluster; `None` if single draws are resampled.
    clusters: Option<Vec<Vec<u32>>>,
    /// Number of clusters or draws.
    units: usize,
    draws: usize,
}

impl Bootstrap {
    /// Resamples clusters of draws, or draws if all are in one cluster. `clusters` contains the cluster of each draw.
    pub(super) fn new(clusters: &[usize]) -> Self {
        let mut members: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
        if clusters.iter().any(|cluster| *cluster != clusters[0]) {
            for (draw, cluster) in (0..).zip(clusters) {
                members.entry(*cluster).or_default().push(draw);
            }
        }
        let members: Vec<Vec<u32>> = members.into_values().collect();
        let draws = clusters.len();
        let (units, clusters) = match members.len() {
            0 => (draws, None),
            count => (count, Some(members)),
        };
        Self { clusters, units, draws }
    }

    /// Value of `statistic` for each resample, computed from the number of times each draw counts.
    fn resampled<T>(&self, mut statistic: impl FnMut(&[u32]) -> T) -> Vec<T> {
        let mut counts = vec![0; self.draws];
        let resample = |resample: u64| {
            counts.fill(0);
            for pick in 0..self.units as u64 {
                let unit = (uniform(SEED, resample, pick) * self.units as f64) as usize;
                match &self.clusters {
                    Some(clusters) => clusters[unit].iter().for_each(|&draw| counts[draw as usize] += 1),
                    None => counts[unit] += 1,
                }
            }
            statistic(&counts)
        };
        (0..RESAMPLES as u64).map(resample).collect()
    }

    /// An estimate with its interval; the argument of `statistic` is the number of times each draw counts.
    pub(super) fn estimate(&self, statistic: impl Fn(&[u32]) -> f64) -> Estimate {
        estimate(statistic(&vec![1; self.draws]), self.resampled(&statistic))
    }

    /// 90 % intervals of several figures over the resamples.
    pub(super) fn intervals(&self, statistics: impl FnMut(&[u32]) -> Vec<f64>) -> Vec<[Option<f64>; 2]> {
        let resampled = self.resampled(statistics);
        let figures = resampled.first().map_or(0, Vec::len);
        (0..figures)
            .map(|place| interval(resampled.iter().map(|own| own[place]).collect()))
            .collect()
    }

    /// The mean of a figure of each draw.
    pub(super) fn mean(&self, figures: &[f64]) -> Estimate {
        self.estimate(|counts| weighted_mean(figures, counts))
    }

    /// The fraction of draws for which a condition holds. If it holds for all or none, no resample differs. The
    /// interval is then that of the binomial distribution: beyond its end, the probability of this result is below 5 %
    /// (Clopper and Pearson 1934).
    pub(super) fn share(&self, is_so: &[bool]) -> Estimate {
        let figures: Vec<f64> = is_so.iter().map(|&is_so| f64::from(u8::from(is_so))).collect();
        let mut estimate = self.mean(&figures);
        let least = 0.05_f64.powf(1.0 / self.units.max(1) as f64);
        match estimate.value {
            Some(1.0) => estimate.interval = [Some(least), Some(1.0)],
            Some(0.0) => estimate.interval = [Some(0.0), Some(1.0 - least)],
            _ => {}
        }
        estimate
    }

    /// P5, P50 and P95 of levels.
    pub(super) fn quantiles(&self, levels: &[f64]) -> Quantiles {
        let mut order: Vec<u32> = (0..levels.len() as u32).collect();
        order.sort_by(|a, b| levels[*a as usize].total_cmp(&levels[*b as usize]));
        let of = |counts: &[u32]| counted_quantiles(levels, &order, counts, [0.05, 0.5, 0.95]);
        let (all, resampled) = (of(&vec![1; self.draws]), self.resampled(of));
        let [p05, p50, p95] =
            [0, 1, 2].map(|place| estimate(all[place], resampled.iter().map(|own| own[place]).collect()));
        Quantiles { p05, p50, p95 }
    }
}

/// An estimate, with the interval of the resampled ones.
fn estimate(value: f64, resampled: Vec<f64>) -> Estimate {
    Estimate {
        value: value.is_finite().then_some(value),
        interval: interval(resampled),
    }
}

/// 5th and 95th percentile.
pub(super) fn interval(mut resampled: Vec<f64>) -> [Option<f64>; 2] {
    resampled.sort_by(f64::total_cmp);
    [0.05, 0.95].map(|p| Some(quantile(&resampled, p)).filter(|value| value.is_finite()))
}

/// Quantiles of levels that may count several times; `order` contains their indices, lowest level first.
fn counted_quantiles<const N: usize>(levels: &[f64], order: &[u32], counts: &[u32], shares: [f64; N]) -> [f64; N] {
    let count = counts.iter().sum::<u32>();
    let last = count.saturating_sub(1);
    let at = shares.map(|p| (p * f64::from(count + 1) - 1.0).clamp(0.0, f64::from(last)));
    let mut wanted: Vec<(u32, usize)> = at
        .iter()
        .enumerate()
        .flat_map(|(own, at)| {
            [
                (at.floor() as u32, 2 * own),
                ((at.floor() as u32 + 1).min(last), 2 * own + 1),
            ]
        })
        .collect();
    wanted.sort_unstable();
    // Finds the levels at all positions in one pass through the ordered draws.
    let mut ends = [[f64::NAN; 2]; N];
    let (mut seen, mut draws) = (0, order.iter());
    let mut level = f64::NAN;
    for (place, end) in wanted {
        while seen <= place
            && let Some(&draw) = draws.next()
        {
            seen += counts[draw as usize];
            level = levels[draw as usize];
        }
        ends[end / 2][end % 2] = level;
    }
    std::array::from_fn(|own| interpolated(ends[own][0], ends[own][1], at[own].fract()))
}

/// The quantile `p` of weighted levels: each represents its fraction of the total weight and is at the centre of that
/// fraction (type 5 of Hyndman and Fan, if the weights are equal).
pub(super) fn weighted_quantiles(levels: &[f64], weights: &[f64], p: f64) -> f64 {
    let mut order: Vec<usize> = (0..levels.len()).filter(|&draw| weights[draw] > 0.0).collect();
    order.sort_by(|a, b| levels[*a].total_cmp(&levels[*b]));
    let total: f64 = order.iter().map(|&draw| weights[draw]).sum();
    let (mut below, mut before) = (0.0, None);
    for draw in order {
        let place = (below + 0.5 * weights[draw]) / total;
        if place >= p {
            return match before {
                Some((other, level)) => interpolated(level, levels[draw], (p - other) / (place - other)),
                None => levels[draw],
            };
        }
        (below, before) = (below + weights[draw], Some((place, levels[draw])));
    }
    before.map_or(f64::NAN, |(_, level)| level)
}

/// Places of sources by their levels, loudest first; equal levels stay in the order of the sources.
pub(super) fn order(levels: &[f64]) -> Vec<usize> {
    let mut places: Vec<usize> = (0..levels.len()).collect();
    places.sort_by(|a, b| levels[*b].total_cmp(&levels[*a]));
    places
}

/// How far a source is below the loudest one of a draw \[dB\]: the loss of treating it as the loudest.
pub(super) fn loss(levels: &[f64], source: usize) -> f64 {
    levels.iter().copied().fold(f64::NEG_INFINITY, f64::max) - levels[source]
}

/// By how much the total falls where a source is silent \[dB\].
pub(super) fn benefit(levels: &[f64], source: usize) -> f64 {
    let others = levels
        .iter()
        .enumerate()
        .filter(|(other, _)| *other != source)
        .map(|(_, level)| *level);
    energy_sum(levels.iter().copied()) - energy_sum(others)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::normal;

    const N: u32 = 1 << 15;

    /// Independent standard normal numbers of a low-discrepancy sequence.
    fn normals(index: u32, count: u32) -> Vec<f64> {
        let share = |dimension| f64::from(sobol_burley::sample(index, dimension, 7)) + 0.5 / f64::from(1 << 24);
        (0..count).map(|dimension| normal::quantile(share(dimension))).collect()
    }

    /// Levels of three sources that are linear in four normal inputs.
    fn linear_gaussian() -> Vec<[f64; 3]> {
        let draw = |index| {
            let z = normals(index, 4);
            let level = |mean: f64, loadings: [f64; 4]| mean + loadings.iter().zip(&z).map(|(a, z)| a * z).sum::<f64>();
            [
                level(100.2, [2.5, 3.0, 0.0, 0.0]),
                level(96.6, [0.9, 0.0, 2.0, 0.0]),
                level(92.8, [0.5, 0.0, 0.0, 1.5]),
            ]
        };
        (0..N).map(draw).collect()
    }

    fn share(draws: &[[f64; 3]], is_so: impl Fn(&[f64]) -> bool) -> f64 {
        draws.iter().filter(|draw| is_so(&draw[..])).count() as f64 / draws.len() as f64
    }

    fn mean(draws: &[[f64; 3]], figure: impl Fn(&[f64]) -> f64) -> f64 {
        draws.iter().map(|draw| figure(&draw[..])).sum::<f64>() / draws.len() as f64
    }

    fn assert_near(found: f64, expected: f64, tolerance: f64, what: &str) {
        assert!(
            (found - expected).abs() < tolerance,
            "{what}: {found}, expected {expected}"
        );
    }

    /// Expected probabilities by quadrature of the trivariate normal distribution.
    #[test]
    fn probabilities_of_orders_are_those_of_the_normal_distribution() {
        let draws = linear_gaussian();
        let expected = [
            ([0, 1, 2], 0.755_910_199),
            ([0, 2, 1], 0.060_810_464),
            ([1, 0, 2], 0.154_229_547),
            ([1, 2, 0], 0.023_170_803),
            ([2, 0, 1], 0.002_562_390),
            ([2, 1, 0], 0.003_316_598),
        ];
        for (places, probability) in expected {
            assert_near(share(&draws, |draw| order(draw) == places), probability, 3e-3, "order");
        }
        for (source, probability) in [0.816_720_663, 0.177_400_349, 0.005_878_987].into_iter().enumerate() {
            assert_near(
                share(&draws, |draw| order(draw)[0] == source),
                probability,
                3e-3,
                "first",
            );
        }
    }

    #[test]
    fn losses_of_a_decision_are_those_of_the_normal_distribution() {
        let draws = linear_gaussian();
        let loudest = |draw: &[f64]| draw.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        assert_near(mean(&draws, loudest), 100.592_070, 5e-3, "loudest");
        assert_near(mean(&draws, |draw| loss(draw, 0)), 100.592_070 - 100.2, 5e-3, "loss");
        for (source, expected) in [4.446, 1.550, 0.578].into_iter().enumerate() {
            assert_near(mean(&draws, |draw| benefit(draw, source)), expected, 0.02, "silencing");
        }
        let most = mean(&draws, |draw| {
            (0..3).map(|source| benefit(draw, source)).fold(0.0, f64::max)
        });
        assert_near(most - 4.446, 0.2655, 0.01, "value of perfect information");
    }

    #[test]
    fn the_quantiles_of_an_energy_sum_are_those_by_quadrature() {
        let sums: Vec<f64> = (0..N)
            .map(|index| {
                let z = normals(index, 2);
                energy_sum([100.0 + 3.0 * z[0], 97.0 + 4.0 * z[1]])
            })
            .collect();
        let mut sorted = sums.clone();
        sorted.sort_by(f64::total_cmp);
        for (p, expected) in [(0.05, 98.247_723), (0.5, 102.321_685), (0.95, 106.522_036)] {
            assert_near(quantile(&sorted, p), expected, 0.02, "quantile");
        }
        let average = sums.iter().sum::<f64>() / f64::from(N);
        assert_near(average, 102.345_507, 2e-3, "mean");
        let energy = energy_sum(sums.iter().copied()) - 10.0 * f64::from(N).log10();
        assert_near(energy, 103.086_526, 0.02, "level of the mean energy");
    }

    #[test]
    fn two_correlated_levels_have_the_probability_of_their_difference() {
        let louder = |r: f64| {
            let z = (0..N).map(|index| normals(index, 2));
            let louder = z.filter(|z| 100.0 + 3.0 * z[0] > 98.0 + 4.0 * (r * z[0] + (1.0 - r * r).sqrt() * z[1]));
            louder.count() as f64 / f64::from(N)
        };
        assert_near(louder(0.0), 0.655_422, 2e-3, "independent");
        assert_near(louder(0.5), 0.710_450, 2e-3, "correlated");
    }

    /// Uniform numbers that do not repeat between repetitions.
    fn sample(seed: u64, n: usize) -> Vec<f64> {
        let number = |place| normal::quantile(uniform(seed, 1, place).max(1e-12));
        (0..n as u64).map(number).collect()
    }

    /// Stated intervals of 90 % contain the true value in 84 to 95 % of 200 repetitions.
    #[test]
    fn intervals_of_the_median_and_of_a_probability_cover_as_stated() {
        let (mut medians, mut shares) = (0, 0);
        for repetition in 0..200 {
            let draws = sample(1000 + repetition, 120);
            let bootstrap = Bootstrap::new(&[0; 120]);
            let holds = |estimate: Estimate, value: f64| {
                let [low, high] = estimate.interval.map(Option::unwrap_or_default);
                u32::from((low..=high).contains(&value))
            };
            medians += holds(bootstrap.quantiles(&draws).p50, 0.0);
            let louder: Vec<bool> = draws.iter().map(|z| *z > 0.5).collect();
            shares += holds(bootstrap.share(&louder), 1.0 - normal::cumulative(0.5));
        }
        assert!((168..=190).contains(&medians), "{medians} of 200 medians");
        assert!((168..=190).contains(&shares), "{shares} of 200 shares");
    }

    /// Draws of a cluster share the inputs of the cluster: if they are resampled one by one, their interval is far too
    /// narrow.
    #[test]
    fn intervals_of_clusters_cover_as_stated() {
        let mut covered = 0;
        for repetition in 0..200 {
            let (common, own) = (sample(5000 + repetition, 40), sample(9000 + repetition, 320));
            let draws: Vec<f64> = (0..320).map(|draw| 3.0 * common[draw / 8] + own[draw]).collect();
            let clusters: Vec<usize> = (0..320).map(|draw| draw / 8).collect();
            let [low, high] = Bootstrap::new(&clusters)
                .mean(&draws)
                .interval
                .map(Option::unwrap_or_default);
            covered += u32::from((low..=high).contains(&0.0));
        }
        assert!((168..=190).contains(&covered), "{covered} of 200");
    }

    /// Of a thing that is so with the probability at the interval's end, so many draws in a row show it with 5 %.
    #[test]
    fn what_is_always_so_is_not_certain() {
        let [low, high] = Bootstrap::new(&[0; 8])
            .share(&[true; 8])
            .interval
            .map(Option::unwrap_or_default);
        assert!((low.powi(8) - 0.05).abs() < 1e-12 && high == 1.0);
        let of_clusters = Bootstrap::new(&[0, 0, 0, 1, 1, 1]).share(&[false; 6]).interval;
        let high = of_clusters[1].unwrap_or_default();
        assert!(((1.0 - high).powi(2) - 0.05).abs() < 1e-12 && of_clusters[0] == Some(0.0));
    }

    /// In the mean over many samples, 90 % of all lie between the 5th and the 95th percentile of 128 draws.
    #[test]
    fn a_further_draw_lies_between_the_percentiles_as_often_as_is_stated() {
        let mut inside = 0.0;
        for repetition in 0..200 {
            let quantiles = Bootstrap::new(&[0; 128]).quantiles(&sample(20_000 + repetition, 128));
            let [low, high] = [quantiles.p05, quantiles.p95].map(|own| own.value.unwrap_or_default());
            inside += normal::cumulative(high) - normal::cumulative(low);
        }
        // Standard deviation of the mean 0.0019.
        assert!((inside / 200.0 - 0.9).abs() < 0.005, "{}", inside / 200.0);
    }

    #[test]
    fn levels_of_twice_the_weight_count_as_two() {
        let levels: Vec<f64> = sample(3, 400);
        let weights: Vec<f64> = (0..400).map(|draw| f64::from(1 + draw % 2)).collect();
        let mut twice: Vec<f64> = levels.clone();
        twice.extend(
            levels
                .iter()
                .enumerate()
                .filter(|(draw, _)| draw % 2 == 1)
                .map(|(_, level)| *level),
        );
        twice.sort_by(f64::total_cmp);
        for p in [0.05, 0.5, 0.95] {
            assert_near(
                weighted_quantiles(&levels, &weights, p),
                quantile(&twice, p),
                0.03,
                "quantile",
            );
        }
    }

    #[test]
    fn quantiles_of_resamples_of_one_value_are_that_value() {
        let quantiles = Bootstrap::new(&[0; 5]).quantiles(&[98.5; 5]);
        for estimate in [quantiles.p05, quantiles.p50, quantiles.p95] {
            assert_eq!((estimate.value, estimate.interval), (Some(98.5), [Some(98.5); 2]));
        }
    }
}
