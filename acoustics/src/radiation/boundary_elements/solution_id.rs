//! Identifies the boundary-element solution to which a stored value belongs.

use serde::{Deserialize, Serialize};

/// A hash of the frequencies and velocities of a solution: another computation of the same body may give modes with
/// opposite signs.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct SolutionId(u64);

impl SolutionId {
    /// FNV-1a (Fowler, Noll and Vo) over 64-bit words. Implemented here, because the value is stored and the standard
    /// library's hasher may change between releases.
    pub(crate) fn add(&mut self, numbers: &[f64]) {
        for number in numbers {
            self.0 = (self.0 ^ number.to_bits()).wrapping_mul(0x0100_0000_01b3);
        }
    }
}
