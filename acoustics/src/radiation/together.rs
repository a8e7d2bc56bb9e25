//! Several radiation resistances sampled at the same frequencies, chosen one round after the other.

use super::interval::{Interval, check_range, leja_hz};
use super::resistance::Resistance;
use super::sampled::{Sample, SampledRadiation, Sampling};
use crate::error::{AcousticsError, positive};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Frequencies of a round, solved beside each other.
const ROUND: usize = 4;
/// Widest interval that one polynomial serves, as a ratio of frequencies: over more, small resistances fall by too many
/// powers of ten.
const WIDEST: f64 = 4.0;
/// Most that a round is trusted to have gained.
const GAIN: f64 = 0.1;

impl SampledRadiation {
    /// Samples several resistances that one solution gives together, as those of all parities of a body: `solve` returns
    /// R(f) of each and of every patch, `modes` counts the modes of each.
    ///
    /// Every interval begins with a few frequencies of Leja's sequence and goes on by rounds until the samples
    /// of a round lie within the tolerance of what the polynomial without them says. With them the error is smaller by
    /// what a round gains, and by a factor of ten at the most: this is the error stated.
    ///
    /// # Errors
    /// An empty range, a tolerance that is not positive, [`AcousticsError::Unresolved`], those of `solve`.
    pub fn together(
        method: &str,
        modes: &[usize],
        patches: &[String],
        sampling: &Sampling,
        solve: impl Fn(f64) -> Result<Vec<Vec<Resistance>>, AcousticsError> + Sync,
    ) -> Result<Vec<Self>, AcousticsError> {
        let [low, high] = sampling.range_hz;
        positive("interpolation tolerance", sampling.tolerance)?;
        check_range(sampling.range_hz)?;
        let pieces = ((high / low).ln() / WIDEST.ln()).ceil().max(1.0) as usize;
        let edge = |i: usize| match i {
            0 => low,
            i if i == pieces => high,
            i => low * (high / low).powf(i as f64 / pieces as f64),
        };
        let mut samples: Vec<Vec<Sample>> = vec![Vec::new(); modes.len()];
        let mut index = BTreeMap::<u64, usize>::new();
        let (mut intervals, mut error) = (Vec::new(), 0.0f64);
        for piece in 0..pieces {
            let (low, high) = (edge(piece), edge(piece + 1));
            let (mut count, mut previous) = (ROUND, f64::INFINITY);
            loop {
                let wanted = leja_hz(low, high, count);
                let new: Vec<f64> = wanted
                    .iter()
                    .copied()
                    .filter(|hz| !index.contains_key(&hz.to_bits()))
                    .collect();
                // One frequency at a time on a thread: they take equally long.
                let solved: Vec<_> = new.par_iter().with_max_len(1).map(|&hz| solve(hz)).collect();
                for (&hz, solved) in new.iter().zip(solved) {
                    index.insert(hz.to_bits(), index.len());
                    let inverse = (2.0 * PI * hz).powi(-2);
                    for (samples, patches) in samples.iter_mut().zip(solved?) {
                        let patches = patches.into_iter().map(|r| r.scaled(inverse)).collect();
                        samples.push(Sample::new(hz, patches));
                    }
                }
                let nodes = wanted.iter().map(|hz| index[&hz.to_bits()]).collect();
                if count > ROUND {
                    let interval = Interval::leja(low, high, nodes, ROUND);
                    let errors: Vec<f64> = samples
                        .par_iter()
                        .zip(modes)
                        .map(|(samples, &modes)| interval.error(|s| samples[s].whole(modes), modes, sampling.floor))
                        .collect();
                    let found = errors.into_iter().fold(0.0, f64::max);
                    let ratio = if previous.is_finite() { found / previous } else { 1.0 };
                    let gained = found * ratio.clamp(GAIN, 1.0);
                    if gained <= sampling.tolerance {
                        error = error.max(gained);
                        intervals.push(interval);
                        break;
                    }
                    if index.len() >= sampling.most_samples {
                        return Err(AcousticsError::Unresolved {
                            hz: (low * high).sqrt(),
                            error: gained,
                            samples: index.len(),
                            tolerance: sampling.tolerance,
                        });
                    }
                    previous = found;
                }
                count += ROUND;
            }
        }
        let found = samples.into_iter().zip(modes);
        Ok(found
            .map(|(samples, &modes)| Self::of(method, modes, patches, intervals.clone(), samples, error))
            .collect())
    }
}
