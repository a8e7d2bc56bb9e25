//! Reproducible start vectors.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::SplitMix64;

/// SplitMix64 (Steele, Lea & Flood 2014), uniform on \[-1, 1).
pub(crate) struct Random(SplitMix64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(SplitMix64::seed_from_u64(seed))
    }

    pub(crate) fn next(&mut self) -> f64 {
        2.0 * self.0.random::<f64>() - 1.0
    }
}
