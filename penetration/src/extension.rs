//! Extends the laws to fasteners outside the tested sizes: one share of the force scales with the shank's perimeter,
//! the rest with its area.
//!
//! The published laws depend on the diameter only through the ratio D/NL, because each length was tested with one
//! diameter (Nili Ahmadabadi 2016: from 2.0 mm with 32 mm to 4.1 mm with 89 mm). For a slender nail they extrapolate
//! this correlation between the test parameters: a 64 x 1.6 mm nail would need more force than a 64 x 3.3 mm one.
//! Outside the tested sizes, the force is therefore that of the nearest tested size, of diameter D* and length NL*,
//! scaled by r = D/D*. It is split as measured in second drives into the same hole (sec. 2.4.3):
//!
//! ```text
//! F(y) = r S(y) + r^2 (F*(y) - S(y)),    S(y) = min(phi F*(NL*) y/NL*, F*(y))       y <= NL*
//! F(y) = r phi F*(NL*) y/NL* + r^2 (1 - phi) F*(NL*)                                 y > NL*
//! ```
//! S is friction along the shank, which scales with perimeter and depth; the rest deforms and splits the fibres over
//! the shank's cross-section. F is continuous in D, NL and y, and equals F* at the boundary of the tested sizes. These
//! are the diameters 2.03 to 4.06 mm with lengths within a factor of [`LENGTH_FACTOR`] of the line through the tested
//! ones. The share phi is `wood.friction_share`; at its limits, the force scales with the perimeter only (1) or with
//! the area only (0).

use super::law::Curve;
use super::{ForceTable, NAILS, Specimen};

/// Number of table intervals over the nail's length. The error of the cubic between points is below 2e-4 of the force
/// and, next to the surface, below 0.05 N.
const INTERVALS: u32 = 400;

/// Largest factor between a length and the line through the tested sizes. All tested nails lie within it, those with
/// helical shanks at its limit.
pub const LENGTH_FACTOR: f64 = 1.25;

/// Diameters of the tested nails with the mean length tested with each, thinnest first \[m\].
fn tested_sizes() -> Vec<[f64; 2]> {
    let mut sizes: Vec<[f64; 2]> = Vec::new();
    for nail in NAILS {
        let lengths = NAILS.iter().filter(|other| other.diameter == nail.diameter);
        let (sum, count) = lengths.fold((0.0, 0.0), |(sum, count), other| (sum + other.length, count + 1.0));
        sizes.push([nail.diameter, sum / count]);
    }
    sizes.sort_by(|a, b| a[0].total_cmp(&b[0]));
    sizes.dedup();
    sizes
}

/// Length \[m\] on the line through the tested sizes at a diameter, which is clamped to the tested range.
fn tested_length(diameter: f64) -> f64 {
    let sizes = tested_sizes();
    let above = sizes.partition_point(|[d, _]| *d < diameter).clamp(1, sizes.len() - 1);
    let ([d0, l0], [d1, l1]) = (sizes[above - 1], sizes[above]);
    l0 + (l1 - l0) * ((diameter - d0) / (d1 - d0)).clamp(0.0, 1.0)
}

impl Specimen {
    /// The nearest tested size in this wood; none if the nail itself is within the tested sizes.
    pub fn nearest_tested(&self) -> Option<Self> {
        let diameters = NAILS.map(|nail| nail.diameter);
        let thinnest = diameters.into_iter().fold(f64::INFINITY, f64::min);
        let thickest = diameters.into_iter().fold(0.0, f64::max);
        let diameter = self.diameter.clamp(thinnest, thickest);
        let line = tested_length(diameter);
        let length = self.length.clamp(line / LENGTH_FACTOR, line * LENGTH_FACTOR);
        let inside = diameter == self.diameter && length == self.length;
        (!inside).then_some(Self {
            length,
            diameter,
            ..*self
        })
    }
}

/// Force over depth of a nail outside the tested sizes, derived from the law of the nearest tested one.
///
/// `friction_share` is phi, friction along the shank as a fraction of the force at full depth.
pub(crate) fn extended(tested: &Curve, size: &Specimen, nail: &Specimen, friction_share: f64) -> Option<ForceTable> {
    let ratio = nail.diameter / size.diameter;
    let full = tested.force(size.length);
    let force = |depth: f64| {
        let friction = friction_share * full * depth / size.length;
        if depth > size.length {
            return ratio * friction + ratio * ratio * (1.0 - friction_share) * full;
        }
        // The law is discontinuous at the surface, so the first point lies just below it.
        let whole = tested.force(depth.max(1e-9 * size.length));
        let friction = friction.min(whole);
        ratio * friction + ratio * ratio * (whole - friction)
    };
    let depths: Vec<f64> = (0..=INTERVALS)
        .map(|i| nail.length * f64::from(i) / f64::from(INTERVALS))
        .collect();
    let forces = depths.iter().map(|&depth| force(depth)).collect();
    ForceTable::new(depths, forces).ok()
}
