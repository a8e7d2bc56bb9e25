//! Counter-based random numbers: each is a function of its indices, so that results depend neither on threads nor on
//! interruptions.

use crate::normal;

/// The random numbers of one particle in one move, or of any other list of indices.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stream {
    key: u64,
}

/// The finaliser of SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number generators", 2014).
fn mixed(x: u64) -> u64 {
    let x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}

impl Stream {
    /// Creates the stream of a seed and indices.
    pub(crate) fn new(seed: u64, indices: &[u64]) -> Self {
        let key = indices
            .iter()
            .fold(mixed(seed), |key, index| mixed(key.wrapping_add(*index)));
        Self { key }
    }

    /// Random number `counter`, uniform in (0, 1).
    pub(crate) fn uniform(self, counter: u64) -> f64 {
        let bits = mixed(self.key.wrapping_add(mixed(counter))) >> 11;
        (bits as f64 + 0.5) / (1_u64 << 53) as f64
    }

    /// Random number `counter`, standard normal.
    pub(crate) fn normal(self, counter: u64) -> f64 {
        normal::quantile(self.uniform(counter))
    }

    /// A gamma-distributed number of unit scale and shape >= 1, drawn with the counters from `counter` upwards
    /// (Marsaglia and Tsang, "A simple method for generating gamma variables", ACM Transactions on Mathematical
    /// Software 26, 363 (2000)).
    pub(crate) fn gamma(self, shape: f64, counter: u64) -> f64 {
        let d = shape - 1.0 / 3.0;
        let c = 1.0 / (9.0 * d).sqrt();
        let mut next = counter;
        loop {
            let (x, u) = (self.normal(next), self.uniform(next + 1));
            next += 2;
            let v = (1.0 + c * x).powi(3);
            if v > 0.0 && u.ln() < 0.5 * x * x + d - d * v + d * v.ln() {
                return d * v;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean and variance of a sequence of random numbers.
    fn moments(number: impl Fn(u64) -> f64) -> [f64; 2] {
        const N: u64 = 100_000;
        let mean = (0..N).map(&number).sum::<f64>() / N as f64;
        let variance = (0..N).map(|k| (number(k) - mean).powi(2)).sum::<f64>() / N as f64;
        [mean, variance]
    }

    #[test]
    fn normal_numbers_have_mean_0_and_variance_1_over_counters_and_over_streams() {
        let stream = Stream::new(1, &[2, 3]);
        for [mean, variance] in [
            moments(|k| stream.normal(k)),
            moments(|k| Stream::new(1, &[2, k]).normal(7)),
        ] {
            assert!(mean.abs() < 0.01 && (variance - 1.0).abs() < 0.015, "{mean} {variance}");
        }
    }

    #[test]
    fn gamma_numbers_have_their_shape_as_mean_and_variance() {
        for shape in [2.5, 6.0] {
            let [mean, variance] = moments(|k| Stream::new(5, &[k]).gamma(shape, 0));
            assert!((mean / shape - 1.0).abs() < 0.01 && (variance / shape - 1.0).abs() < 0.03);
        }
    }

    #[test]
    fn streams_of_other_indices_differ() {
        let first = |indices: &[u64]| Stream::new(1, indices).uniform(0);
        assert!(first(&[1, 2]) != first(&[2, 1]) && first(&[1]) != first(&[1, 0]));
    }
}
