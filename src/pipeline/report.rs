//! What stands beside the power of a surface: the second evaluation, the reference of radiation efficiency 1, and how
//! well the limit of high frequencies meets the boundary elements.

use nailnoise_acoustics::bem::ModalBem;
use nailnoise_acoustics::levels::{BandLevel, SourceSpectrum, Weighting, energy_level};
use nailnoise_acoustics::radiation::ModalRadiation;

use super::radiator::Flush;
use crate::result::{Check, RadiationBand, RadiationReport};

/// Bands below the join by which the limit is judged.
const JUDGED: usize = 3;

/// Largest difference between the two evaluations of the A-weighted level \[dB\].
const DIFFERENCE: f64 = 0.1;

/// Check that surface and far field agree.
pub(super) fn check(source: &str, report: &RadiationReport) -> Option<Check> {
    let difference = report.surface_difference_db?;
    let name = format!("{source}: power by the surface less that by the far field [dB]");
    Some(Check::at_most(name, difference, DIFFERENCE))
}

/// The report of one source: its power by the far field, by the surface, and with radiation efficiency 1.
pub(super) fn report(
    bem: &ModalBem,
    far_field: &SourceSpectrum,
    surface: &SourceSpectrum,
    erp: &SourceSpectrum,
) -> RadiationReport {
    let range = far_field.range_hz;
    let [from, to] = bem.blend_hz();
    let solved = [range[0], from.min(range[1])];
    let level = |spectrum: &SourceSpectrum, range: [f64; 2]| energy_level(spectrum.energy(range, Weighting::A));
    let difference = level(surface, solved)
        .zip(level(far_field, solved))
        .map(|(surface, far_field)| surface - far_field);
    let bands = far_field.band_levels(range);
    let (by_surface, by_erp) = (surface.band_levels(range), erp.band_levels(range));
    let inside = |b: &BandLevel| b.band.high > range[0] && b.band.low < range[1];
    let rows = bands.iter().zip(&by_surface).zip(&by_erp);
    let mut limit = [f64::INFINITY, f64::NEG_INFINITY];
    let whole = rows
        .clone()
        .filter(|((far, _), _)| far.band.low >= range[0] && far.band.high <= from * (1.0 + 1e-9));
    for ((far, _), erp) in whole.rev().take(JUDGED) {
        if let (Some(far), Some(erp)) = (far.lw, erp.lw) {
            limit = [limit[0].min(erp - far), limit[1].max(erp - far)];
        }
    }
    RadiationReport {
        join_hz: [from, to],
        frequencies: bem.summary.samples,
        interpolation_error: bem.summary.interpolation,
        surface_difference_db: difference,
        limit_error_db: if limit[0] <= limit[1] { limit } else { [0.0; 2] },
        blend_error_db: None,
        erp_lwa_db: level(erp, range),
        modes: Vec::new(),
        bands: rows
            .filter(|((far, _), _)| inside(far))
            .map(|((far, surface), erp)| RadiationBand {
                hz: far.band.nominal_hz(),
                lw_db: far.lw,
                surface_lw_db: if far.band.high <= from { surface.lw } else { None },
                erp_lw_db: erp.lw,
            })
            .collect(),
    }
}

/// The report of a flush surface: its power by plane waves, by the intensity on the surface (`ratios`, band by band of
/// those of the second evaluation) and with radiation efficiency 1.
pub(super) fn flush_report(
    flush: &Flush,
    waves: &SourceSpectrum,
    ratios: &[Option<f64>],
    erp: &SourceSpectrum,
) -> RadiationReport {
    let range = waves.range_hz;
    let ratio_of = |band: i32| {
        let place = flush.surface.bands().iter().position(|own| own.index == band)?;
        ratios[place]
    };
    let bands = waves.band_levels(range);
    let (mut by_waves, mut by_surface) = (0.0, 0.0);
    for band in &bands {
        if let Some(ratio) = ratio_of(band.band.index) {
            let energy = waves.energy(
                [band.band.low.max(range[0]), band.band.high.min(range[1])],
                Weighting::A,
            );
            by_waves += energy;
            by_surface += ratio * energy;
        }
    }
    let inside = |b: &BandLevel| b.band.high > range[0] && b.band.low < range[1];
    let rows = bands.iter().zip(erp.band_levels(range));
    RadiationReport {
        // There is no other law above.
        join_hz: [flush.waves.highest_hz(); 2],
        frequencies: flush.waves.sampled_hz().len(),
        interpolation_error: flush.waves.interpolation_error(),
        surface_difference_db: (by_waves > 0.0).then(|| 10.0 * (by_surface / by_waves).log10()),
        limit_error_db: [0.0; 2],
        blend_error_db: None,
        erp_lwa_db: energy_level(erp.energy(range, Weighting::A)),
        modes: Vec::new(),
        bands: rows
            .filter(|(waves, _)| inside(waves))
            .map(|(waves, erp)| RadiationBand {
                hz: waves.band.nominal_hz(),
                lw_db: waves.lw,
                surface_lw_db: waves
                    .lw
                    .zip(ratio_of(waves.band.index))
                    .map(|(lw, ratio)| lw + 10.0 * ratio.log10()),
                erp_lw_db: erp.lw,
            })
            .collect(),
    }
}
