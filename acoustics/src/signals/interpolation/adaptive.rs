//! Adaptive sampling: samples are added in rounds until the interpolant predicts them.

use super::error::SamplingError;
use super::grid::Grid;
use super::interval::{Interval, MOST, extrapolated, leja_hz};
use crate::checks::positive;
use crate::error::AcousticsError;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Widest useful interval of a polynomial, as a ratio of frequencies: over a wider one, the small values at its lower
/// end are lost in the rounding of those at its upper end.
pub(crate) const WIDEST: f64 = 4.0;

/// Tolerance and limits of the sampling.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plan {
    /// Largest estimated error.
    pub(crate) tolerance: f64,
    /// Number of samples added to an interval at a time.
    pub(crate) round: usize,
    /// Largest total number of samples.
    pub(crate) most_samples: usize,
    /// Whether zero is a valid first approximation, as for a small correction.
    pub(crate) near_zero: bool,
    /// Whether the last round itself must be within the tolerance, without extrapolating its convergence.
    pub(crate) cautious: bool,
}

/// A range of frequencies, including both ends \[Hz\].
pub(crate) type Range = [f64; 2];

/// An interval to be sampled.
#[derive(Debug, Clone)]
pub(crate) struct Piece {
    pub(crate) range: Range,
    /// Frequencies with which its sequence of samples begins \[Hz\].
    pub(crate) known: Vec<f64>,
    /// Number of samples at which an interval counts as complete, whatever the error. `None` if an interval that needs
    /// too many samples is halved instead.
    pub(crate) complete: Option<usize>,
}

/// Divides a range into intervals, none wider than a given ratio of frequencies, with ends at the kinks of the
/// quantity.
///
/// # Errors
/// If the range is empty.
pub(crate) fn pieces([low, high]: Range, widest: f64, kinks: &[f64]) -> Result<Vec<Piece>, SamplingError> {
    if !(low > 0.0 && high > low && high.is_finite()) {
        return Err(SamplingError::EmptyRange { low, high });
    }
    let count = ((high / low).ln() / widest.ln()).ceil().max(1.0) as usize;
    let edge = |i: usize| low * (high / low).powf(i as f64 / count as f64);
    let mut edges: Vec<f64> = (1..count).map(edge).chain([low, high]).collect();
    edges.extend(kinks.iter().filter(|&&hz| low < hz && hz < high));
    edges.sort_by(f64::total_cmp);
    edges.dedup();
    let piece = |ends: &[f64]| Piece {
        range: [ends[0], ends[1]],
        known: Vec::new(),
        complete: None,
    };
    Ok(edges.windows(2).map(piece).collect())
}

/// Takes the samples of a round in parallel, one frequency per task, because all take equally long. The error returned
/// is that of the first frequency that fails.
pub(crate) fn each<T: Send>(
    take: impl Fn(f64) -> Result<T, AcousticsError> + Sync,
) -> impl Fn(&[f64]) -> Result<Vec<T>, AcousticsError> + Sync {
    move |hz| {
        let taken: Vec<_> = hz.par_iter().with_max_len(1).map(|&hz| take(hz)).collect();
        taken.into_iter().collect()
    }
}

/// Samples every piece. `take` returns the samples at the frequencies of a round; `misfit` returns the difference
/// between the test samples of an interval and the interpolant through the others, relative to the sampled quantity.
///
/// Each interval begins with two rounds of the Leja sequence. Rounds are added until the last one agrees within the
/// tolerance with the polynomial that excludes it. The polynomial through all samples is more accurate; [`Grid::error`]
/// assumes that its error decreases by the same factor as in the previous round, but by at most ten.
///
/// An interval is halved when it reaches the largest number of samples per polynomial. From half that number upwards,
/// it is halved earlier if the convergence of the last two rounds shows that the full number would not meet the
/// tolerance. The narrower a resonance is relative to the interval, the more slowly a polynomial converges. The
/// sequences of the halves begin with the existing samples inside them. Leja's rule then adds those that the new end
/// requires.
///
/// # Errors
/// If the tolerance is not positive; [`SamplingError::Unresolved`]; errors of `take`.
pub(crate) fn sample<T: Send + Sync>(
    pieces: &[Piece],
    plan: &Plan,
    take: impl Fn(&[f64]) -> Result<Vec<T>, AcousticsError>,
    misfit: impl Fn(&Interval, &[T]) -> f64 + Sync,
) -> Result<(Grid, Vec<T>), AcousticsError> {
    let tolerance = positive("interpolation tolerance", plan.tolerance)?;
    let (mut all_hz, mut samples, mut index) = (Vec::<f64>::new(), Vec::<T>::new(), BTreeMap::<u64, usize>::new());
    let (mut intervals, mut largest) = (Vec::new(), 0.0f64);
    let begin = |piece: &Piece| (piece.clone(), 2 * plan.round, None);
    let mut pending: Vec<(Piece, usize, Option<f64>)> = pieces.iter().map(begin).collect();
    while !pending.is_empty() {
        let nodes = |piece: &Piece, count: usize| {
            leja_hz(piece.range, &piece.known, count.min(piece.complete.unwrap_or(count)))
        };
        let mut wanted: Vec<f64> = pending
            .iter()
            .flat_map(|(piece, count, _)| nodes(piece, *count))
            .collect();
        wanted.retain(|hz| !index.contains_key(&hz.to_bits()));
        wanted.sort_by(f64::total_cmp);
        wanted.dedup();
        let taken = take(&wanted)?;
        for (hz, taken) in wanted.into_iter().zip(taken) {
            index.insert(hz.to_bits(), samples.len());
            samples.push(taken);
            all_hz.push(hz);
        }
        let judge = |(piece, count, before): &(Piece, usize, Option<f64>)| {
            let hz = nodes(piece, *count);
            let numbers = hz.iter().map(|hz| index[&hz.to_bits()]).collect();
            let interval = Interval::new(piece.range, numbers, hz, plan.round);
            let zero = || misfit(&interval.tested_by(interval.nodes.len()), &samples);
            let before = before.or_else(|| plan.near_zero.then(zero));
            let found = misfit(&interval, &samples);
            let estimate = extrapolated(found, before);
            let rounds = MOST.saturating_sub(*count) / plan.round;
            let promising = before.is_none()
                || 2 * count < MOST
                || piece.complete.is_some()
                || estimate * (estimate / found).powi(rounds as i32) <= tolerance;
            (
                interval,
                (found, if plan.cautious { found } else { estimate }),
                promising,
            )
        };
        let judged: Vec<(Interval, (f64, f64), bool)> = pending.par_iter().map(judge).collect();
        let mut next = Vec::new();
        for ((interval, (found, error), promising), (piece, count, _)) in judged.into_iter().zip(pending) {
            let [low, high] = piece.range;
            if error <= tolerance || piece.complete.is_some_and(|complete| count >= complete) {
                largest = largest.max(error);
                intervals.push(interval);
            } else if samples.len() >= plan.most_samples {
                let (hz, samples) = ((low * high).sqrt(), samples.len());
                return Err(SamplingError::Unresolved {
                    hz,
                    error,
                    samples,
                    tolerance,
                }
                .into());
            } else if count + plan.round <= MOST && promising {
                // The first round of a half is near its new end, so its misfit is not yet representative of the
                // interval.
                let first_of_half = !piece.known.is_empty() && count <= piece.known.len() + plan.round;
                let before = (!first_of_half || piece.complete.is_some()).then_some(found);
                next.push((piece, count + plan.round, before));
            } else {
                let halves = [[low, 0.5 * (low + high)], [0.5 * (low + high), high]];
                let half = |range: Range| {
                    let own = |hz: &&f64| range[0] <= **hz && **hz <= range[1];
                    let known: Vec<f64> = interval.samples_hz().iter().filter(own).copied().collect();
                    let count = (known.len() + plan.round).max(2 * plan.round);
                    (Piece { range, known, ..piece }, count, None)
                };
                next.extend(halves.map(half));
            }
        }
        pending = next;
    }
    Ok((Grid::new(all_hz, intervals, largest), samples))
}
