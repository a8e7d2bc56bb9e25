//! Reproducible random numbers: each is a function of its indices.

use rand::{Rng, RngExt, SeedableRng};
use rand_xoshiro::SplitMix64;

/// A number in \[0, 1) at the position (`first`, `second`) of the sequence `seed`.
///
/// It depends only on these values, so the order of evaluation does not matter. The three values are mixed by
/// SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number generators", 2014): each is added to the
/// result of the previous ones.
pub fn uniform(seed: u64, first: u64, second: u64) -> f64 {
    let mixed = |key: u64| SplitMix64::seed_from_u64(key).next_u64();
    let key = mixed(mixed(seed).wrapping_add(first)).wrapping_add(second);
    SplitMix64::seed_from_u64(key).random()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_the_same_in_every_version() {
        // The last of three chained outputs of the published generator, with its upper 53 bits as a fraction.
        assert_eq!(uniform(1, 2, 3), 3_761_028_642_379_151.0 / (1_u64 << 53) as f64);
    }

    #[test]
    fn numbers_are_uniform_and_independent_of_each_other() {
        const N: u64 = 40_000;
        let (mut sum, mut square, mut product) = (0.0, 0.0, 0.0);
        for place in 0..N {
            let (a, b) = (uniform(1, place, 7) - 0.5, uniform(1, place, 8) - 0.5);
            (sum, square, product) = (sum + a, square + a * a, product + a * b);
        }
        // Three standard errors of the mean, variance and covariance of uniform numbers.
        let n = N as f64;
        assert!((sum / n).abs() < 3.0 * (1.0 / 12.0 / n).sqrt());
        assert!((square / n - 1.0 / 12.0).abs() < 3.0 * (1.0 / 180.0 / n).sqrt());
        assert!((product / n).abs() < 3.0 / 12.0 / n.sqrt());
    }
}
