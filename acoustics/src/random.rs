//! Reproducible random numbers: each is a function of its indices.

/// A number in \[0, 1) for the place (`first`, `second`) of the sequence `seed`.
///
/// It depends on nothing else, so that the order of evaluation does not matter. The three values are mixed by the
/// finaliser of SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number generators", 2014).
pub fn uniform(seed: u64, first: u64, second: u64) -> f64 {
    let bits = mix(mix(mix(seed).wrapping_add(first)).wrapping_add(second));
    (bits >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
}

fn mix(state: u64) -> u64 {
    let z = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mixer_is_splitmix64() {
        // First two outputs of the published generator for the state 1234567.
        assert_eq!(mix(1_234_567), 6_457_827_717_110_365_317);
        assert_eq!(
            mix(1_234_567_u64.wrapping_add(0x9E37_79B9_7F4A_7C15)),
            3_203_168_211_198_807_973
        );
    }

    #[test]
    fn numbers_are_uniform_and_independent_of_each_other() {
        const N: u64 = 40_000;
        let (mut sum, mut square, mut product) = (0.0, 0.0, 0.0);
        for place in 0..N {
            let (a, b) = (uniform(1, place, 7) - 0.5, uniform(1, place, 8) - 0.5);
            (sum, square, product) = (sum + a, square + a * a, product + a * b);
        }
        // Three standard errors of mean, variance and covariance of uniform numbers.
        let n = N as f64;
        assert!((sum / n).abs() < 3.0 * (1.0 / 12.0 / n).sqrt());
        assert!((square / n - 1.0 / 12.0).abs() < 3.0 * (1.0 / 180.0 / n).sqrt());
        assert!((product / n).abs() < 3.0 / 12.0 / n.sqrt());
    }
}
