//! What stands beside the power of a surface: the second evaluation, the reference of radiation efficiency 1, and how
//! well the limit of high frequencies meets the boundary elements.

use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::ModalBem;
use nailnoise_acoustics::levels::{BandLevel, SourceSpectrum, Weighting, energy_level};
use nailnoise_acoustics::radiation::{ModalRadiation, ModalSpectra, sphere_efficiency};

use super::radiator::Flush;
use crate::result::{Check, RadiationBand, RadiationReport};

/// Last bands of boundary elements by which the limit is judged.
const JUDGED: usize = 3;

/// Largest difference between the two evaluations of the A-weighted level \[dB\].
const DIFFERENCE: f64 = 0.1;

/// Check that surface and far field agree.
pub(super) fn check(source: &str, report: &RadiationReport) -> Option<Check> {
    let difference = report.surface_difference_db?;
    let name = format!("{source}: power by the surface less that by the far field [dB]");
    Some(Check::at_most(name, difference, DIFFERENCE))
}

/// The report of one source: its power by the far field, by the surface, with radiation efficiency 1, and by the limit of
/// high frequencies where boundary elements are known too.
pub(super) fn report(
    bem: &ModalBem,
    together: &ModalSpectra,
    [far_field, surface, erp]: [&SourceSpectrum; 3],
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
    let limit = limit(bem, together, far_field);
    let compared = bem.compared_hz();
    let within = |[low, high]: [f64; 2]| low >= compared[0].max(range[0]) && high <= compared[1].min(range[1]);
    let error = |[low, high]: [f64; 2]| {
        let energies = [&limit, far_field].map(|spectrum| spectrum.energy([low, high], Weighting::Z));
        (within([low, high]) && energies.iter().all(|e| *e > 0.0)).then(|| 10.0 * (energies[0] / energies[1]).log10())
    };
    let edges = |band: &BandLevel| [band.band.low, band.band.high];
    let judged = bands.iter().rev().filter_map(|band| error(edges(band))).take(JUDGED);
    let ends = judged.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], error| {
        [least.min(error), most.max(error)]
    });
    RadiationReport {
        join_hz: [from, to],
        solved_hz: [bem.solved_hz()[1], compared[1]],
        frequencies: bem.summary.samples,
        interpolation_error: bem.summary.interpolation,
        surface_difference_db: difference,
        limit_error_db: if ends[0] <= ends[1] { ends } else { [0.0; 2] },
        blend_error_db: error([compared[1] * 2f64.powf(-1.0 / 3.0), compared[1]]),
        erp_lwa_db: level(erp, range),
        modes: Vec::new(),
        bands: rows
            .filter(|((far, _), _)| inside(far))
            .map(|((far, surface), erp)| RadiationBand {
                hz: far.band.nominal_hz(),
                lw_db: far.lw,
                surface_lw_db: if far.band.high <= from { surface.lw } else { None },
                erp_lw_db: erp.lw,
                limit_lw_db: far.lw.zip(error(edges(far))).map(|(lw, error)| lw + error),
            })
            .collect(),
    }
}

/// The power by the limit of high frequencies alone, zero where it is not compared with boundary elements.
fn limit(bem: &ModalBem, together: &ModalSpectra, far_field: &SourceSpectrum) -> SourceSpectrum {
    let [from, to] = bem.compared_hz();
    // A bin on either side holds the ends.
    let inside: Vec<usize> = (0..together.frequency.len())
        .filter(|&bin| (0.95 * from..1.05 * to).contains(&together.frequency[bin]))
        .collect();
    let hz: Vec<f64> = inside.iter().map(|&bin| together.frequency[bin]).collect();
    let forms = bem.limit_forms(&hz, &together.accelerations.select_columns(&inside));
    let mut energy_density = vec![0.0; together.frequency.len()];
    for (bin, form) in inside.into_iter().zip(forms) {
        energy_density[bin] = 2.0 * form;
    }
    SourceSpectrum {
        energy_density,
        contributions: Vec::new(),
        ..far_field.clone()
    }
}

/// The report of a flush surface: its power by spherical waves, by the intensity on the surface (`ratios`, band by band of
/// those of the second evaluation) and with radiation efficiency 1.
pub(super) fn flush_report(
    flush: &Flush,
    waves: &SourceSpectrum,
    ratios: &[Option<f64>],
    erp: &SourceSpectrum,
) -> RadiationReport {
    let range = waves.range_hz;
    let ratio_of = |band: i32| {
        let place = flush.sound.surface.bands().iter().position(|own| own.index == band)?;
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
        join_hz: [flush.sound.waves.highest_hz().min(range[1]); 2],
        solved_hz: [flush.sound.waves.highest_hz().min(range[1]); 2],
        frequencies: flush.sound.waves.sampled_hz().len(),
        interpolation_error: flush.sound.waves.interpolation_error(),
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
                limit_lw_db: None,
            })
            .collect(),
    }
}

/// The report of a rigid tool as the sphere of its volume, whose power is known in closed form twice: by the resistance
/// of its surface and by its far field. With radiation efficiency 1 the surface would radiate
///
/// ```text
/// E_1(f) = E(f) (4 + (k a)^4) / (k a)^4
/// ```
pub(super) fn rigid_report(
    far_field: &SourceSpectrum,
    surface: &SourceSpectrum,
    volume: f64,
    air: &Air,
) -> RadiationReport {
    let range = far_field.range_hz;
    let of_bin = |(hz, energy): (&f64, &f64)| energy / sphere_efficiency(volume, air, *hz);
    let erp = SourceSpectrum {
        energy_density: surface
            .frequency
            .iter()
            .zip(&surface.energy_density)
            .map(of_bin)
            .collect(),
        ..surface.clone()
    };
    let level = |spectrum: &SourceSpectrum| energy_level(spectrum.energy(range, Weighting::A));
    let [by_field, by_surface, by_erp] = [far_field, surface, &erp].map(|spectrum| spectrum.band_levels(range));
    let rows = by_field.iter().zip(&by_surface).zip(&by_erp);
    RadiationReport {
        join_hz: [range[1]; 2],
        solved_hz: [range[1]; 2],
        frequencies: far_field.frequency.len(),
        interpolation_error: 0.0,
        surface_difference_db: level(surface)
            .zip(level(far_field))
            .map(|(surface, field)| surface - field),
        limit_error_db: [0.0; 2],
        blend_error_db: None,
        erp_lwa_db: level(&erp),
        modes: Vec::new(),
        bands: rows
            .filter(|((field, _), _)| field.band.high > range[0] && field.band.low < range[1])
            .map(|((field, surface), erp)| RadiationBand {
                hz: field.band.nominal_hz(),
                lw_db: field.lw,
                surface_lw_db: surface.lw,
                erp_lw_db: erp.lw,
                limit_lw_db: None,
            })
            .collect(),
    }
}
