//! A radiation resistance sampled over frequency and interpolated.

mod evaluate;

use super::hermitian_root::hermitian_root;
use super::packed::{self, PackedHermitian};
use super::resistance::Resistance;
use crate::error::AcousticsError;
use crate::signals::interpolation::{Grid, Interval, Piece, Plan, Run, WIDEST, each, or_infinite, pieces, sample};
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Norm of the errors over all entries.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Norm {
    /// The largest magnitude.
    Largest,
    /// The root mean square.
    MeanSquare,
}

/// Number of samples added to an interval at a time, computed in parallel.
const ROUND: usize = 4;

/// Widest interval, as a ratio of frequencies, if signals must also be interpolated to the tolerance: the root of R
/// varies faster than R.
const OCTAVE: f64 = 2.0;

/// Range and accuracy of the sampling of a radiation resistance over frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampling {
    /// Lowest and highest sample \[Hz\]. Below the lowest sample, every entry follows its own power law.
    pub range_hz: [f64; 2],
    /// Largest interpolation error relative to sqrt(R_ii R_jj): of any entry R_ij, or as root mean square over them if
    /// [`SampledRadiation::of_parities`] takes the samples. Values below 2e-7 cannot be met, because samples are stored
    /// in single precision.
    pub tolerance: f64,
    /// Fraction of the largest resistance at a frequency. The error of a mode with a lower resistance is measured
    /// relative to this fraction, because its resistance is a small difference of large numbers and its sound is hardly
    /// audible.
    pub floor: f64,
    /// Largest number of samples.
    pub most_samples: usize,
}

impl Default for Sampling {
    /// 40 Hz to 10 kHz, tolerance 1e-4, floor 1e-6, 400 samples.
    fn default() -> Self {
        Self {
            range_hz: [40.0, 10_000.0],
            tolerance: 1e-4,
            floor: 1e-6,
            most_samples: 400,
        }
    }
}

impl Sampling {
    fn plan(&self, round: usize) -> Plan {
        Plan {
            tolerance: self.tolerance,
            round,
            most_samples: self.most_samples,
            near_zero: false,
            cautious: false,
        }
    }
}

/// A radiation resistance sampled at a few frequencies and interpolated between them.
///
/// Q = R / omega² is interpolated entry by entry with polynomials on intervals of the frequency axis. Below the lowest
/// sample f_0
///
/// ```text
/// R_ij(f) = R_ij(f_0) (f/f_0)^{(n_i + n_j)/2}      n_i = 2, 4, 6: the slope of R_ii at f_0, rounded to even
/// ```
///
/// so that R remains positive semidefinite.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SampledRadiation {
    method: String,
    modes: usize,
    patches: Vec<String>,
    grid: Grid,
    /// R of each patch at the samples, in single precision, so that a result does not depend on whether it was cached.
    samples: Vec<PackedHermitian>,
    slopes: Vec<f64>,
    /// Hermitian roots of the sum over patches at the samples used by intervals, if computed.
    roots: Vec<Option<PackedHermitian>>,
}

/// R at one frequency for each parity and patch.
pub(crate) type Solution = Vec<Vec<Resistance>>;

/// A resistance at one frequency during sampling.
struct Sample {
    patches: PackedHermitian,
    /// Q of all patches combined, as a row of a packed matrix without rounding.
    whole: Vec<f64>,
}

impl Sample {
    fn new(hz: f64, modes: usize, patches: &[Resistance]) -> Self {
        let mut whole = packed::whole(modes, patches);
        whole.iter_mut().for_each(|r| *r *= per_omega2(hz));
        let patches = PackedHermitian::new(modes, patches.iter());
        Self { patches, whole }
    }
}

/// 1 / omega².
fn per_omega2(hz: f64) -> f64 {
    (TAU * hz).powi(-2)
}

impl SampledRadiation {
    /// Samples `resistance`, which returns R(f) of every patch, until the tolerance is met; frequencies are evaluated
    /// in parallel. Intervals end at `kinks` \[Hz\], across which polynomials do not converge.
    ///
    /// # Errors
    /// If the range is empty or the tolerance is not positive; [`SamplingError::Unresolved`](crate::SamplingError).
    pub fn new(
        method: &str,
        modes: usize,
        patches: &[String],
        (sampling, kinks): (&Sampling, &[f64]),
        resistance: impl Fn(f64) -> Vec<Resistance> + Sync,
    ) -> Result<Self, AcousticsError> {
        let solve = each(|hz: f64| Ok(vec![resistance(hz)]));
        let pieces = pieces(sampling.range_hz, OCTAVE, kinks)?;
        let mut found = Self::of_pieces(method, &[modes], patches, (sampling, &pieces, Norm::Largest), solve)?;
        Ok(found.swap_remove(0))
    }

    /// Samples several resistances that share a solution, such as those of all parities of a body: `solve` returns R(f)
    /// of each for every patch, and `modes` contains the number of modes of each.
    ///
    /// The error is assessed over all entries of all resistances together, with every mode scaled to the same power.
    /// Individual entries of weak modes near a narrow resonance of the air may have a larger error.
    ///
    /// # Errors
    /// Those of [`Self::new`] and of `solve`.
    pub fn of_parities(
        method: &str,
        modes: &[usize],
        patches: &[String],
        sampling: &Sampling,
        solve: impl Fn(f64) -> Result<Vec<Vec<Resistance>>, AcousticsError> + Sync,
    ) -> Result<Vec<Self>, AcousticsError> {
        Self::of_rounds(method, modes, patches, sampling, each(solve))
    }

    /// Same as `of_parities`, where `solve` takes all frequencies of a round.
    pub(crate) fn of_rounds(
        method: &str,
        modes: &[usize],
        patches: &[String],
        sampling: &Sampling,
        solve: impl Fn(&[f64]) -> Result<Vec<Solution>, AcousticsError>,
    ) -> Result<Vec<Self>, AcousticsError> {
        let pieces = pieces(sampling.range_hz, WIDEST, &[])?;
        Self::of_pieces(method, modes, patches, (sampling, &pieces, Norm::MeanSquare), solve)
    }

    fn of_pieces(
        method: &str,
        modes: &[usize],
        patches: &[String],
        (sampling, pieces, norm): (&Sampling, &[Piece], Norm),
        solve: impl Fn(&[f64]) -> Result<Vec<Solution>, AcousticsError>,
    ) -> Result<Vec<Self>, AcousticsError> {
        let take = |hz: &[f64]| {
            let of_frequency = |(solved, &hz): (Solution, &f64)| {
                let of_parity = |(patches, modes): (&Vec<Resistance>, &usize)| Sample::new(hz, *modes, patches);
                solved.iter().zip(modes).map(of_parity).collect::<Vec<_>>()
            };
            Ok(solve(hz)?.into_par_iter().zip(hz).map(of_frequency).collect())
        };
        let misfit = |interval: &Interval, samples: &[Vec<Sample>]| {
            let whole = |parity: usize, node: usize| &samples[node][parity].whole[..];
            misfit(interval, modes, (sampling.floor, norm), whole, whole)
        };
        let plan = Plan {
            cautious: norm == Norm::Largest,
            ..sampling.plan(ROUND)
        };
        let (grid, samples) = sample(pieces, &plan, take, misfit)?;
        let mut found: Vec<Vec<PackedHermitian>> = modes.iter().map(|_| Vec::new()).collect();
        for sample in samples {
            found
                .iter_mut()
                .zip(sample)
                .for_each(|(to, sample)| to.push(sample.patches));
        }
        let of_parity = |(samples, &modes): (Vec<PackedHermitian>, &usize)| Self {
            method: method.to_owned(),
            modes,
            patches: patches.to_vec(),
            slopes: low_slopes(&grid, &samples, modes),
            grid: grid.clone(),
            samples,
            roots: Vec::new(),
        };
        Ok(found.into_iter().zip(modes).map(of_parity).collect())
    }

    /// Corrects resistances sampled by [`SampledRadiation::of_parities`] with a cheap model, using an accurate model at
    /// the first few of the same frequencies. The difference is interpolated like the resistance itself, to the
    /// tolerance relative to the resistance; because it is small, it needs fewer frequencies, added `round` at a time.
    /// Returns the frequencies at which the accurate model was evaluated.
    ///
    /// # Errors
    /// Errors of `solve`.
    pub(crate) fn correct(
        found: &mut [Self],
        (sampling, round): (&Sampling, usize),
        solve: impl Fn(&[f64]) -> Result<Vec<Solution>, AcousticsError>,
    ) -> Result<Option<Grid>, AcousticsError> {
        let Some(first) = found.first() else { return Ok(None) };
        let modes: Vec<usize> = found.iter().map(|f| f.modes).collect();
        let piece = |cheap: &Interval| Piece {
            range: [cheap.low, cheap.high],
            known: cheap.samples_in_leja_order(),
            complete: Some(cheap.nodes.len()),
        };
        let pieces: Vec<Piece> = first.grid.intervals().iter().map(piece).collect();
        let index = |hz: f64| found[0].grid.hz().iter().position(|own| *own == hz);
        let of_frequency = |(solved, &hz): (Solution, &f64)| {
            let of_parity = |(patches, cheap): (&Vec<Resistance>, &Self)| {
                let accurate = Sample::new(hz, cheap.modes, patches);
                let difference = index(hz).map_or_else(Vec::new, |i| accurate.patches.less(&cheap.samples[i]));
                let whole_difference = packed::sum_of_rows(&difference, patches.len(), per_omega2(hz));
                (accurate.whole, difference, whole_difference)
            };
            solved.iter().zip(found.iter()).map(of_parity).collect::<Vec<_>>()
        };
        let take = |hz: &[f64]| Ok(solve(hz)?.into_par_iter().zip(hz).map(of_frequency).collect());
        let plan = Plan {
            near_zero: true,
            cautious: false,
            ..sampling.plan(round)
        };
        let (grid, differences) = sample(&pieces, &plan, take, |interval, samples| {
            let whole = |parity: usize, node: usize| &samples[node][parity].0[..];
            let difference = |parity: usize, node: usize| &samples[node][parity].2[..];
            misfit(interval, &modes, (sampling.floor, Norm::MeanSquare), difference, whole)
        })?;
        for (parity, found) in found.iter_mut().enumerate() {
            for (sample, &hz) in found.samples.iter_mut().zip(found.grid.hz()) {
                let weighted = grid.weighted(hz).map(|(node, weight)| {
                    let factor = weight * per_omega2(grid.hz()[node]) / per_omega2(hz);
                    (factor, &differences[node][parity].1[..])
                });
                sample.add(weighted);
            }
            found.grid.error += grid.error;
            found.slopes = low_slopes(&found.grid, &found.samples, found.modes);
        }
        Ok(Some(grid))
    }

    /// Converts to different air: multiplies frequencies by `speed`, and the resistance at each new frequency \[Hz\] by
    /// `factor`: R(f) = factor(f) R0(f/speed).
    ///
    /// The result has the label `method`. The factor is interpolated along with R; its interpolation error is added to
    /// [`SampledRadiation::interpolation_error`].
    #[must_use]
    pub(crate) fn in_air(mut self, method: &str, speed: f64, factor: impl Fn(f64) -> f64) -> Self {
        self.method = method.to_owned();
        self.grid.stretch(speed);
        self.roots.resize(self.samples.len(), None);
        for ((sample, root), &hz) in self.samples.iter_mut().zip(&mut self.roots).zip(self.grid.hz()) {
            sample.scale(factor(hz));
            root.iter_mut().for_each(|root| root.scale(factor(hz).sqrt()));
        }
        self.grid.error += self.grid.error_of_factor(factor);
        self
    }

    /// Joins this radiation, up to its highest frequency, with `above` beyond it. Also returns the indices of the
    /// samples of `above` that were appended, in order. Patches that are missing in `above` are silent there.
    pub(crate) fn continued(mut self, mut above: Self) -> (Self, Vec<usize>) {
        let taken = self.grid.extend(&above.grid);
        self.roots.resize(self.samples.len(), None);
        above.roots.resize(above.samples.len(), None);
        for &number in &taken {
            let mut sample = above.samples[number].clone();
            sample.add_silent(self.patches.len());
            self.samples.push(sample);
            self.roots.push(above.roots[number].take());
        }
        (self, taken)
    }

    /// Combines the first `count` patches into one called `name`.
    #[must_use]
    pub(crate) fn with_sum_of_patches(&self, count: usize, name: &str) -> Self {
        Self {
            patches: sum_of_names(&self.patches, count, name),
            samples: self.samples.iter().map(|sample| sample.with_sum_of(count)).collect(),
            method: self.method.clone(),
            grid: self.grid.clone(),
            slopes: self.slopes.clone(),
            roots: self.roots.clone(),
            ..*self
        }
    }

    /// Computes and stores the roots needed for signals, instead of computing them for every motion.
    #[must_use]
    pub fn with_roots(mut self) -> Self {
        let used = |sample: usize| {
            self.grid
                .intervals()
                .iter()
                .any(|interval| interval.nodes.contains(&sample))
        };
        self.roots = (0..self.samples.len())
            .into_par_iter()
            .map(|sample| used(sample).then(|| self.root(sample)))
            .collect();
        self
    }

    /// Frequencies sampled \[Hz\], ascending.
    pub fn sampled_hz(&self) -> Vec<f64> {
        let mut hz = self.samples_hz().to_vec();
        hz.sort_by(f64::total_cmp);
        hz
    }

    /// Estimated interpolation error, see [`Sampling::tolerance`].
    pub fn interpolation_error(&self) -> f64 {
        self.grid.error
    }

    /// Frequencies in the order of the samples \[Hz\].
    pub(crate) fn samples_hz(&self) -> &[f64] {
        self.grid.hz()
    }

    /// Its samples over frequency.
    pub(crate) fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Estimated interpolation error of a field sampled at the same frequencies, relative to the largest entry in an
    /// interval.
    pub(crate) fn error_of(&self, samples: &[DMatrix<Complex<f64>>]) -> f64 {
        self.grid.error_of_fields(samples)
    }

    /// Factor on the amplitude of a mode that makes the lowest sample's Q valid at a lower frequency.
    fn low_factor(&self, hz: f64, mode: usize) -> f64 {
        (hz / self.grid.lowest_hz()).powf(0.5 * self.slopes[mode] - 1.0)
    }

    /// The Hermitian root of R at a sample.
    fn root(&self, sample: usize) -> PackedHermitian {
        let root = hermitian_root(&self.samples[sample].sum(1.0));
        PackedHermitian::new(self.modes, std::iter::once(&root))
    }
}

/// The names of patches, with the first `count` replaced by the single name `name`.
pub(super) fn sum_of_names(patches: &[String], count: usize, name: &str) -> Vec<String> {
    let others = patches.iter().skip(count).cloned();
    std::iter::once(name.to_owned()).chain(others).collect()
}

/// Exponents of the diagonal of R at the lowest sample, rounded to even numbers from 2 upwards.
fn low_slopes(grid: &Grid, samples: &[PackedHermitian], modes: usize) -> Vec<f64> {
    let mut rising = grid.intervals()[0].nodes.clone();
    rising.sort_by(|&a, &b| grid.hz()[a].total_cmp(&grid.hz()[b]));
    let (first, second) = (rising[0], rising[1]);
    let octaves = (grid.hz()[second] / grid.hz()[first]).ln();
    let slope = |mode: usize| {
        let slope = (samples[second].diagonal(mode) / samples[first].diagonal(mode)).ln() / octaves;
        if slope.is_finite() {
            (2.0 * (slope / 2.0).round()).max(2.0)
        } else {
            2.0
        }
    };
    (0..modes).map(slope).collect()
}

/// Difference between the test samples and the interpolant through the others, for all parities together, at the worst
/// of their frequencies, with modes scaled to equal radiated power.
///
/// ```text
/// ||S D S|| / ||S Q S||        S_ii = Q_ii^-1/2, with resistances raised to at least `floor` of the largest
/// ```
///
/// For many modes that radiate independently, it is the root-mean-square energy error of one mode. In the norm of the
/// largest entry, it is max |(S D S)_ij|, the error of any pair of modes.
fn misfit<'a>(
    interval: &Interval,
    modes: &[usize],
    (floor, norm): (f64, Norm),
    value: impl Fn(usize, usize) -> &'a [f64] + Sync,
    whole: impl Fn(usize, usize) -> &'a [f64] + Sync,
) -> f64 {
    let at = |(weights, &test): (Vec<f64>, &usize)| {
        let of_parity = |(parity, &modes): (usize, &usize)| {
            let mut defect = Vec::new();
            for (weight, &node) in weights
                .iter()
                .zip(&interval.nodes)
                .filter(|(weight, _)| **weight != 0.0)
            {
                let row = value(parity, node);
                defect.resize(row.len().max(defect.len()), 0.0);
                defect.iter_mut().zip(row).for_each(|(d, v)| *d += weight * v);
            }
            let whole = whole(parity, test);
            let largest = packed::diagonal(modes, whole).fold(f64::MIN_POSITIVE, f64::max);
            let scale: Vec<f64> = packed::diagonal(modes, whole).map(|q| q.max(floor * largest)).collect();
            let (mut sums, mut largest) = ([0.0; 2], 0.0f64);
            packed::scaled_squares(&scale, &defect, |times, square| {
                sums[0] += times * square;
                largest = largest.max(square);
            });
            packed::scaled_squares(&scale, whole, |times, square| sums[1] += times * square);
            (sums, largest)
        };
        let found = modes.iter().enumerate().map(of_parity);
        let ([defect, whole], largest) = found.fold(([0.0; 2], 0.0f64), |([a, b], largest), ([c, d], other)| {
            ([a + c, b + d], largest.max(other))
        });
        match norm {
            Norm::Largest => largest.sqrt(),
            Norm::MeanSquare => (defect / whole.max(f64::MIN_POSITIVE)).sqrt(),
        }
    };
    let defects: Vec<Vec<f64>> = interval.defects();
    let tests: Vec<(Vec<f64>, &usize)> = defects.into_iter().zip(interval.test_nodes()).collect();
    tests.into_par_iter().map(at).map(or_infinite).reduce(|| 0.0, f64::max)
}
