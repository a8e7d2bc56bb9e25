use super::error::LevelsError;
use super::fourier::fast_length;
use super::history::{IntervalLevels, PowerHistory};
use super::{SourceSpectrum, Weighting, energy_weights};
use crate::checks::same_length;
use nalgebra::DMatrix;
use rayon::prelude::*;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::num_complex::Complex;
use std::f64::consts::TAU;
use std::ops::Range;
use std::sync::Arc;

/// Number of samples per period of the highest bin; with 4, |x|² is sampled without aliasing.
const OVERSAMPLING: usize = 4;

/// Length of a windowed section after padding \[s\].
const CUT_LENGTH: f64 = 1.0;

/// Number of signals per task. A fixed number makes the order of summation independent of the number of threads.
const CHUNK: usize = 8;

/// Signals whose sum of squares is the power radiated by a source.
///
/// ```text
/// x(t) = F^-1[H_A L^H V]      W_A(t) = |x(t)|^2      R = L L^H
/// ```
///
/// Every bin has exactly the energy given by the source's spectrum. Range and weighting enter through the
/// [weights](energy_weights) used to integrate this spectrum. By Parseval's theorem the integral of the power over time
/// equals that of the spectrum over frequency, to rounding. The weighting has the phase of its causal filter, so that
/// no signal precedes its cause. L is real on the frequency axis (in general Hermitian) and spreads a signal
/// symmetrically in time; so do the ends of the frequency range.
///
/// The bins are those of a record padded to at least twice its length
/// ([`TransformSettings`](super::fourier::TransformSettings)). Time runs from minus a quarter of the transform's period
/// to three quarters of it.
#[derive(Debug, Clone)]
pub struct PowerSignals {
    frequency: Vec<f64>,
    first: usize,
    resolution: f64,
    /// Signals x bins.
    spectra: DMatrix<Complex<f64>>,
    /// Factor on the signals in each bin that makes 2 |x|² = E.
    factors: Vec<Complex<f64>>,
    mismatch: f64,
}

/// A source over time.
#[derive(Debug, Clone, PartialEq)]
pub struct SignalAnalysis {
    /// A-weighted power.
    pub history: PowerHistory,
    /// Levels between the events.
    pub intervals: Vec<IntervalLevels>,
}

impl PowerSignals {
    /// Creates signals (rows of `spectra`) on the bins of a source's spectrum, with E = 2 |x|² up to a factor per bin.
    ///
    /// The factor is removed: `spectra` determine how a bin's energy varies over time, and the spectrum determines its
    /// amount. [`Self::mismatch`] sums up the corrections.
    ///
    /// # Errors
    /// If the number of bins differs from the spectrum's, or frequencies are not multiples of a common bin width.
    pub fn new(spectrum: &SourceSpectrum, spectra: DMatrix<Complex<f64>>) -> Result<Self, LevelsError> {
        let frequency = spectrum.frequency.clone();
        same_length("bins of the signals", spectra.ncols(), frequency.len())?;
        let (first, resolution) = bins(&frequency)?;
        let (mut mismatch, mut total) = (0.0, 0.0);
        let mut factors = Vec::with_capacity(frequency.len());
        for (bin, &energy) in spectra.column_iter().zip(&spectrum.energy_density) {
            let found = 2.0 * bin.iter().map(|x| x.norm_sqr()).sum::<f64>();
            let factor = if found > 0.0 { (energy / found).sqrt() } else { 0.0 };
            factors.push(Complex::from(factor));
            mismatch += (energy - found).abs();
            total += energy;
        }
        Ok(Self {
            frequency,
            first,
            resolution,
            spectra,
            factors,
            mismatch: if total > 0.0 { mismatch / total } else { 0.0 },
        })
    }

    /// Multiplies all signals by a factor of magnitude 1.
    #[must_use]
    pub(crate) fn turned(mut self, phase: Complex<f64>) -> Self {
        self.factors.iter_mut().for_each(|factor| *factor *= phase);
        self
    }

    /// Sum of |E - 2 |x|²| over the bins before they were matched, relative to the sum of E.
    pub fn mismatch(&self) -> f64 {
        self.mismatch
    }

    /// Number of signals.
    pub fn signals(&self) -> usize {
        self.spectra.nrows()
    }

    /// Frequencies of the bins \[Hz\].
    pub fn frequency(&self) -> &[f64] {
        &self.frequency
    }

    /// A single signal with the energy of all, for example for a sound file: each bin has the total energy and the
    /// phase of the sum of the signals. A single signal is returned unchanged.
    pub fn combined_signal(&self) -> Vec<Complex<f64>> {
        let of_bin = |(bin, factor): (nalgebra::DVectorView<'_, Complex<f64>>, &Complex<f64>)| {
            let amplitude = bin.iter().map(|x| x.norm_sqr()).sum::<f64>().sqrt();
            Complex::from_polar(amplitude * factor.norm(), (bin.sum() * factor).arg())
        };
        self.spectra.column_iter().zip(&self.factors).map(of_bin).collect()
    }

    /// A-weighted power over time, and levels between adjacent `edges` \[s\], within `range_hz`.
    ///
    /// In addition to the energies, which add up, each interval has the level that a measurement would give. The
    /// unweighted signal, limited to the range, is windowed to the interval, padded with zeros to 1 s, transformed,
    /// weighted and summed over the range. The sharp edges of the window add energy. The first interval extends back to
    /// the start of the history and the last one to its end.
    pub fn analyse(&self, edges: &[f64], range_hz: [f64; 2]) -> SignalAnalysis {
        let work = Work::new(self, edges, range_hz);
        let first: Vec<usize> = (0..self.signals()).step_by(CHUNK).collect();
        let rows = |&first: &usize| first..self.signals().min(first + CHUNK);
        let parts: Vec<(Vec<f64>, Vec<f64>)> = first.par_iter().map(|first| work.chunk(self, rows(first))).collect();
        let mut power = vec![0.0; work.samples];
        let mut cut = vec![0.0; work.cuts.len()];
        for (p, c) in &parts {
            power.iter_mut().zip(p).for_each(|(sum, p)| *sum += p);
            cut.iter_mut().zip(c).for_each(|(sum, c)| *sum += c);
        }
        let history = PowerHistory {
            start: -(work.before as f64) * work.dt,
            sample_interval: work.dt,
            power,
        };
        let energies = history.energies_between(edges);
        let level = |((pair, energy), cut): ((&[f64], f64), f64)| IntervalLevels::new(pair[0], pair[1], energy, cut);
        let intervals = edges.windows(2).zip(energies).zip(cut).map(level).collect();
        SignalAnalysis { history, intervals }
    }
}

/// Index of the first bin, and bin width \[Hz\].
fn bins(frequency: &[f64]) -> Result<(usize, f64), LevelsError> {
    let (Some(&low), Some(&high)) = (frequency.first(), frequency.last()) else {
        return Ok((1, 1.0));
    };
    if frequency.len() < 2 {
        return Ok((1, low));
    }
    let resolution = (high - low) / (frequency.len() - 1) as f64;
    let first = (low / resolution).round() as usize;
    for (i, &hz) in frequency.iter().enumerate() {
        let expected = (first + i) as f64 * resolution;
        if (hz - expected).abs() > 1e-6 * resolution {
            return Err(LevelsError::NotABin { hz, resolution });
        }
    }
    Ok((first, resolution))
}

/// Plans and weights of one analysis.
struct Work {
    samples: usize,
    dt: f64,
    /// Samples before t = 0.
    before: usize,
    inverse: Arc<dyn ComplexToReal<f64>>,
    /// Amplitude factors of the bins, with and without weighting.
    weighted: Vec<Complex<f64>>,
    plain: Vec<Complex<f64>>,
    cuts: Vec<Cut>,
}

/// A section of the signal between two events, as measured.
struct Cut {
    /// Half-open range of samples.
    from: usize,
    to: usize,
    /// The energy over the range, as a sum over the bins of a transform of at least twice the section's length. Its
    /// weights are equivalent to those of the section padded to 1 s ([`MeasuredSum`]).
    transform: Arc<dyn RealToComplex<f64>>,
    weights: Vec<f64>,
}

/// The weighted sum over the bins of a padded transform, for sections much shorter than the padding.
///
/// ```text
/// sum_k v_k |X_k|^2 = sum_tau r(tau) w(tau)        w = DFT of v, N long;  r the piece's autocorrelation
///                   = sum_m q_m |Y_m|^2       q = DFT of w over |tau| < L, over M;  Y transform of the piece, M >= 2 L
/// ```
///
/// r vanishes for lags of at least the section's length L, so both sums are equal. The second needs a transform of only
/// M = 2 L points instead of N = 1 s.
struct MeasuredSum {
    /// w(tau) for 0 <= tau < N, periodic.
    lags: Vec<f64>,
}

impl MeasuredSum {
    /// `weights` are those of bins 0 to N/2 of an N-point transform.
    fn new(points: usize, weights: &[f64], planner: &mut RealFftPlanner<f64>) -> Self {
        let transform = planner.plan_fft_inverse(points);
        let mut spectrum = transform.make_input_vec();
        let last = spectrum.len() - 1;
        for (k, (v, weight)) in spectrum.iter_mut().zip(weights).enumerate() {
            // An inner bin represents two bins of the two-sided sum.
            let alone = k == 0 || (k == last && points.is_multiple_of(2));
            *v = Complex::from(if alone { *weight } else { 0.5 * weight });
        }
        let mut lags = transform.make_output_vec();
        let done = transform.process(&mut spectrum, &mut lags);
        debug_assert!(done.is_ok());
        Self { lags }
    }

    /// Transform, and weights of its bins, for a section of `length` samples.
    fn of(&self, length: usize, planner: &mut RealFftPlanner<f64>) -> (Arc<dyn RealToComplex<f64>>, Vec<f64>) {
        let points = fast_length(2 * length.max(1));
        let transform = planner.plan_fft_forward(points);
        let mut even = transform.make_input_vec();
        for tau in 0..length {
            even[tau] = self.lags[tau % self.lags.len()];
            if tau > 0 {
                even[points - tau] = even[tau];
            }
        }
        let mut bins = transform.make_output_vec();
        let done = transform.process(&mut even, &mut bins);
        debug_assert!(done.is_ok());
        let last = bins.len() - 1;
        let one_sided = |(m, q): (usize, &Complex<f64>)| {
            let alone = m == 0 || (m == last && points.is_multiple_of(2));
            q.re * if alone { 1.0 } else { 2.0 } / points as f64
        };
        let weights = bins.iter().enumerate().map(one_sided).collect();
        (transform, weights)
    }
}

impl Work {
    fn new(signals: &PowerSignals, edges: &[f64], range: [f64; 2]) -> Self {
        let df = signals.resolution;
        let last = signals.first + signals.frequency.len();
        let samples = fast_length((OVERSAMPLING * last).max(64));
        let dt = 1.0 / (samples as f64 * df);
        let before = samples / 4;
        let amplitude = |weighting: Weighting| {
            let weights = energy_weights(&signals.frequency, range, weighting);
            let bins = weights.into_iter().zip(&signals.frequency).zip(&signals.factors);
            let amplitude = bins.enumerate().map(|(i, ((w, &hz), factor))| {
                let response = weighting.response(hz);
                // Delayed by the samples before t = 0.
                let turns = (signals.first + i) * before % samples;
                let later = Complex::from_polar((w / df).sqrt() * df, -TAU * turns as f64 / samples as f64);
                factor * later * (response / response.norm())
            });
            amplitude.collect::<Vec<Complex<f64>>>()
        };
        let sample = |t: f64| ((t / dt).ceil() + before as f64).clamp(0.0, samples as f64) as usize;
        let intervals = edges.len().saturating_sub(1);
        let cut = |(i, pair): (usize, &[f64])| {
            let from = if i == 0 { 0 } else { sample(pair[0]) };
            let to = if i + 1 == intervals { samples } else { sample(pair[1]) };
            (from, to.max(from))
        };
        let cuts: Vec<(usize, usize)> = edges.windows(2).enumerate().map(cut).collect();
        let longest = cuts.iter().map(|(from, to)| to - from).max().unwrap_or(0);
        let padded = fast_length(((CUT_LENGTH / dt).ceil() as usize).max(longest));
        let grid: Vec<f64> = (0..=padded / 2).map(|k| k as f64 / (padded as f64 * dt)).collect();
        let mut planner = RealFftPlanner::new();
        let sum = MeasuredSum::new(padded, &energy_weights(&grid, range, Weighting::A), &mut planner);
        let cuts = cuts.into_iter().map(|(from, to)| {
            let (transform, weights) = sum.of(to - from, &mut planner);
            Cut {
                from,
                to,
                transform,
                weights,
            }
        });
        let cuts = cuts.collect();
        Self {
            samples,
            dt,
            before,
            inverse: planner.plan_fft_inverse(samples),
            weighted: amplitude(Weighting::A),
            plain: amplitude(Weighting::Z),
            cuts,
        }
    }

    /// Power and windowed energies of some of the signals.
    fn chunk(&self, signals: &PowerSignals, rows: Range<usize>) -> (Vec<f64>, Vec<f64>) {
        let (mut power, mut cut) = (vec![0.0; self.samples], vec![0.0; self.cuts.len()]);
        let mut x = vec![0.0; self.samples];
        let mut spectrum = self.inverse.make_input_vec();
        let mut scratch = self.inverse.make_scratch_vec();
        let length = |of: fn(&Cut) -> usize| self.cuts.iter().map(of).max().unwrap_or(0);
        let mut padded = vec![0.0; length(|cut| cut.transform.len())];
        let mut bins = vec![Complex::ZERO; length(|cut| cut.transform.complex_len())];
        let mut forward_scratch = vec![Complex::ZERO; length(|cut| cut.transform.get_scratch_len())];
        // Contiguous values are processed together.
        let count = signals.frequency.len();
        let mut values = vec![Complex::ZERO; count * rows.len()];
        for (bin, column) in signals.spectra.column_iter().enumerate() {
            for (number, value) in column.rows_range(rows.clone()).iter().enumerate() {
                values[number * count + bin] = *value;
            }
        }
        for values in values.chunks_exact(count.max(1)) {
            let mut to_time = |factors: &[Complex<f64>], x: &mut [f64]| {
                spectrum.fill(Complex::ZERO);
                for ((to, value), factor) in spectrum[signals.first..].iter_mut().zip(values).zip(factors) {
                    *to = value * factor;
                }
                // The buffers come from the plan and the end bins are real, so the transform cannot fail.
                let done = self.inverse.process_with_scratch(&mut spectrum, x, &mut scratch);
                debug_assert!(done.is_ok());
            };
            to_time(&self.weighted, &mut x);
            power.iter_mut().zip(&x).for_each(|(p, x)| *p += x * x);
            to_time(&self.plain, &mut x);
            for (energy, cut) in cut.iter_mut().zip(&self.cuts) {
                let (piece, transform) = (&x[cut.from..cut.to], &cut.transform);
                if piece.is_empty() {
                    continue;
                }
                let (padded, bins) = (&mut padded[..transform.len()], &mut bins[..transform.complex_len()]);
                padded[..piece.len()].copy_from_slice(piece);
                padded[piece.len()..].fill(0.0);
                let scratch = &mut forward_scratch[..transform.get_scratch_len()];
                let done = transform.process_with_scratch(padded, bins, scratch);
                debug_assert!(done.is_ok());
                let sum: f64 = bins.iter().zip(&cut.weights).map(|(x, w)| w * x.norm_sqr()).sum();
                *energy += 2.0 * self.dt * self.dt * sum;
            }
        }
        (power, cut)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The definition: the section padded to all points, transformed, weighted and summed.
    fn padded_sum(piece: &[f64], points: usize, weights: &[f64], planner: &mut RealFftPlanner<f64>) -> f64 {
        let transform = planner.plan_fft_forward(points);
        let mut padded = transform.make_input_vec();
        padded[..piece.len()].copy_from_slice(piece);
        let mut bins = transform.make_output_vec();
        assert!(transform.process(&mut padded, &mut bins).is_ok());
        bins.iter().zip(weights).map(|(x, w)| w * x.norm_sqr()).sum()
    }

    #[test]
    fn the_short_sum_is_the_padded_one() {
        let mut planner = RealFftPlanner::new();
        for points in [1000, 999] {
            let weights: Vec<f64> = (0..=points / 2).map(|k| 1.0 + (0.37 * k as f64).sin()).collect();
            let sum = MeasuredSum::new(points, &weights, &mut planner);
            for length in [1, 2, 37, 400, 500, 700, points] {
                let piece: Vec<f64> = (0..length)
                    .map(|i| (i as f64 * 1.7).cos() + 0.2 * (i % 7) as f64)
                    .collect();
                let (transform, short) = sum.of(length, &mut planner);
                let found = padded_sum(&piece, transform.len(), &short, &mut planner);
                let expected = padded_sum(&piece, points, &weights, &mut planner);
                assert!(
                    (found / expected - 1.0).abs() < 1e-11,
                    "{points}, {length}: {found} {expected}"
                );
            }
        }
    }
}
