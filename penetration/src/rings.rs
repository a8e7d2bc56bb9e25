//! Growth rings: the resistance to the tip rises in the dense latewood of each ring and falls in its earlywood.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_xoshiro::SplitMix64;

use super::dual::Real;
use super::wood::NailedWood;

/// Largest deviation of a ring's width from the mean, relative to the mean: 3 to 5 mm about 4 mm.
const SPREAD: f64 = 0.25;

/// Factor on the force of the tip over its depth z.
///
/// ```text
/// 1 - a cos(2 pi (z - z_i)/s_i)     for z_i <= z < z_i + s_i = z_(i+1)
/// ```
///
/// The widths s_i are uniform between 0.75 and 1.25 of their mean, and the surface lies anywhere in the first ring. The
/// factor and its derivative are continuous; its mean over each ring is 1, so it does not change the work of the law.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct GrowthRings {
    amplitude: f64,
    /// z_i, from at or above the surface to beyond the nail's length \[m\].
    starts: Vec<f64>,
}

impl GrowthRings {
    /// The rings that a nail of this length \[m\] crosses; none if the amplitude is zero.
    pub(super) fn new(wood: &NailedWood, length: f64) -> Option<Self> {
        let amplitude = wood.ring_amplitude;
        if amplitude == 0.0 {
            return None;
        }
        let mut random = SplitMix64::seed_from_u64(wood.ring_seed.into());
        let mut width = || wood.ring_width * (1.0 + SPREAD * (2.0 * random.random::<f64>() - 1.0));
        let first = width();
        let mut starts = vec![-first * width() / (wood.ring_width * (1.0 + SPREAD))];
        let mut end = starts[0] + first;
        while end <= length {
            starts.push(end);
            end += width();
        }
        starts.push(end);
        Some(Self { amplitude, starts })
    }

    /// The force of the tip in the rings, from that without them.
    #[inline]
    pub(super) fn on_tip<S: Real>(&self, tip: S, z: S) -> S {
        let last = self.starts.len() - 2;
        let ring = self.starts.partition_point(|start| *start <= z.value());
        let ring = ring.saturating_sub(1).min(last);
        let (start, width) = (self.starts[ring], self.starts[ring + 1] - self.starts[ring]);
        let phase = TAU * (z.value() - start) / width;
        let factor = 1.0 - self.amplitude * phase.cos();
        tip * z.chain(factor, self.amplitude * TAU / width * phase.sin())
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::{Dual, PenetrationLaw, ResistanceLaw, Wood};

    const LENGTH: f64 = 82.55e-3;

    fn wood(amplitude: f64, seed: u32) -> NailedWood {
        let wood = Wood {
            density: 429.0,
            hardness_modulus: 3.8e5,
            penetration_law: ResistanceLaw::Published(PenetrationLaw::SolidWood),
            speed_term: -122.9,
            slenderness_term: -1.15,
            penetration_force: 0.0,
            resistance_scale: 1.0,
            head_stiffness_scale: 1.0,
            unloading_stiffness: 1e7,
        };
        NailedWood {
            ring_amplitude: amplitude,
            ring_width: 4e-3,
            ring_seed: seed,
            ..NailedWood::quasi_static(wood)
        }
    }

    #[test]
    fn rings_are_3_to_5_mm_wide_and_follow_from_the_seed() {
        let of = |seed| GrowthRings::new(&wood(0.2, seed), LENGTH).unwrap();
        for seed in 1..50 {
            let rings = of(seed);
            assert_eq!(rings, of(seed));
            assert_ne!(rings, of(seed + 1));
            assert!(
                (-5e-3..=0.0).contains(&rings.starts[0]) && rings.starts[1] > 0.0,
                "{:?}",
                rings.starts
            );
            assert!(rings.starts[rings.starts.len() - 1] > LENGTH);
            for pair in rings.starts.windows(2) {
                assert!((3e-3..=5e-3).contains(&(pair[1] - pair[0])), "{pair:?}");
            }
        }
        assert!(GrowthRings::new(&wood(0.0, 1), LENGTH).is_none());
    }

    #[test]
    fn the_mean_over_a_ring_is_the_force_without_rings() {
        let rings = GrowthRings::new(&wood(0.2, 7), LENGTH).unwrap();
        let (a, b) = (rings.starts[3], rings.starts[4]);
        let count = 1000;
        let at = |i: i32| rings.on_tip(500.0, a + (b - a) * (f64::from(i) + 0.5) / f64::from(count));
        let forces: Vec<f64> = (0..count).map(at).collect();
        assert!((forces.iter().sum::<f64>() / f64::from(count) - 500.0).abs() < 1e-9);
        let [least, most] = [f64::min, f64::max].map(|of| forces.iter().copied().reduce(of).unwrap());
        assert!(
            (least - 400.0).abs() < 0.01 && (most - 600.0).abs() < 0.01,
            "{least} {most}"
        );
    }

    #[test]
    fn the_factor_is_smooth_and_has_its_derivative() {
        let rings = GrowthRings::new(&wood(0.2, 3), LENGTH).unwrap();
        let step = 1e-8;
        let starts = rings.starts[1..6].iter().copied();
        for z in starts.chain([0.0, 0.9e-3, 17.3e-3, 82e-3]) {
            let at = |z: f64| rings.on_tip(1.0, z);
            let slope = (at(z + step) - at(z - step)) / (2.0 * step);
            let dual = |value: f64, slope: f64| Dual { value, slope: [slope] };
            let found = rings.on_tip(dual(1.0, 0.0), dual(z, 1.0));
            assert!((found.value - at(z)).abs() < 1e-15);
            assert!((found.slope[0] - slope).abs() < 1e-2 * PI * 0.2 / 4e-3, "{z}: {slope}");
        }
    }
}
