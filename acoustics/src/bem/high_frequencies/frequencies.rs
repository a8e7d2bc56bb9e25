//! Frequencies above those solved one by one: bands over which boundary elements are averaged, and frequencies at which
//! the high-frequency limit is evaluated.

use crate::bem::high_frequencies::faces::Faces;
use crate::bem::solver::problem::{Exterior, Patterns};
use crate::radiation::Resistance;
use nalgebra::DMatrix;

/// Bands over which boundary elements are averaged, a sixth of an octave each.
const MEANS: usize = 3;

/// Width of such a band in octaves, and number of frequencies solved in it.
const MEAN_OCTAVES: f64 = 1.0 / 6.0;
const MEAN_SAMPLES: usize = 3;

/// Octaves between neighbouring evaluations of the high-frequency limit; each is averaged over the same width.
const LIMIT_OCTAVES: f64 = 1.0 / 3.0;

/// Number of evaluations of the limit at and below the top of single frequencies, where it is compared with boundary
/// elements.
const COMPARED: i32 = 2;

/// Highest frequency at which the limit is evaluated \[Hz\]; it is constant above.
const FARTHEST: f64 = 10e3;

/// Frequencies above the top of the boundary elements at single frequencies \[Hz\].
#[derive(Clone, Copy, Debug)]
pub(crate) struct HighFrequencies {
    top: f64,
}

impl HighFrequencies {
    /// Number of bands of [`HighFrequencies::solved`].
    pub(crate) const MEANS: usize = MEANS;

    /// Number of frequencies of [`HighFrequencies::solved`].
    pub(crate) const COUNT: usize = MEANS * MEAN_SAMPLES;

    pub(crate) fn new(top_hz: f64) -> Self {
        Self { top: top_hz }
    }

    /// Upper end of the averaged boundary elements \[Hz\].
    pub(crate) fn solved_to_hz(&self) -> f64 {
        self.above(MEANS as f64 * MEAN_OCTAVES)
    }

    /// Centres of the averaging bands, and the frequencies solved in each \[Hz\].
    pub(crate) fn solved(&self) -> Vec<(f64, Vec<f64>)> {
        let range = |i: usize| {
            let at = |share: f64| self.above((i as f64 + share) * MEAN_OCTAVES);
            let sample = |j: usize| at((j as f64 + 0.5) / MEAN_SAMPLES as f64);
            (at(0.5), (0..MEAN_SAMPLES).map(sample).collect())
        };
        (0..MEANS).map(range).collect()
    }

    /// Centre of the last averaging band \[Hz\].
    fn last(&self) -> f64 {
        self.above((MEANS as f64 - 0.5) * MEAN_OCTAVES)
    }

    /// Frequencies at which the limit is compared with boundary elements \[Hz\].
    fn compared(&self) -> Vec<f64> {
        let below = (-COMPARED..=0).map(|i| self.above(f64::from(i) * LIMIT_OCTAVES));
        below.chain([self.last()]).collect()
    }

    /// Frequencies above boundary elements at which the limit is evaluated \[Hz\].
    fn limit(&self) -> Vec<f64> {
        let count = ((FARTHEST / self.last()).log2() / LIMIT_OCTAVES).ceil().max(1.0) as usize;
        (1..=count)
            .map(|i| self.last() * 2f64.powf(i as f64 * LIMIT_OCTAVES))
            .collect()
    }

    fn above(&self, octaves: f64) -> f64 {
        self.top * 2f64.powf(octaves)
    }
}

/// The high-frequency limit of one parity: frequency \[Hz\], and resistance of every patch.
pub(crate) struct Limit {
    /// At the frequencies of comparison with boundary elements.
    pub(crate) below: Vec<(f64, Vec<Resistance>)>,
    /// At the frequencies above boundary elements.
    pub(crate) above: Vec<(f64, Vec<Resistance>)>,
}

/// The limit of all parities. The last patch, added to those of the boundary, radiates nothing.
pub(crate) fn limits(problem: &Exterior, motions: &[Patterns], ladder: &HighFrequencies) -> Vec<Limit> {
    let air = problem.air();
    let faces = Faces::new(problem.boundary(), air.sound_speed / ladder.solved_to_hz());
    let (mut below, mut above) = (ladder.compared(), ladder.limit());
    if faces.is_empty() {
        // It does not depend on frequency.
        below.truncate(1);
        above.truncate(1);
    }
    let around = |&hz: &f64| {
        [
            hz * 2f64.powf(-0.5 * LIMIT_OCTAVES),
            hz * 2f64.powf(0.5 * LIMIT_OCTAVES),
        ]
    };
    let ranges: Vec<[f64; 2]> = below.iter().chain(&above).map(around).collect();
    let of_parity = |found: Vec<Vec<DMatrix<f64>>>| {
        let with_rest = |patches: Vec<DMatrix<f64>>| {
            let rest = patches.first().map(|r| r.scale(0.0));
            let resistance = |real| Resistance { real, imaginary: None };
            patches.into_iter().chain(rest).map(resistance).collect()
        };
        let mut nodes: Vec<(f64, Vec<Resistance>)> = below
            .iter()
            .chain(&above)
            .copied()
            .zip(found.into_iter().map(with_rest))
            .collect();
        let above = nodes.split_off(below.len());
        Limit { below: nodes, above }
    };
    faces
        .resistances(motions, &ranges, air)
        .into_iter()
        .map(of_parity)
        .collect()
}
