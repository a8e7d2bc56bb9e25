//! Which inputs decide a level: first-order contributions to its variance, from the draws themselves.
//!
//! S_i = Var E[Y|X_i]/Var Y. The draws are put into bins of equal counts along an input; the variance between the bins' means
//! estimates Var E[Y|X_i]. Means of finite bins scatter even where the input does nothing, by (M - 1)/(n - 1) of the variance in
//! the mean, which is taken off (Kelley, "An unbiased correlation ratio measure", PNAS 21, 554 (1935)).
//!
//! Of many inputs some seem to matter by chance. An estimate counts where it is above what the *largest* of all inputs reaches in
//! 19 of 20 random pairings of levels with inputs.

use nailnoise_acoustics::random::uniform;
use rayon::prelude::*;

/// Random pairings.
const PERMUTATIONS: usize = 400;

/// Part of them that may reach the limit.
const CHANCE: f64 = 0.05;

/// Fewest draws from which contributions are estimated.
pub(super) const FEWEST: usize = 40;

/// Most bins.
const MOST_BINS: usize = 32;

const SEED: u64 = 0xC047_121B;

/// An input in bins along its values.
pub(super) struct Binned {
    /// Bin of each draw, below [`MOST_BINS`].
    bins: Vec<u8>,
    count: usize,
}

impl Binned {
    /// Puts draws into about sqrt(n) bins of equal counts; draws of equal values share a bin. None for a constant input.
    pub(super) fn new(values: &[f64]) -> Option<Self> {
        let n = values.len();
        let wanted = (n as f64).sqrt().round().clamp(2.0, MOST_BINS as f64) as usize;
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
        let mut bins = vec![0; n];
        let (mut bin, mut first) = (0, 0);
        for (place, pair) in order.windows(2).enumerate() {
            bins[pair[0]] = bin;
            let full = (place + 1) * wanted >= (usize::from(bin) + 1) * n;
            if full && place + 1 > first && values[pair[1]] > values[pair[0]] {
                (bin, first) = (bin + 1, place + 1);
            }
            bins[pair[1]] = bin;
        }
        // A bin that ties made wide skips the numbers of those that it swallowed.
        let mut used: Vec<u8> = bins.clone();
        used.sort_unstable();
        used.dedup();
        (used.len() > 1).then_some(Self {
            bins,
            count: usize::from(bin) + 1,
        })
    }

    /// S of levels, which may be below 0 for an input that does nothing.
    pub(super) fn first_order(&self, levels: &[f64]) -> f64 {
        let n = levels.len() as f64;
        let mean = levels.iter().sum::<f64>() / n;
        let (mut sums, mut counts) = (vec![0.0; self.count], vec![0.0; self.count]);
        for (&bin, level) in self.bins.iter().zip(levels) {
            sums[usize::from(bin)] += level - mean;
            counts[usize::from(bin)] += 1.0;
        }
        let total: f64 = levels.iter().map(|level| (level - mean).powi(2)).sum();
        if total == 0.0 {
            return 0.0;
        }
        let occupied = counts.iter().filter(|count| **count > 0.0).count() as f64;
        let between: f64 = sums
            .iter()
            .zip(&counts)
            .filter(|(_, count)| **count > 0.0)
            .map(|(sum, count)| sum * sum / count)
            .sum();
        let chance = (occupied - 1.0) / (n - 1.0);
        (between / total - chance) / (1.0 - chance)
    }
}

/// The estimate that the largest of all inputs exceeds by chance in one of twenty random pairings.
pub(super) fn by_chance(inputs: &[Binned], levels: &[f64]) -> f64 {
    let largest = |permutation: u64| {
        let mut shuffled = levels.to_vec();
        for last in (1..shuffled.len()).rev() {
            let other = (uniform(SEED, permutation, last as u64) * (last + 1) as f64) as usize;
            shuffled.swap(last, other);
        }
        inputs
            .iter()
            .map(|input| input.first_order(&shuffled))
            .fold(0.0, f64::max)
    };
    let mut largest: Vec<f64> = (0..PERMUTATIONS as u64).into_par_iter().map(largest).collect();
    largest.sort_by(f64::total_cmp);
    super::statistics::quantile(&largest, 1.0 - CHANCE)
}

/// Mean level of the draws in the upper third of an input's values, less that in the lower third \[dB\].
pub(super) fn effect(values: &[f64], levels: &[f64]) -> f64 {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let third = (values.len() / 3).max(1);
    let mean = |part: &[usize]| part.iter().map(|&draw| levels[draw]).sum::<f64>() / part.len() as f64;
    mean(&order[order.len() - third..]) - mean(&order[..third])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn inputs(n: u32, seed: u32) -> Vec<[f64; 3]> {
        let number = |index, dimension| f64::from(sobol_burley::sample(index, dimension, seed));
        (0..n)
            .map(|index| [0, 1, 2].map(|dimension| number(index, dimension)))
            .collect()
    }

    /// Ishigami and Homma 1990, a = 7, b = 0.1.
    fn ishigami(u: &[f64; 3]) -> f64 {
        let [x, y, z] = u.map(|u| std::f64::consts::PI * (2.0 * u - 1.0));
        x.sin() + 7.0 * y.sin().powi(2) + 0.1 * z.powi(4) * x.sin()
    }

    const EXPECTED: [f64; 3] = [0.313_905, 0.442_411, 0.0];

    fn estimates(n: u32, seed: u32) -> [f64; 3] {
        let points = inputs(n, seed);
        let levels: Vec<f64> = points.iter().map(ishigami).collect();
        [0, 1, 2].map(|input| {
            let values: Vec<f64> = points.iter().map(|point| point[input]).collect();
            Binned::new(&values).unwrap().first_order(&levels)
        })
    }

    #[test]
    fn first_order_indices_of_the_ishigami_function_are_the_analytic_ones() {
        let mut squares = [0.0; 3];
        for seed in 0..20 {
            let found = estimates(500, seed);
            for ((square, found), expected) in squares.iter_mut().zip(found).zip(EXPECTED) {
                *square += (found - expected).powi(2) / 20.0;
            }
        }
        assert!(squares.iter().all(|square| square.sqrt() < 0.045), "{squares:?}");
    }

    #[test]
    fn first_order_indices_of_an_energy_sum_are_those_by_quadrature() {
        let points = inputs(1 << 14, 3);
        let z = |u: f64| super::super::normal::quantile(u + 1e-9);
        let level = |u: &[f64; 3]| super::super::statistics::energy_sum([100.0 + 3.0 * z(u[0]), 97.0 + 4.0 * z(u[1])]);
        let levels: Vec<f64> = points.iter().map(level).collect();
        for (input, expected) in [0.580_996, 0.376_207].into_iter().enumerate() {
            let values: Vec<f64> = points.iter().map(|point| point[input]).collect();
            let found = Binned::new(&values).unwrap().first_order(&levels);
            assert!((found - expected).abs() < 0.01, "{input}: {found}");
        }
    }

    #[test]
    fn an_input_that_does_nothing_stays_below_what_chance_gives() {
        let mut above = 0;
        for seed in 0..40 {
            let points = inputs(200, seed);
            let levels: Vec<f64> = points.iter().map(ishigami).collect();
            let values: Vec<f64> = points.iter().map(|point| point[2]).collect();
            let input = [Binned::new(&values).unwrap()];
            above += usize::from(input[0].first_order(&levels) > by_chance(&input, &levels));
        }
        // One in twenty, or two in forty; seven or more have a probability of 0.3 %.
        assert!(above < 7, "{above} of 40");
    }

    #[test]
    fn an_input_of_few_values_has_a_bin_for_each() {
        let values: Vec<f64> = (0..90).map(|draw| f64::from(draw % 3)).collect();
        let levels: Vec<f64> = values.iter().map(|value| 90.0 + value).collect();
        let found = Binned::new(&values).unwrap().first_order(&levels);
        assert!((found - 1.0).abs() < 1e-9, "{found}");
        assert!(Binned::new(&[1.0; 50]).is_none());
    }
}
