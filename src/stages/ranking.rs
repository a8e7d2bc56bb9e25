//! The ranking: levels, bands and intervals of every source over the common range, and its power over time.

use nailnoise_acoustics::signals::{
    self, BandLevel as Band, Level, PowerHistory, SILENCE, SourceSpectrum, Weighting, energy_level, level_energy,
};

use super::intervals::Interval;
use super::sound::{SoundSource, parts_of};
use crate::result::{BandLevel, Check, Component, IntervalLevel, RankedSource, Starts, Total};

/// Length of the cells in power histories \[s\].
const CELL: f64 = 1e-4;

/// Time shown before and after the records \[s\], because the finite frequency range spreads a sudden sound to both
/// sides.
const MARGIN: f64 = 0.01;

/// Largest relative difference between a signal's bins and those of the spectrum, in addition to the interpolation
/// error of the resistance, which enters with its square root: 0.04 dB.
const MISMATCH: f64 = 1e-2;

/// Largest relative difference between a sum of energies and the total energy.
const ROUNDING: f64 = 1e-9;

/// A source's A-weighted power over time, in the common range.
#[derive(Debug, Clone)]
pub struct SoundPower {
    /// Name of the source.
    pub source: String,
    /// Its power over the time of the cycle.
    pub history: PowerHistory,
}

/// Ranks the sources by A-weighted energy over `range_hz`.
pub fn rank(sources: &[&SoundSource], range_hz: [f64; 2]) -> (Vec<RankedSource>, Total) {
    let spectra: Vec<&SourceSpectrum> = sources.iter().map(|source| &source.spectrum).collect();
    let ranking = signals::rank(&spectra, range_hz);
    let ranked = |place: &signals::RankedSource| {
        let sound = sources[place.index];
        RankedSource {
            source: sound.spectrum.source.clone(),
            lwa_db: place.lwa,
            lw_db: place.lw,
            share: place.share.unwrap_or(0.0),
            method: sound.spectrum.method.clone(),
            range_hz: sound.spectrum.range_hz,
            lwa_own_range_db: sound.spectrum.level(sound.spectrum.range_hz, Weighting::A),
            bands: bands(&sound.spectrum, range_hz),
            components: components(sound, range_hz),
            uncertainty_db: sound.uncertainty.clone(),
            cross_check: sound.cross_check.clone(),
            radiation: sound.radiation.clone(),
            intervals: sound.intervals.iter().map(Interval::in_result).collect(),
        }
    };
    let total = Total {
        lwa_db: ranking.total_lwa,
        lw_db: ranking.total_lw,
    };
    (ranking.sources.iter().map(ranked).collect(), total)
}

/// The bands that overlap the range.
fn bands(spectrum: &SourceSpectrum, range_hz: [f64; 2]) -> Vec<BandLevel> {
    let inside = |b: &&Band| b.band.high > range_hz[0] && b.band.low < range_hz[1];
    let level = |b: &Band| BandLevel {
        hz: b.band.nominal_hz(),
        lw_db: b.lw,
        lwa_db: b.lwa,
        energies_j: (b.energy < 0.0 || b.a_energy < 0.0).then_some([b.energy, b.a_energy]),
    };
    spectrum
        .band_levels(range_hz)
        .iter()
        .filter(inside)
        .map(level)
        .collect()
}

fn components(source: &SoundSource, range_hz: [f64; 2]) -> Vec<Component> {
    let moved = |part: &SourceSpectrum| source.moved.contains(&part.source);
    parts_of(&source.spectrum)
        .into_iter()
        .map(|part| {
            let [plain, weighted] = [Weighting::Z, Weighting::A].map(|weighting| part.energy(range_hz, weighting));
            Component {
                lwa_db: energy_level(weighted),
                lw_db: energy_level(plain),
                energies_j: (moved(&part) && (plain < 0.0 || weighted < 0.0)).then_some([plain, weighted]),
                bands: bands(&part, range_hz)
                    .into_iter()
                    .map(|band| BandLevel {
                        energies_j: band.energies_j.filter(|_| moved(&part)),
                        ..band
                    })
                    .collect(),
                name: part.source,
            }
        })
        .collect()
}

/// Power over time of the ranked sources, for records that last until `end` \[s\].
pub fn powers(ranking: &[RankedSource], sources: &[&SoundSource], end: f64) -> Vec<SoundPower> {
    let cells = ((end + 2.0 * MARGIN) / CELL).ceil() as usize;
    let power = |(ranked, source): (&RankedSource, &SoundSource)| SoundPower {
        source: ranked.source.clone(),
        history: PowerHistory::sum(&source.histories, 0.5 * CELL - MARGIN, CELL, cells),
    };
    paired(ranking, sources).map(power).collect()
}

/// Difference between the sum of the parts of a source and the source, relative to the source.
///
/// Parts below [`SILENCE`] have no level, so that they are missing from the sum: each of the `silent` parts may
/// contribute up to that energy.
fn gap(sum: f64, silent: usize, whole: Level) -> f64 {
    let whole = level_energy(whole);
    let difference = ((sum - whole).abs() - silent as f64 * SILENCE).max(0.0);
    difference / whole.max(SILENCE)
}

/// Checks that bands sum to each source's level and sources to the total, as relative energies.
pub fn checks(ranking: &[RankedSource], total: &Total) -> Vec<Check> {
    let mut checks: Vec<Check> = ranking
        .iter()
        .map(|source| {
            let [plain, weighted] = source.bands.iter().fold([0.0; 2], |[plain, weighted], band| {
                let [own_plain, own_weighted] = band.energies();
                [plain + own_plain, weighted + own_weighted]
            });
            let silent =
                |level: fn(&BandLevel) -> Level| source.bands.iter().filter(|band| level(band).is_none()).count();
            let plain = gap(plain, silent(|band| band.lw_db), source.lw_db);
            let worst = gap(weighted, silent(|band| band.lwa_db), source.lwa_db).max(plain);
            Check::at_most(format!("{}: bands sum to the total", source.source), worst, ROUNDING)
        })
        .collect();
    let sum = ranking.iter().map(|source| level_energy(source.lwa_db)).sum();
    let silent = ranking.iter().filter(|source| source.lwa_db.is_none()).count();
    checks.push(Check::at_most(
        "sources sum to the total",
        gap(sum, silent, total.lwa_db),
        ROUNDING,
    ));
    checks
}

/// Checks that intervals sum to each source's level, and that signals have the energy of the spectra; `tolerance` is
/// the error of interpolated resistances.
pub fn interval_checks(ranking: &[RankedSource], sources: &[&SoundSource], tolerance: f64) -> Vec<Check> {
    let mut checks = Vec::new();
    for (ranked, source) in paired(ranking, sources) {
        let sum: f64 = ranked.intervals.iter().map(IntervalLevel::energy).sum();
        let silent = ranked
            .intervals
            .iter()
            .filter(|interval| interval.lwa_db.is_none())
            .count();
        let name = format!("{}: intervals sum to the total", ranked.source);
        checks.push(Check::at_most(name, gap(sum, silent, ranked.lwa_db), ROUNDING));
        for (part, mismatch) in &source.mismatches {
            let name =
                format!("{part}: relative difference between the energies of the interval signals and of the spectrum");
            checks.push(Check::at_most(name, *mismatch, MISMATCH + tolerance));
        }
    }
    checks
}

/// Each ranked source with its analysis.
fn paired<'a>(
    ranking: &'a [RankedSource],
    sources: &'a [&SoundSource],
) -> impl Iterator<Item = (&'a RankedSource, &'a SoundSource)> {
    ranking.iter().filter_map(|ranked| {
        let source = sources.iter().find(|own| own.spectrum.source == ranked.source)?;
        Some((ranked, *source))
    })
}

/// Increases the uncertainty of the source `name` by two standard deviations over its starts.
pub fn widen(ranking: &mut [RankedSource], name: &str, starts: &Starts) {
    let spread = 2.0 * starts.deviation_db;
    for source in ranking.iter_mut().filter(|source| source.source == name) {
        let band = &mut source.uncertainty_db;
        let wider = |bound: Option<f64>| bound.map(|bound| bound.hypot(spread).copysign(bound));
        (band.minus, band.plus) = (wider(band.minus), wider(band.plus));
        band.basis.push_str(&format!(
            "; two standard deviations of {} starts, {spread:.1} dB, added as squares",
            starts.lwa_db.len()
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_too_faint_for_a_level_are_no_gap_and_absent_energy_is_one() {
        // 0.1 fJ in one band, and 20 bands without a level, each with half the energy of silence.
        let loud = 1e-16;
        let whole = energy_level(loud + 20.0 * 0.5 * SILENCE);
        assert_eq!(gap(loud, 20, whole), 0.0);
        assert!(gap(loud, 0, whole) > 1e-4);
        // A missing part of one millionth.
        let part = 1e-6;
        assert!((gap(1.0 - part, 20, energy_level(1.0)) / part - 1.0).abs() < 1e-6);
        assert!((gap(1.0 + part, 0, energy_level(1.0)) / part - 1.0).abs() < 1e-6);
        // A silent source, with and without bands that contradict it.
        assert_eq!(gap(0.0, 27, None), 0.0);
        assert!(gap(1e-12, 0, None) > 1.0);
    }
}
