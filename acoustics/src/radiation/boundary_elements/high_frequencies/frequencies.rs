//! Frequencies of the high-frequency limit: above boundary elements, and within their range for comparison.

use super::faces::Faces;
use super::mean_bands::MeanBands;
use crate::bem::solve::neumann::Patterns;
use crate::bem::solve::problem::Exterior;
use crate::radiation::Resistance;
use nalgebra::DMatrix;

/// Spacing of the evaluations of the high-frequency limit in octaves; each is averaged over the same width.
const LIMIT_OCTAVES: f64 = 1.0 / 3.0;

/// Number of evaluations of the limit at and below the upper end of single frequencies, for comparison with boundary
/// elements.
const COMPARED: i32 = 2;

/// Highest frequency at which the limit is evaluated \[Hz\]; it is constant above.
const FARTHEST: f64 = 10e3;

/// Frequencies at which the limit is compared with boundary elements \[Hz\]. The last one is the centre of the last
/// averaging band; the others are at least half their spacing below it.
fn compared(bands: &MeanBands) -> Vec<f64> {
    let last = bands.last_octaves();
    let octaves = (-COMPARED..).map(|i| f64::from(i) * LIMIT_OCTAVES);
    let below = octaves.take_while(|octaves| *octaves <= f64::max(last - 0.5 * LIMIT_OCTAVES, 0.0));
    below.chain([last]).map(|octaves| bands.above(octaves)).collect()
}

/// Frequencies above boundary elements at which the limit is evaluated \[Hz\].
fn above(bands: &MeanBands) -> Vec<f64> {
    let last = bands.above(bands.last_octaves());
    let count = ((FARTHEST / last).log2() / LIMIT_OCTAVES).ceil().max(1.0) as usize;
    (1..=count)
        .map(|i| last * 2f64.powf(i as f64 * LIMIT_OCTAVES))
        .collect()
}

/// The high-frequency limit of one parity: frequency \[Hz\], and resistance of each patch.
pub(crate) struct Limit {
    /// At the frequencies for comparison with boundary elements.
    pub(crate) below: Vec<(f64, Vec<Resistance>)>,
    /// At the frequencies above boundary elements.
    pub(crate) above: Vec<(f64, Vec<Resistance>)>,
}

/// The limit of all parities. The last patch, which is added to those of the boundary, radiates nothing. A porous cover
/// changes the power of each point as that of a plane wave; phase differences between covered and bare faces are
/// neglected.
pub(crate) fn limits(problem: &Exterior, motions: &[Patterns], bands: &MeanBands) -> Vec<Limit> {
    let air = problem.air();
    let faces = Faces::new(problem.boundary(), air.sound_speed / bands.upper_hz());
    let (mut below, mut above) = (compared(bands), above(bands));
    if faces.is_empty() && problem.cover().is_none() {
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
    let found = match problem.cover() {
        None => faces.resistances(motions, &ranges, air),
        Some(cover) => {
            let mut found: Vec<Vec<Vec<DMatrix<f64>>>> = motions.iter().map(|_| Vec::new()).collect();
            for (range, hz) in ranges.iter().zip(below.iter().chain(&above)) {
                let equivalent = |p: &Patterns| Patterns {
                    parity: p.parity,
                    velocities: cover.equivalent(&p.velocities, *hz, air),
                };
                let motions: Vec<Patterns> = motions.iter().map(equivalent).collect();
                let of_range = faces.resistances(&motions, std::slice::from_ref(range), air);
                found.iter_mut().zip(of_range).for_each(|(all, own)| all.extend(own));
            }
            found
        }
    };
    found.into_iter().map(of_parity).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_is_compared_every_third_of_an_octave_up_to_the_last_band() {
        let of = |to: Option<f64>| {
            let octaves = compared(&MeanBands::new(1000.0, to))
                .into_iter()
                .map(|hz| (hz / 1000.0).log2());
            octaves
                .map(|octaves| (60.0 * octaves).round() / 60.0)
                .collect::<Vec<f64>>()
        };
        let third = 20.0 / 60.0;
        assert_eq!(of(None), [-2.0 * third, -third, 0.0, 25.0 / 60.0]);
        assert_eq!(
            of(Some(2000.0)),
            [-2.0 * third, -third, 0.0, third, 2.0 * third, 55.0 / 60.0]
        );
    }

    #[test]
    fn the_limit_takes_over_a_third_of_an_octave_above_the_last_band() {
        for to in [None, Some(8e3), Some(20e3)] {
            let bands = MeanBands::new(2443.0, to);
            let last = bands.above(bands.last_octaves());
            assert!((above(&bands)[0] / last).log2() - LIMIT_OCTAVES < 1e-12);
        }
    }
}
