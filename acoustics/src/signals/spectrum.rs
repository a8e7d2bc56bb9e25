use super::bands::{Band, band_containing, bands_of, edge};
use super::error::LevelsError;
use super::{Level, Weighting, energy_level};
use crate::checks::{finite, same_length};
use nailnoise_meshes::gauss_legendre;
use serde::{Deserialize, Serialize};
use std::sync::LazyLock;

/// One part of a source; the parts of a spectrum add up to it at every frequency.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Contribution {
    /// Name of the part: a surface patch or a mechanism.
    pub name: String,
    /// Energy density \[J/Hz\] on the frequencies of the spectrum. Negative where a patch absorbs sound from others.
    pub energy_density: Vec<f64>,
}

/// Sound energy radiated by one source during one shot, as a one-sided spectral density.
///
/// E(f) is linear between the given frequencies and zero outside; all integrals below are exact for that function.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SourceSpectrum {
    /// Name of the source.
    pub source: String,
    /// Label of the method, shown with every result.
    pub method: String,
    /// Frequencies \[Hz\], ascending.
    pub frequency: Vec<f64>,
    /// Energy spectral density E(f) \[J/Hz\].
    pub energy_density: Vec<f64>,
    /// Range over which the source was computed \[Hz\].
    pub range_hz: [f64; 2],
    /// Parts that add up to `energy_density`; empty if the source has none.
    pub contributions: Vec<Contribution>,
}

/// Energy and levels of one one-third-octave band.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BandLevel {
    /// The band.
    pub band: Band,
    /// Energy within both the band and the requested range \[J\].
    pub energy: f64,
    /// Unweighted level L_W,1s \[dB re 1 pW s\].
    pub lw: Level,
    /// A-weighted energy \[J\].
    pub a_energy: f64,
    /// A-weighted level L_WA,1s \[dB re 1 pW s\].
    pub lwa: Level,
}

impl SourceSpectrum {
    /// A spectrum without contributions.
    ///
    /// # Errors
    /// If lengths differ, values are not finite, or frequencies are not ascending.
    pub fn new(
        source: impl Into<String>,
        method: impl Into<String>,
        frequency: Vec<f64>,
        energy_density: Vec<f64>,
        range_hz: [f64; 2],
    ) -> Result<Self, LevelsError> {
        same_length("energy density", energy_density.len(), frequency.len())?;
        finite("frequency", &frequency)?;
        finite("energy density", &energy_density)?;
        if let Some(pair) = frequency.windows(2).find(|pair| pair[1] <= pair[0]) {
            return Err(LevelsError::Frequencies {
                previous: pair[0],
                next: pair[1],
            });
        }
        Ok(Self {
            source: source.into(),
            method: method.into(),
            frequency,
            energy_density,
            range_hz,
            contributions: Vec::new(),
        })
    }

    /// Subtracts a part given on the same frequencies, which becomes a separate, negative contribution.
    ///
    /// # Errors
    /// If the number of frequencies differs from the spectrum's.
    pub fn without(&self, part: &Self) -> Result<Self, LevelsError> {
        same_length("energy density of the part", part.frequency.len(), self.frequency.len())?;
        let taken: Vec<f64> = part.energy_density.iter().map(|energy| -energy).collect();
        let mut rest = self.clone();
        rest.energy_density
            .iter_mut()
            .zip(&taken)
            .for_each(|(energy, taken)| *energy += taken);
        rest.contributions.push(Contribution {
            name: format!("{}, counted elsewhere", part.source),
            energy_density: taken,
        });
        Ok(rest)
    }

    /// The spectrum of a silent source.
    pub fn silent(source: impl Into<String>, method: impl Into<String>, range_hz: [f64; 2]) -> Self {
        Self {
            source: source.into(),
            method: method.into(),
            frequency: Vec::new(),
            energy_density: Vec::new(),
            range_hz,
            contributions: Vec::new(),
        }
    }

    /// Energy between two frequencies \[J\], with the weighting applied under the integral.
    pub fn energy(&self, range_hz: [f64; 2], weighting: Weighting) -> f64 {
        integrate(&self.frequency, &self.energy_density, range_hz, weighting)
    }

    /// Level of [`Self::energy`].
    pub fn level(&self, range_hz: [f64; 2], weighting: Weighting) -> Level {
        energy_level(self.energy(range_hz, weighting))
    }

    /// Energies of the contributions between two frequencies \[J\]; they add up to [`Self::energy`].
    pub fn contribution_energies(&self, range_hz: [f64; 2], weighting: Weighting) -> Vec<(String, f64)> {
        let of = |part: &Contribution| integrate(&self.frequency, &part.energy_density, range_hz, weighting);
        self.contributions
            .iter()
            .map(|part| (part.name.clone(), of(part)))
            .collect()
    }

    /// Levels in the bands of the range, see [`bands_of`]. A band cut by an end of `range_hz` contains only the energy
    /// inside, so that the bands add up to [`Self::energy`] to round-off.
    pub fn band_levels(&self, range_hz: [f64; 2]) -> Vec<BandLevel> {
        let level_of = |band: Band| {
            let cut = [band.low.max(range_hz[0]), band.high.min(range_hz[1])];
            let (energy, a_energy) = (self.energy(cut, Weighting::Z), self.energy(cut, Weighting::A));
            BandLevel {
                band,
                energy,
                lw: energy_level(energy),
                a_energy,
                lwa: energy_level(a_energy),
            }
        };
        bands_of(range_hz).into_iter().map(level_of).collect()
    }

    /// Sum of the spectra of independent parts. It is given on the union of their frequencies, where the sum of
    /// piecewise linear functions is exact. A part that ends before the others drops to zero within one rounding step
    /// of its last frequency, so that its energy does not extend beyond. The parts become the contributions. The range
    /// is the intersection of their ranges.
    pub fn sum(source: impl Into<String>, method: impl Into<String>, parts: &[Self]) -> Self {
        let ends = |part: &Self| Some([part.frequency.first()?.next_down(), part.frequency.last()?.next_up()]);
        let jumps: Vec<f64> = parts.iter().filter_map(ends).flatten().collect();
        let mut frequency: Vec<f64> = parts.iter().flat_map(|part| part.frequency.iter().copied()).collect();
        let (low, high) = frequency
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &f| (a.min(f), b.max(f)));
        frequency.extend(jumps.into_iter().filter(|f| (low..=high).contains(f)));
        frequency.sort_by(f64::total_cmp);
        frequency.dedup();
        let contributions: Vec<Contribution> = parts
            .iter()
            .map(|part| Contribution {
                name: part.source.clone(),
                energy_density: frequency.iter().map(|&f| part.density_at(f)).collect(),
            })
            .collect();
        let energy_density = (0..frequency.len())
            .map(|i| contributions.iter().map(|part| part.energy_density[i]).sum())
            .collect();
        let low = parts.iter().map(|part| part.range_hz[0]).fold(0.0, f64::max);
        let high = parts.iter().map(|part| part.range_hz[1]).fold(f64::INFINITY, f64::min);
        Self {
            source: source.into(),
            method: method.into(),
            frequency,
            energy_density,
            range_hz: [low, high],
            contributions,
        }
    }

    /// E(f) \[J/Hz\], linear between the frequencies and zero outside.
    pub fn density_at(&self, hz: f64) -> f64 {
        interpolate(&self.frequency, &self.energy_density, hz)
    }
}

/// Value at `hz` of the function that is linear between the frequencies and zero outside.
fn interpolate(frequency: &[f64], density: &[f64], hz: f64) -> f64 {
    let after = frequency.partition_point(|&f| f < hz);
    match (frequency.get(after), after.checked_sub(1)) {
        (Some(&f), _) if f == hz => density[after],
        (Some(&f1), Some(before)) => {
            let f0 = frequency[before];
            let share = (hz - f0) / (f1 - f0);
            (1.0 - share) * density[before] + share * density[after]
        }
        _ => 0.0,
    }
}

/// Gauss rule for one piece.
static RULE: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss_legendre(3));

/// Integral of a piecewise linear density times the weighting over `range`.
fn integrate(frequency: &[f64], density: &[f64], range: [f64; 2], weighting: Weighting) -> f64 {
    let mut total = 0.0;
    pieces(frequency, range, weighting, |i, lower, upper| {
        total += lower * density[i] + upper * density[i + 1];
    });
    total
}

/// Weights w_k with which the energy of a spectrum becomes a sum over its frequencies.
///
/// ```text
/// int E(f) 10^{A(f)/10} df = sum_k w_k E(f_k)
/// ```
///
/// The integral is that of [`SourceSpectrum::energy`] with E piecewise linear: w_k is the weighted integral of the hat
/// function of f_k over `range`, whose ends may cut it.
pub fn energy_weights(frequency: &[f64], range: [f64; 2], weighting: Weighting) -> Vec<f64> {
    let mut weights = vec![0.0; frequency.len()];
    pieces(frequency, range, weighting, |i, lower, upper| {
        weights[i] += lower;
        weights[i + 1] += upper;
    });
    weights
}

/// Calls `add(i, lower, upper)` with weighted integrals of the falling and the rising hat function over pieces of
/// interval i of the frequency grid.
///
/// Every interval is split at the edges of all one-third-octave bands, whatever the range, and each piece is integrated
/// by the same Gauss rule. The result is exact for Z and additive over bands for every weighting.
fn pieces(frequency: &[f64], range: [f64; 2], weighting: Weighting, mut add: impl FnMut(usize, f64, f64)) {
    let [low, high] = range;
    if frequency.len() < 2 || low.is_nan() || high.is_nan() || high <= low {
        return;
    }
    let rule = &*RULE;
    let first = frequency.partition_point(|&f| f <= low).saturating_sub(1);
    // Number and frequency of the next edge.
    let mut cut: Option<(i32, f64)> = None;
    for i in first..frequency.len() - 1 {
        let (f0, f1) = (frequency[i], frequency[i + 1]);
        if f0 >= high {
            break;
        }
        let (mut a, end) = (f0.max(low), f1.min(high));
        if cut.is_none() && a > 0.0 {
            let next = band_containing(a).index + 1;
            cut = Some((next, edge(next)));
        }
        while a < end {
            let b = cut.map_or(end, |(_, edge)| edge.min(end));
            let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
            let (mut lower, mut upper) = (0.0, 0.0);
            for (x, w) in rule {
                let f = middle + half * x;
                let value = half * w * weighting.energy_factor(f);
                let share = (f - f0) / (f1 - f0);
                lower += (1.0 - share) * value;
                upper += share * value;
            }
            add(i, lower, upper);
            a = b;
            cut = cut.map(|(number, at)| {
                if at <= a {
                    (number + 1, edge(number + 1))
                } else {
                    (number, at)
                }
            });
        }
    }
}
