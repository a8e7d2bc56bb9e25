//! Several radiation resistances sampled at the same frequencies, chosen one round after the other.

use super::interval::{Interval, check_range, gained, leja_hz};
use super::resistance::Resistance;
use super::sampled::{Sample, SampledRadiation, Sampling};
use crate::error::{AcousticsError, positive};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Frequencies of a round, solved beside each other.
pub(crate) const ROUND: usize = 4;
/// Widest interval that one polynomial serves, as a ratio of frequencies: over more, small resistances fall by too many
/// powers of ten.
const WIDEST: f64 = 4.0;

impl SampledRadiation {
    /// Samples several resistances that one solution gives together, as those of all parities of a body: `solve` returns
    /// R(f) of each and of every patch, `modes` counts the modes of each.
    ///
    /// Every interval begins with a few frequencies of Leja's sequence and goes on by rounds until the samples
    /// of a round lie within the tolerance of what the polynomial without them says. With them the error is smaller by
    /// what a round gains, and by a factor of ten at the most: this is the error stated. It is that of all entries of all
    /// resistances together, root mean square with every mode scaled to the same power: single entries of weak modes
    /// near a narrow resonance of the air may be off by more.
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
        let mut taken = Taken::new(modes.len());
        let (mut intervals, mut error) = (Vec::new(), 0.0f64);
        for piece in 0..pieces {
            let (low, high) = (edge(piece), edge(piece + 1));
            let mut progress = Progress::of(ROUND);
            loop {
                let nodes = taken.at(&leja_hz(low, high, progress.next()), &solve)?;
                let Some(interval) = progress.interval(low, high, nodes) else {
                    continue;
                };
                let whole = |c: usize, node: usize| taken.samples[c][node].whole();
                let gained = progress.gained(&interval, modes.len(), sampling.floor, whole, whole);
                if gained <= sampling.tolerance {
                    error = error.max(gained);
                    intervals.push(interval);
                    break;
                }
                if taken.index.len() >= sampling.most_samples {
                    return Err(AcousticsError::Unresolved {
                        hz: (low * high).sqrt(),
                        error: gained,
                        samples: taken.index.len(),
                        tolerance: sampling.tolerance,
                    });
                }
            }
        }
        let found = taken.samples.into_iter().zip(modes);
        Ok(found
            .map(|(samples, &modes)| Self::of(method, modes, patches, intervals.clone(), samples, error))
            .collect())
    }

    /// Corrects resistances that [`SampledRadiation::together`] sampled with a cheap model by what an accurate one finds
    /// at the first few of the same frequencies. The difference is interpolated like the resistance itself, until it is
    /// known to the tolerance, relative to the resistance: being small it needs fewer frequencies, `round` at a time.
    ///
    /// # Errors
    /// Those of `solve`.
    pub(crate) fn correct(
        found: &mut [Self],
        (sampling, round): (&Sampling, usize),
        solve: impl Fn(f64) -> Result<Vec<Vec<Resistance>>, AcousticsError> + Sync,
    ) -> Result<Correction, AcousticsError> {
        let mut accurate = Taken::new(found.len());
        let intervals = found.first().map_or_else(Vec::new, |f| f.intervals().to_vec());
        let mut correction = Correction::default();
        for cheap in &intervals {
            let mut progress = Progress::of(round);
            loop {
                let count = progress.next().min(cheap.nodes.len());
                let nodes = accurate.at(&leja_hz(cheap.low, cheap.high, count), &solve)?;
                let all = count == cheap.nodes.len();
                let Some(interval) = progress.interval(cheap.low, cheap.high, nodes) else {
                    continue;
                };
                let whole = |c: usize, node: usize| accurate.samples[c][node].whole();
                let difference = |c: usize, node: usize| {
                    let mut d = whole(c, node);
                    let position = interval.nodes.iter().position(|&n| n == node);
                    if let Some(position) = position {
                        d.add_scaled(-1.0, &found[c].whole_sample(cheap.nodes[position]));
                    }
                    d
                };
                if progress.previous.is_none() {
                    // Without a correction all of the difference is left.
                    let all = Interval::leja(cheap.low, cheap.high, interval.nodes.clone(), interval.nodes.len());
                    progress.previous = Some(misfit(&all, found.len(), sampling.floor, difference, whole));
                }
                let gained = progress.gained(&interval, found.len(), sampling.floor, difference, whole);
                if gained <= sampling.tolerance || all {
                    correction.error = correction.error.max(gained);
                    correction.intervals.push(interval);
                    break;
                }
            }
        }
        correction.hz = accurate.hz();
        for (found, accurate) in found.iter_mut().zip(&accurate.samples) {
            found.add_differences(&intervals, &correction.intervals, accurate, correction.error);
        }
        Ok(correction)
    }
}

/// Where [`SampledRadiation::correct`] asked the accurate model, and how the differences carry over to other frequencies.
#[derive(Debug, Default)]
pub(crate) struct Correction {
    intervals: Vec<Interval>,
    hz: Vec<f64>,
    error: f64,
}

impl Correction {
    /// The accurate model's frequencies \[Hz\] and their weights in the difference at `hz`.
    pub(crate) fn weights(&self, hz: f64) -> Vec<(f64, f64)> {
        let holds = |i: &&Interval| hz <= i.high;
        let Some(interval) = self.intervals.iter().find(holds).or(self.intervals.last()) else {
            return Vec::new();
        };
        let nodes = interval.nodes.iter().map(|&node| self.hz[node]);
        nodes.zip(interval.weights(hz)).collect()
    }
}

/// Samples of several resistances at the same frequencies.
struct Taken {
    samples: Vec<Vec<Sample>>,
    index: BTreeMap<u64, usize>,
}

impl Taken {
    fn new(resistances: usize) -> Self {
        Self {
            samples: vec![Vec::new(); resistances],
            index: BTreeMap::new(),
        }
    }

    fn hz(&self) -> Vec<f64> {
        self.samples
            .first()
            .map_or_else(Vec::new, |samples| samples.iter().map(Sample::hz).collect())
    }

    /// Numbers of the samples at the frequencies `wanted`; those that are missing are taken.
    fn at(
        &mut self,
        wanted: &[f64],
        solve: &(impl Fn(f64) -> Result<Vec<Vec<Resistance>>, AcousticsError> + Sync),
    ) -> Result<Vec<usize>, AcousticsError> {
        let new: Vec<f64> = wanted
            .iter()
            .copied()
            .filter(|hz| !self.index.contains_key(&hz.to_bits()))
            .collect();
        // One frequency at a time on a thread: they take equally long.
        let solved: Vec<_> = new.par_iter().with_max_len(1).map(|&hz| solve(hz)).collect();
        for (&hz, solved) in new.iter().zip(solved) {
            self.index.insert(hz.to_bits(), self.index.len());
            for (samples, patches) in self.samples.iter_mut().zip(solved?) {
                samples.push(Sample::new(hz, &patches));
            }
        }
        Ok(wanted.iter().map(|hz| self.index[&hz.to_bits()]).collect())
    }
}

/// Rounds of samples in an interval.
struct Progress {
    /// Samples of a round.
    round: usize,
    count: usize,
    previous: Option<f64>,
}

impl Progress {
    fn of(round: usize) -> Self {
        Self {
            round,
            count: 0,
            previous: None,
        }
    }

    /// Samples with the next round.
    fn next(&mut self) -> usize {
        self.count += self.round;
        self.count
    }

    /// The interval on which the last round is tried; none before the second round.
    fn interval(&self, low: f64, high: f64, nodes: Vec<usize>) -> Option<Interval> {
        (nodes.len() > self.round).then(|| Interval::leja(low, high, nodes, self.round))
    }

    /// Error with the last round's samples, from what they found without them and what the round gained.
    fn gained(
        &mut self,
        interval: &Interval,
        resistances: usize,
        floor: f64,
        value: impl Fn(usize, usize) -> Resistance + Sync,
        whole: impl Fn(usize, usize) -> Resistance + Sync,
    ) -> f64 {
        let found = misfit(interval, resistances, floor, value, whole);
        let error = gained(found, self.previous);
        self.previous = Some(found);
        error
    }
}

/// Root mean square misfit of the samples tried, all resistances together, at the worst of their frequencies.
fn misfit(
    interval: &Interval,
    resistances: usize,
    floor: f64,
    value: impl Fn(usize, usize) -> Resistance + Sync,
    whole: impl Fn(usize, usize) -> Resistance + Sync,
) -> f64 {
    let misfits: Vec<Vec<[f64; 2]>> = (0..resistances)
        .into_par_iter()
        .map(|c| interval.misfits(|node| value(c, node), |node| whole(c, node), floor))
        .collect();
    let ratio = |tried: usize| {
        let sum = |part: usize| misfits.iter().map(|m| m[tried][part]).sum::<f64>();
        (sum(0) / sum(1).max(f64::MIN_POSITIVE)).sqrt()
    };
    (0..interval.tried).map(ratio).fold(0.0, f64::max)
}
