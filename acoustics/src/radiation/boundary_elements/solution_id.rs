//! The solution of the boundary elements that a stored value belongs to.

use serde::{Deserialize, Serialize};

/// Identifies a solution by a hash of its frequencies and velocities: another computation of the same body may give
/// modes of other signs.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct SolutionId(u64);

impl SolutionId {
    /// FNV-1a (Fowler, Noll and Vo) over 64-bit words. Computed here, because the value is stored and the hasher of the
    /// standard library may change between its releases.
    pub(crate) fn add(&mut self, numbers: &[f64]) {
        for number in numbers {
            self.0 = (self.0 ^ number.to_bits()).wrapping_mul(0x0100_0000_01b3);
        }
    }
}
