//! Which solution of the boundary elements a kept value belongs to.

use serde::{Deserialize, Serialize};

/// Distinguishes solutions by a hash of frequencies and velocities: of the same body, the modes of another computation may have
/// other signs.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct SolutionId(u64);

impl SolutionId {
    /// FNV-1a (Fowler, Noll and Vo) over whole numbers; the hasher of the standard library may differ between its releases,
    /// and this one is kept.
    pub(crate) fn add(&mut self, numbers: &[f64]) {
        for number in numbers {
            self.0 = (self.0 ^ number.to_bits()).wrapping_mul(0x0100_0000_01b3);
        }
    }
}
