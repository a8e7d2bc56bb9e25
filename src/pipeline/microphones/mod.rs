//! Virtual microphones around the device: what EN 12549 would measure of each source and of all, beside what they radiate.

mod heard;

use nailnoise_acoustics::Air;
use nailnoise_acoustics::levels::{
    BandLevel, SILENCE, SourceSpectrum, Weighting, energy_level, energy_weights, level_energy,
};
use nailnoise_acoustics::radiation::ModalSpectra;
use nailnoise_acoustics::sound::{Iso3744Box, background_correction, environmental_correction};
use nailnoise_dynamics::CycleRecord;
use nalgebra::Point3;

use super::Tool;
use super::exhaust::Exhaust;
use super::radiator::Radiator;
use super::sound::Sound;
use crate::design::{Design, SupportKind};
use crate::error::Error;
use crate::result::{ArrayMeasurement, HeardSource, MicrophoneBand, MicrophoneLevel, MicrophoneReport};
use heard::{Heard, Scene};

/// Reference exposure (20 uPa)² s \[Pa² s\] over reference energy 1 pW s and reference area 1 m²: 400 Pa s/m, which
/// stands for the impedance of air in L_W = L_p + 10 lg S.
const REFERENCE: f64 = 400.0;

/// Samples of a file of sound \[1/s\].
pub(crate) const SAMPLE_RATE: u32 = 48_000;

/// Time after the end of the shot that a file of sound goes on for \[s\]: travel, and what the range's ends ring.
const TAIL: f64 = 0.05;

/// Longest file of sound \[s\].
const LONGEST: f64 = 2.0;

/// Names of what is all sources together.
const TOTAL: &str = "total";

/// What the microphones hear of a shot.
#[derive(Debug, Clone)]
pub struct Microphones {
    /// Levels, and how they compare with the power radiated.
    pub report: MicrophoneReport,
    /// Pressure at 48 kHz from the trigger on, source by source and of all of them (`total`), microphone by microphone
    /// \[Pa\].
    pub signals: Vec<(String, Vec<Vec<f64>>)>,
}

/// What is there to be heard.
pub(super) struct Inputs<'a> {
    pub(super) radiator: &'a Radiator,
    pub(super) spectra: &'a [ModalSpectra],
    pub(super) record: &'a CycleRecord,
    pub(super) workpiece: &'a Sound,
    pub(super) body: &'a Sound,
    pub(super) tool: Option<&'a Tool>,
    /// End of all motion \[s\].
    pub(super) end: f64,
}

/// Height of the tool above what it nails \[m\].
pub(crate) fn tool_height(design: &Design) -> f64 {
    design.body.nose_height + design.body.barrel_height + design.body.cap_height
}

/// Height of the plane that reflects: the floor under a table, under a block on springs, or at the underside of one that
/// lies or is clamped on it; the sand's surface \[m\].
pub(crate) fn reflecting_plane(design: &Design) -> f64 {
    match design.support.kind {
        SupportKind::Worktable => -design.support.worktable.height,
        SupportKind::Sandbox => design.workpiece.thickness,
        SupportKind::Floor | SupportKind::Clamped => 0.0,
        SupportKind::Springs => -design.support.clearance,
    }
}

/// The measurement surface: the device's centre is half the tool's height above what it nails.
fn surface(design: &Design) -> Iso3744Box {
    let centre = design.workpiece.thickness + 0.5 * tool_height(design);
    Iso3744Box::around(centre - reflecting_plane(design))
}

/// The microphones' places \[m\], in the coordinates of the bodies.
pub(crate) fn positions(design: &Design) -> Vec<Point3<f64>> {
    let nail = &design.nail;
    let foot = Point3::new(nail.offset_along, nail.offset_across, reflecting_plane(design));
    surface(design).places(foot)
}

/// A source as the microphones hear it: levels, and the pressure at each microphone.
pub(super) type AtMicrophones = (HeardSource, Vec<Vec<f64>>);

impl<'a> Scene<'a> {
    /// The microphones of a design, for a shot that moves until `end` \[s\].
    fn of(design: &'a Design, air: &'a Air, end: f64) -> Self {
        Self {
            design,
            air,
            places: positions(design),
            plane: reflecting_plane(design),
            samples: ((end + TAIL).min(LONGEST) * f64::from(SAMPLE_RATE)).ceil() as usize,
        }
    }
}

/// What is heard of a source, in the range in which all are compared.
fn of_source(design: &Design, heard: Heard<'_>) -> Result<AtMicrophones, Error> {
    let common = [design.analysis.range_low, design.analysis.range_high];
    let within = [heard.range[0].max(common[0]), heard.range[1].min(common[1])];
    let levels = heard_source(&heard, surface(design).area(), within)?;
    Ok((levels, heard.signals))
}

/// What is heard of the moving bodies: workpiece with support, and tool.
///
/// # Errors
/// Those of the radiation.
pub(super) fn of_bodies(design: &Design, air: &Air, inputs: &Inputs<'_>) -> Result<[AtMicrophones; 2], Error> {
    let scene = Scene::of(design, air, inputs.end);
    Ok([
        of_source(design, scene.workpiece(inputs)?)?,
        of_source(design, scene.body(inputs)?)?,
    ])
}

/// What is heard of the exhaust; `end` as in [`Inputs`].
///
/// # Errors
/// Those of the acoustics.
pub(super) fn of_exhaust(
    design: &Design,
    air: &Air,
    (exhaust, radiated): (&Exhaust, &SourceSpectrum),
    end: f64,
) -> Result<AtMicrophones, Error> {
    of_source(design, Scene::of(design, air, end).exhaust(exhaust, radiated)?)
}

/// Levels and signals at the microphones, of every source as given and of all together; `end` as in [`Inputs`].
///
/// # Errors
/// Those of the standard's corrections.
pub(super) fn microphones(
    design: &Design,
    air: &Air,
    all: [&AtMicrophones; 3],
    end: f64,
) -> Result<Microphones, Error> {
    let scene = Scene::of(design, air, end);
    let surface = surface(design);
    let mut total = vec![vec![0.0; scene.samples]; scene.places.len()];
    for (_, signals) in all {
        for (sum, signal) in total.iter_mut().zip(signals) {
            sum.iter_mut().zip(signal).for_each(|(sum, p)| *sum += p);
        }
    }
    let sources: Vec<HeardSource> = all.iter().map(|(source, _)| source.clone()).collect();
    let measured = measurement(design, air, &surface, &sources, &total)?;
    let own = all
        .iter()
        .map(|(source, signals)| (source.source.clone(), signals.clone()));
    let signals: Vec<(String, Vec<Vec<f64>>)> = own.chain([(TOTAL.to_owned(), total)]).collect();
    let peaks = signals
        .iter()
        .flat_map(|(_, signals)| signals)
        .map(|signal| peak(signal));
    let report = MicrophoneReport {
        box_m: surface.sides,
        area_m2: surface.area(),
        positions_m: surface.positions().map(Into::into).to_vec(),
        full_scale_pa: full_scale(peaks.fold(0.0, f64::max)),
        sources,
        total: measured,
    };
    Ok(Microphones { report, signals })
}

/// A source's levels at the microphones, and by the standard's surface without room and background.
fn heard_source(heard: &Heard<'_>, area: f64, range: [f64; 2]) -> Result<HeardSource, Error> {
    let exposure = |row: usize, weighting: Weighting| -> f64 {
        let of_part = |part: &heard::Part| -> f64 {
            let weights = energy_weights(&part.frequency, range, weighting);
            weights
                .iter()
                .zip(part.exposure.row(row).iter())
                .map(|(w, e)| w * e)
                .sum()
        };
        heard.parts.iter().map(of_part).sum()
    };
    let levels = heard.signals.iter().enumerate().map(|(row, signal)| MicrophoneLevel {
        lae_db: exposure_level(exposure(row, Weighting::A)),
        le_db: exposure_level(exposure(row, Weighting::Z)),
        peak_pa: peak(signal),
    });
    // The mean exposure over the surface, as the power that an impedance of 400 Pa s/m makes of it.
    let as_power = |part: &heard::Part| {
        let mean = part.exposure.row_mean().iter().map(|e| e * area / REFERENCE).collect();
        SourceSpectrum::new("microphones", "ISO 3744", part.frequency.clone(), mean, range)
    };
    let parts = heard.parts.iter().map(as_power).collect::<Result<Vec<_>, _>>()?;
    let measured = SourceSpectrum::sum("microphones", "ISO 3744", &parts);
    let whole = |b: &BandLevel| b.band.low >= range[0] * (1.0 - 1e-9) && b.band.high <= range[1] * (1.0 + 1e-9);
    let bands = measured.band_levels(range);
    let of_band = |(measured, radiated): (&BandLevel, &BandLevel)| MicrophoneBand {
        hz: measured.band.nominal_hz(),
        lw_db: measured.lw,
        true_lw_db: radiated.lw,
    };
    Ok(HeardSource {
        source: heard.radiated.source.clone(),
        how: heard.how.to_owned(),
        range_hz: range,
        interpolation_error: heard.interpolation_error,
        levels: levels.collect(),
        lwa_db: energy_level(measured.energy(range, Weighting::A)),
        true_lwa_db: energy_level(heard.radiated.energy(range, Weighting::A)),
        bands: bands
            .iter()
            .zip(&heard.radiated.band_levels(range))
            .filter(|(b, _)| whole(b))
            .map(of_band)
            .collect(),
    })
}

/// All sources at once by the standard's procedure, in the design's room with its background.
fn measurement(
    design: &Design,
    air: &Air,
    surface: &Iso3744Box,
    sources: &[HeardSource],
    signals: &[Vec<f64>],
) -> Result<ArrayMeasurement, Error> {
    let sum =
        |level: &dyn Fn(&HeardSource) -> Option<f64>| -> f64 { sources.iter().map(|s| level_energy(level(s))).sum() };
    let levels = (0..signals.len()).map(|row| MicrophoneLevel {
        lae_db: energy_level(sum(&|s| s.levels[row].lae_db)),
        le_db: energy_level(sum(&|s| s.levels[row].le_db)),
        peak_pa: peak(&signals[row]),
    });
    let (area, acoustics) = (surface.area(), &design.acoustics);
    let radiated = sum(&|s| s.true_lwa_db);
    // Energies as they stand for mean exposures: E = 400 Pa s/m x S x mean.
    let direct = sum(&|s| s.lwa_db);
    let (reverberant, k2) = if acoustics.room_absorption > 0.0 {
        let absorption = acoustics.room_absorption;
        (
            4.0 * air.impedance() / absorption * radiated * area / REFERENCE,
            environmental_correction(area, absorption)?,
        )
    } else {
        (0.0, 0.0)
    };
    // A steady level is its own exposure level over 1 s.
    let background = if acoustics.background_level > 0.0 {
        level_energy(Some(acoustics.background_level)) * area
    } else {
        0.0
    };
    let of_tool = direct + reverberant;
    let k1 = if background > 0.0 && of_tool > SILENCE {
        background_correction(10.0 * ((of_tool + background) / background).log10())
    } else {
        Some(0.0)
    };
    let measured = energy_level(of_tool + background);
    Ok(ArrayMeasurement {
        levels: levels.collect(),
        lpa_db: measured.map(|level| level - 10.0 * area.log10()),
        k1_db: k1,
        k2_db: k2,
        lwa_db: measured.zip(k1).map(|(level, k1)| level - k1 - k2),
        true_lwa_db: energy_level(radiated),
    })
}

/// Level of a sound exposure \[dB re (20 uPa)² s\].
fn exposure_level(exposure: f64) -> Option<f64> {
    energy_level(exposure / REFERENCE)
}

fn peak(signal: &[f64]) -> f64 {
    signal.iter().fold(0.0, |peak: f64, p| peak.max(p.abs()))
}

/// The smallest of 1, 2, 5, 10 ... Pa above a peak, from 1 mPa on.
fn full_scale(peak: f64) -> f64 {
    let steps = (-3..6).flat_map(|decade| [1.0, 2.0, 5.0].map(|step| step * 10f64.powi(decade)));
    steps.into_iter().find(|scale| *scale > peak).unwrap_or(peak.max(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn full_scale_is_a_round_pressure_above_the_peak() {
        for (peak, scale) in [(0.0, 1e-3), (0.7, 1.0), (1.0, 2.0), (3.3, 5.0), (12.0, 20.0)] {
            assert!((full_scale(peak) / scale - 1.0).abs() < 1e-12, "{peak}");
        }
    }
}
