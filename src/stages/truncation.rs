//! Truncation: the energy of a part above its top frequency, beyond the modes of the model.
//!
//! The part does not radiate there. The missing energy is estimated by extrapolating the slope of its last octave.

use std::borrow::Cow;

use nailnoise_acoustics::signals::{BandLevel, SourceSpectrum, Weighting, bands_of};
use serde::{Deserialize, Serialize};

use crate::result::Check;

/// Number of third-octave bands in an octave.
const OCTAVE: usize = 3;

/// Largest truncation of a source's A-weighted level \[dB\].
const LIMIT_DB: f64 = 0.2;

/// A part of a source whose model ends at a top frequency.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LimitedPart {
    /// Its name in results.
    pub name: Cow<'static, str>,
    /// Name, or beginning of the names, of its contributions to the source.
    pub contribution: Cow<'static, str>,
    /// Its top frequency \[Hz\].
    pub top_hz: f64,
}

/// A-weighted energy that is missing from a source above the top frequency of a part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Truncation {
    /// Name of the part.
    pub part: Cow<'static, str>,
    /// Name of the source.
    pub source: Cow<'static, str>,
    /// Top frequency of the part \[Hz\].
    pub top_hz: f64,
    /// Increase of the source's A-weighted level if the energy were included \[dB\].
    pub decibels: f64,
}

impl Truncation {
    /// Note on it.
    pub fn note(&self) -> String {
        format!(
            "{} is not modelled above {:.0} Hz; extrapolation of its last octave would add {:.2} dB to the {}",
            self.part, self.top_hz, self.decibels, self.source
        )
    }

    /// The check that it is small.
    pub fn check(&self) -> Check {
        let name = format!(
            "{} above {:.0} Hz, estimated from its last octave [dB]",
            self.part, self.top_hz
        );
        Check::at_most(name, self.decibels, LIMIT_DB)
    }
}

/// Truncations of a source within a range \[Hz\], for its parts that end below the top of the range.
pub fn truncations(
    source: (&'static str, &SourceSpectrum),
    range_hz: [f64; 2],
    parts: impl IntoIterator<Item = LimitedPart>,
) -> Vec<Truncation> {
    let cut = parts.into_iter().filter(|part| part.top_hz < range_hz[1]);
    cut.map(|part| truncation(source, range_hz, part)).collect()
}

fn truncation((source, whole): (&'static str, &SourceSpectrum), range_hz: [f64; 2], part: LimitedPart) -> Truncation {
    let total = whole.energy(range_hz, Weighting::A);
    // Contributions are bodies, or patches named after their body.
    let belongs = |name: &str| {
        let rest = name.strip_prefix(&*part.contribution);
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(' '))
    };
    let mut found = whole.contributions.iter().filter(|part| belongs(&part.name)).peekable();
    let energy_density = if found.peek().is_none() {
        whole.energy_density.clone()
    } else {
        found.fold(vec![0.0; whole.energy_density.len()], |mut sum, part| {
            sum.iter_mut().zip(&part.energy_density).for_each(|(sum, e)| *sum += e);
            sum
        })
    };
    let spectrum = SourceSpectrum {
        energy_density,
        contributions: Vec::new(),
        ..whole.clone()
    };
    let absent = extrapolated(&spectrum, part.top_hz, range_hz[1]);
    let decibels = if total > 0.0 {
        10.0 * (1.0 + absent / total).log10()
    } else {
        0.0
    };
    Truncation {
        part: part.name,
        source: source.into(),
        top_hz: part.top_hz,
        decibels,
    }
}

/// A-weighted energy between `top` and `high` if the band energies continued as in the octave below `top` \[J\].
///
/// The line of 10 lg E over the band number is fitted by least squares to the last three complete bands. Its slope is
/// at most zero, because a rising end does not show where the rise ends.
fn extrapolated(spectrum: &SourceSpectrum, top: f64, high: f64) -> f64 {
    let bands: Vec<BandLevel> = spectrum.band_levels([0.0, top]);
    let whole = bands
        .iter()
        .filter(|b| b.band.high <= top * (1.0 + 1e-9) && b.energy > 0.0);
    let last: Vec<&BandLevel> = whole.rev().take(OCTAVE).collect();
    if last.len() < OCTAVE {
        return 0.0;
    }
    let level = |b: &BandLevel| 10.0 * b.energy.log10();
    let slope = ((level(last[0]) - level(last[OCTAVE - 1])) / (OCTAVE - 1) as f64).min(0.0);
    let mean = last.iter().map(|b| level(b)).sum::<f64>() / OCTAVE as f64;
    let centre = f64::from(last[OCTAVE / 2].band.index);
    bands_of([top, high])
        .into_iter()
        .filter(|band| band.high > top && band.low < high)
        .map(|band| {
            let energy = 10f64.powf((mean + slope * (f64::from(band.index) - centre)) / 10.0);
            let covered = (band.high.min(high) / band.low.max(top)).ln() / (band.high / band.low).ln();
            energy * covered * Weighting::A.energy_factor(band.hz)
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A spectrum E(f) = f^-3 cut at `top`: bands fall by 2 dB each, and the energy above is known. The weighting is
    /// evaluated at mid-band, hence 5 %.
    #[test]
    fn a_power_law_is_continued() {
        let (top, high) = (5011.872, 10_000.0);
        let grid: Vec<f64> = (40..=12_000).map(f64::from).collect();
        let density: Vec<f64> = grid.iter().map(|f| f.powi(-3)).collect();
        let full = SourceSpectrum::new("s", "m", grid.clone(), density, [50.0, 12_000.0]).unwrap();
        let expected = full.energy([top, high], Weighting::A);
        let found = extrapolated(&full, top, high);
        assert!((found / expected - 1.0).abs() < 0.05, "{found} {expected}");
    }
}
