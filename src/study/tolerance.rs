//! Conclusions from a few draws about further ones, for any continuous distribution.
//!
//! ```text
//! P(next one within the range of n) = (n - 1)/(n + 1)
//! P(the range contains a share b of all) = 1 - n b^(n-1) + (n - 1) b^n
//! ```
//!
//! S. S. Wilks, "Determination of sample sizes for setting tolerance limits", Ann. Math. Statist. 12, 91 (1941). The
//! draws must be independent. Those of a study are evenly distributed candidates of which only some count, which is
//! nearly the same.

/// Minimum number of draws for stating percentiles, probabilities and K; with fewer, their range is stated. On average,
/// 1.6 of 32 draws are beyond the 5th or the 95th percentile.
pub const STATED_FROM: usize = 32;

/// Confidence of a tolerance interval.
pub const CONFIDENCE: f64 = 0.9;

/// Probability that the next draw is within the range of `n` draws.
pub fn next_within(n: usize) -> f64 {
    match n {
        0 => 0.0,
        n => (n as f64 - 1.0) / (n as f64 + 1.0),
    }
}

/// Confidence with which the range of `n` draws contains the fraction `content` of all.
pub fn confidence(n: usize, content: f64) -> f64 {
    let draws = n as f64;
    1.0 - draws * content.powf(draws - 1.0) + (draws - 1.0) * content.powf(draws)
}

/// Fraction of all draws that the range of `n` contains with a confidence of [`CONFIDENCE`]; `None` for fewer than two
/// draws.
pub fn content(n: usize) -> Option<f64> {
    if n < 2 {
        return None;
    }
    // The confidence decreases as the content increases.
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if confidence(n, middle) > CONFIDENCE {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(low)
}

/// Number of draws whose range contains the fraction `content` of all with a confidence of [`CONFIDENCE`].
pub fn draws_for(content: f64) -> usize {
    (2..)
        .find(|&n| confidence(n, content) >= CONFIDENCE)
        .unwrap_or(usize::MAX)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::decibels::energy_sum;
    use crate::study::normal;
    use nailnoise_acoustics::random::uniform;

    const SEEDS: u64 = 200;

    /// Levels as functions of their quantile: normal, exponential towards silence, sum of two energies.
    const LEVELS: [fn(f64, f64) -> f64; 3] = [
        |u, _| 95.0 + 4.0 * normal::quantile(u),
        |u, _| 95.0 + 6.0 * u.ln(),
        |u, v| energy_sum([93.0 + 3.0 * normal::quantile(u), 90.0 + 5.0 * normal::quantile(v)]),
    ];

    fn number(seed: u64, stream: u64, place: u64) -> f64 {
        uniform(seed, stream, place).clamp(1e-12, 1.0 - 1e-12)
    }

    fn level(of: fn(f64, f64) -> f64, seed: u64, place: u64) -> f64 {
        of(number(seed, 1, place), number(seed, 2, place))
    }

    fn range(of: fn(f64, f64) -> f64, seed: u64, n: u64) -> [f64; 2] {
        let levels = || (0..n).map(|place| level(of, seed, place));
        [
            levels().fold(f64::INFINITY, f64::min),
            levels().fold(f64::NEG_INFINITY, f64::max),
        ]
    }

    /// Within 2.6 standard deviations of the binomial distribution, which 1 % of true statements exceed.
    fn assert_share(count: usize, trials: usize, expected: f64) {
        let (n, deviation) = (trials as f64, (expected * (1.0 - expected) / trials as f64).sqrt());
        let found = count as f64 / n;
        assert!(
            (found - expected).abs() < 2.6 * deviation,
            "{found} of {trials}, stated {expected}"
        );
    }

    #[test]
    fn the_next_draw_lies_within_the_range_as_often_as_is_stated() {
        for of in LEVELS {
            for n in [8, 16, 31] {
                let inside = (0..SEEDS).filter(|&seed| {
                    let [low, high] = range(of, seed, n);
                    (low..=high).contains(&level(of, seed, n))
                });
                assert_share(inside.count(), SEEDS as usize, next_within(n as usize));
            }
        }
    }

    /// The fraction of 2000 further draws that a range contains is at least the stated one with the stated confidence.
    #[test]
    fn a_range_contains_the_stated_share_with_the_stated_confidence() {
        for of in LEVELS {
            for n in [8, 31] {
                let stated = content(n as usize).unwrap();
                let contains = (0..SEEDS).filter(|&seed| {
                    let [low, high] = range(of, seed, n);
                    let further = (n..n + 2000).filter(|&place| (low..=high).contains(&level(of, seed, place)));
                    further.count() as f64 / 2000.0 >= stated
                });
                assert_share(contains.count(), SEEDS as usize, CONFIDENCE);
            }
        }
    }

    /// Sample sizes of Wilks (1941), as tabulated since then: 38 for 90 % with 90 %, 77 for 95 % with 90 %.
    #[test]
    fn draws_that_a_statement_needs_are_the_tabulated_ones() {
        assert_eq!([0.9, 0.95].map(draws_for), [38, 77]);
        assert!((confidence(38, content(38).unwrap()) - CONFIDENCE).abs() < 1e-9);
        assert!((next_within(8) - 7.0 / 9.0).abs() < 1e-15);
        assert_eq!(content(1), None);
    }
}
