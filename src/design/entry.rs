//! Everything known about one key of a design.

use nailnoise_quantities::Value;

use super::distribution::Distribution;
use super::provenance::Provenance;
use super::range::RangeOrigin;

/// Everything known about one key of a design.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Entry {
    /// Full name, such as `piston.mass`.
    pub key: String,
    /// Symbol in the thesis or in common use; empty if there is none.
    pub symbol: &'static str,
    /// Value, quantities in SI units.
    pub value: Value,
    /// SI unit; empty for plain numbers, counts, switches and choices.
    pub unit: String,
    /// Range of plausible values, in SI units; the ends are equal for an exact value.
    pub range: Option<[f64; 2]>,
    /// Origin of the range; none without one.
    pub range_origin: Option<RangeOrigin>,
    /// Distribution over the range.
    #[serde(skip)]
    pub distribution: Distribution,
    /// Origin of the value.
    pub provenance: Provenance,
    /// The source in words; may be empty.
    pub source: String,
    /// A remark; may be empty.
    pub note: String,
    /// The file that gives the value.
    pub file: String,
    /// The line in that file, from 1.
    pub line: usize,
}
