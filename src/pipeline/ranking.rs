//! The ranked table: levels of every source over the common range.

use nailnoise_acoustics::levels::{self, BandLevel as Band, Level, SourceSpectrum, Weighting, level_energy};

use super::sound::Source;
use crate::result::{BandLevel, Check, Component, RankedSource, Total};

/// Ranks the sources by A-weighted energy over `range_hz`.
pub(super) fn rank(sources: &[&Source], range_hz: [f64; 2]) -> (Vec<RankedSource>, Total) {
    let spectra: Vec<SourceSpectrum> = sources.iter().map(|source| source.spectrum.clone()).collect();
    let ranking = levels::rank(&spectra, range_hz);
    let ranked = |source: &levels::RankedSource| {
        let sound = sources.iter().find(|s| s.spectrum.source == source.source)?;
        Some(RankedSource {
            source: source.source.clone(),
            lwa_db: source.lwa,
            lw_db: source.lw,
            share: source.share.unwrap_or(0.0),
            method: source.method.clone(),
            range_hz: source.range_hz,
            lwa_own_range_db: source.own_lwa,
            bands: bands(&sound.spectrum, range_hz),
            components: components(&sound.spectrum, range_hz),
            uncertainty_db: sound.uncertainty.clone(),
            cross_check: sound.cross_check.clone(),
            radiation: sound.radiation.clone(),
            intervals: Vec::new(),
        })
    };
    (
        ranking.sources.iter().filter_map(ranked).collect(),
        Total {
            lwa_db: ranking.total_lwa,
            lw_db: ranking.total_lw,
        },
    )
}

/// The bands that reach into the range.
fn bands(spectrum: &SourceSpectrum, range_hz: [f64; 2]) -> Vec<BandLevel> {
    let inside = |b: &&Band| b.band.high > range_hz[0] && b.band.low < range_hz[1];
    let level = |b: &Band| BandLevel {
        hz: b.band.nominal_hz(),
        lw_db: b.lw,
        lwa_db: b.lwa,
    };
    spectrum
        .band_levels(range_hz)
        .iter()
        .filter(inside)
        .map(level)
        .collect()
}

fn components(spectrum: &SourceSpectrum, range_hz: [f64; 2]) -> Vec<Component> {
    parts_of(spectrum)
        .into_iter()
        .map(|part| Component {
            lwa_db: part.level(range_hz, Weighting::A),
            lw_db: part.level(range_hz, Weighting::Z),
            bands: bands(&part, range_hz),
            name: part.source,
        })
        .collect()
}

/// The contributions of a spectrum as spectra of their own.
pub(super) fn parts_of(spectrum: &SourceSpectrum) -> Vec<SourceSpectrum> {
    let part = |contribution: &levels::Contribution| SourceSpectrum {
        source: contribution.name.clone(),
        method: spectrum.method.clone(),
        frequency: spectrum.frequency.clone(),
        energy_density: contribution.energy_density.clone(),
        range_hz: spectrum.range_hz,
        contributions: Vec::new(),
    };
    spectrum.contributions.iter().map(part).collect()
}

/// Checks that bands sum to each source's level and sources to the total, as relative energy.
pub(super) fn checks(ranking: &[RankedSource], total: &Total) -> Vec<Check> {
    let gap = |sum: f64, whole: Level| {
        let whole = level_energy(whole);
        if whole > 0.0 { (sum / whole - 1.0).abs() } else { sum }
    };
    let mut checks: Vec<Check> = ranking
        .iter()
        .map(|source| {
            let weighted: f64 = source.bands.iter().map(|band| level_energy(band.lwa_db)).sum();
            let plain: f64 = source.bands.iter().map(|band| level_energy(band.lw_db)).sum();
            let worst = gap(weighted, source.lwa_db).max(gap(plain, source.lw_db));
            Check::at_most(format!("{}: bands sum to the total", source.source), worst, 1e-9)
        })
        .collect();
    let sum = ranking.iter().map(|source| level_energy(source.lwa_db)).sum();
    checks.push(Check::at_most("sources sum to the total", gap(sum, total.lwa_db), 1e-9));
    checks
}
