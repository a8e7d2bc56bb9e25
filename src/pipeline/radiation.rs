//! Sound energy of the moving surfaces: the workpiece with its support, and the tool body.

use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::ModalBem;
use nailnoise_acoustics::fourier::TransformSettings;
use nailnoise_acoustics::levels::{SourceSpectrum, Weighting, energy_weights};
use nailnoise_acoustics::radiation::{
    AbsorbingSand, Erp, ModalSpectra, mode_energies, radiated_energy, radiated_signals, rigid_body_energy,
    rigid_body_signals,
};
use nailnoise_acoustics::sound::rigid_body_far_field;
use nailnoise_dynamics::CycleRecord;

use super::Body;
use super::bodies::Structure;
use super::radiator::{Flush, Radiator};
use super::report::{flush_report, report, rigid_report};
use super::sound::Sound;
use crate::design::Design;
use crate::design::inputs::radiation::absorbing_sand;
use crate::error::Error;
use crate::result::{ModeShare, Uncertainty};
use crate::stages::spectra::side_by_side;

/// Highest radiation efficiency of a plate, near coincidence.
const HIGHEST_EFFICIENCY: f64 = 1.76;

/// The workpiece with its support as one source.
pub(super) fn workpiece(
    design: &Design,
    structure: &Structure,
    radiator: &Radiator,
    damping: Option<&[Vec<f64>]>,
    spectra: &[ModalSpectra],
) -> Result<Sound, Error> {
    match radiator {
        Radiator::Bem(bem) => by_bem(bem, structure, damping, spectra),
        Radiator::Erp(bodies) => free_standing(bodies, spectra),
        Radiator::Rayleigh(flush) => flush_top(design, structure, flush, damping, &spectra[0]),
    }
}

/// Energy of the workpiece with its support alone, without its course in time.
pub(super) fn workpiece_energy(radiator: &Radiator, spectra: &[ModalSpectra]) -> Result<SourceSpectrum, Error> {
    match radiator {
        Radiator::Bem(bem) => Ok(radiated_energy("workpiece", bem.as_ref(), &side_by_side(spectra))?),
        Radiator::Erp(bodies) => Ok(free_standing(bodies, spectra)?.spectrum),
        Radiator::Rayleigh(flush) => Ok(radiated_energy("workpiece", &flush.sound.waves, &spectra[0])?),
    }
}

/// Block and table, or a block alone, as one radiating surface: what they move coherently interferes.
fn by_bem(
    bem: &ModalBem,
    structure: &Structure,
    damping: Option<&[Vec<f64>]>,
    spectra: &[ModalSpectra],
) -> Result<Sound, Error> {
    let bodies: Vec<&Body> = structure.bodies().collect();
    by_boundary_elements("workpiece", bem, (&bodies, damping), &side_by_side(spectra))
}

/// A source of bodies that radiate as one surface, by boundary elements up to their limit.
pub(super) fn by_boundary_elements(
    name: &'static str,
    bem: &ModalBem,
    (bodies, damping): (&[&Body], Option<&[Vec<f64>]>),
    together: &ModalSpectra,
) -> Result<Sound, Error> {
    let mut source = radiated_energy(name, bem, together)?;
    let erp = radiated_energy(name, &bem.reference(), together)?;
    let surface = share_out(&mut source);
    let weights = energy_weights(&source.frequency, source.range_hz, Weighting::A);
    let energies = mode_energies(bem, together, &weights)?;
    let mut report = report(bem, together, [&source, &surface, &erp]);
    report.modes = modes_of(bodies, damping, &energies);
    let signals = vec![(name, radiated_signals(bem, together, &source)?)];
    let above = |factor: f64| {
        let range = together.range_hz;
        let join = bem.blend_hz()[0].clamp(range[0], range[1]);
        let (low, high) = (
            source.energy([range[0], join], Weighting::A),
            source.energy([join, range[1]], Weighting::A),
        );
        10.0 * ((low + factor * high) / (low + high)).log10()
    };
    let [mut least, mut most] = report.limit_error_db;
    if let Some(error) = report.blend_error_db {
        (least, most) = (least.min(error), most.max(error));
    }
    let evaluations = report.surface_difference_db.map_or(0.0, f64::abs);
    // What the limit is above the boundary elements where they meet, it may be above the truth beyond.
    let uncertainty = Uncertainty {
        minus: Some(evaluations - above(10f64.powf(-most.max(0.0) / 10.0)).min(0.0)),
        plus: Some(evaluations + above(10f64.powf(-least.min(0.0) / 10.0)).max(0.0)),
        basis: format!(
            "power by surface and by far field, and above {:.0} Hz the limit of high frequencies, {least:+.1} to {most:+.1} dB \
             off in the last bands of boundary elements",
            bem.blend_hz()[0]
        ),
    };
    Ok(Sound {
        spectrum: source,
        signals,
        openings: Vec::new(),
        uncertainty,
        cross_check: None,
        radiation: Some(report),
    })
}

/// What each mode adds to the energy of block and table; the static corrections of a body count as one.
fn modes_of(bodies: &[&Body], damping: Option<&[Vec<f64>]>, energies: &[f64]) -> Vec<ModeShare> {
    let total: f64 = energies.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    let mut energies = energies.iter();
    let mut shares = Vec::new();
    for (index, body) in bodies.iter().enumerate() {
        let modes = body.basis.hz.len();
        let mut rest = 0.0;
        for (number, (omega, energy)) in body.omega.iter().zip(&mut energies).enumerate() {
            if number >= modes {
                rest += energy;
                continue;
            }
            shares.push(ModeShare {
                body: body.name.into(),
                mode: Some(number + 1),
                hz: Some(omega / std::f64::consts::TAU),
                radiation_damping: damping.map(|d| d[index][number]),
                share: energy / total,
            });
        }
        shares.push(ModeShare {
            body: body.name.into(),
            mode: None,
            hz: None,
            radiation_damping: None,
            share: rest / total,
        });
    }
    shares
}

/// Takes the difference between far field and surface out of the patches and shares it out among those that radiate, so
/// that they sum to the far field's power; returns the surface's.
fn share_out(source: &mut SourceSpectrum) -> SourceSpectrum {
    let mut surface = source.clone();
    surface.contributions.clear();
    let (rest, mut patches): (Vec<_>, Vec<_>) = source
        .contributions
        .drain(..)
        .partition(|part| ModalBem::is_rest(&part.name));
    for bin in 0..source.energy_density.len() {
        let rest: f64 = rest.iter().map(|part| part.energy_density[bin]).sum();
        surface.energy_density[bin] = (source.energy_density[bin] - rest).max(0.0);
        let giving: f64 = patches.iter().map(|part| part.energy_density[bin].max(0.0)).sum();
        for part in &mut patches {
            let e = &mut part.energy_density[bin];
            *e += if giving > 0.0 { rest * e.max(0.0) / giving } else { 0.0 };
        }
    }
    patches.retain(|part| part.energy_density.iter().any(|e| *e != 0.0));
    source.contributions = patches;
    surface
}

/// ERP of block and table, or of a block alone, each by itself.
fn free_standing(bodies: &[Erp], spectra: &[ModalSpectra]) -> Result<Sound, Error> {
    let (mut parts, mut signals) = (Vec::new(), Vec::new());
    for ((erp, name), spectrum) in bodies.iter().zip(["workpiece", "worktable"]).zip(spectra) {
        let part = radiated_energy(name, erp, spectrum)?;
        signals.push((name, radiated_signals(erp, spectrum, &part)?));
        parts.push(part);
    }
    let mut source = SourceSpectrum::sum("workpiece", "ERP", &parts);
    source.range_hz = spectra[0].range_hz;
    let uncertainty = Uncertainty {
        minus: None,
        plus: Some(10.0 * HIGHEST_EFFICIENCY.log10()),
        basis: "radiation efficiency taken as 1: near coincidence it is higher, at low frequencies far lower"
            .to_owned(),
    };
    Ok(Sound {
        spectrum: source,
        signals,
        openings: Vec::new(),
        uncertainty,
        cross_check: None,
        radiation: None,
    })
}

/// Rayleigh's integral over the block's top, flush with the sand.
fn flush_top(
    design: &Design,
    structure: &Structure,
    flush: &Flush,
    damping: Option<&[Vec<f64>]>,
    spectrum: &ModalSpectra,
) -> Result<Sound, Error> {
    let source = radiated_energy("workpiece", &flush.sound.waves, spectrum)?;
    let signals = vec![("workpiece", radiated_signals(&flush.sound.waves, spectrum, &source)?)];
    let ratios = flush.sound.surface.ratios(&flush.sound.waves, spectrum)?;
    let erp = radiated_energy("workpiece", &flush.erp, spectrum)?;
    let mut report = flush_report(flush, &source, &ratios, &erp);
    let weights = energy_weights(&source.frequency, source.range_hz, Weighting::A);
    let energies = mode_energies(&flush.sound.waves, spectrum, &weights)?;
    report.modes = modes_of(&[&structure.workpiece], damping, &energies);
    let uncertainty = sand_band(&source, &absorbing_sand(design), spectrum.range_hz);
    Ok(Sound {
        spectrum: source,
        signals,
        openings: Vec::new(),
        uncertainty,
        cross_check: None,
        radiation: Some(report),
    })
}

/// What the share of the sand's absorption decides: from that of an infinite plane of sand to none.
fn sand_band(source: &SourceSpectrum, sand: &AbsorbingSand, range_hz: [f64; 2]) -> Uncertainty {
    let plane: Vec<f64> = source
        .frequency
        .iter()
        .map(|&hz| sand.infinite_plane_factor(hz))
        .collect();
    let with_share = |share: f64| {
        let factor = |g: &f64| g.powf(share - sand.share);
        let density = source
            .energy_density
            .iter()
            .zip(&plane)
            .map(|(e, g)| e * factor(g))
            .collect();
        let changed = SourceSpectrum {
            energy_density: density,
            contributions: Vec::new(),
            ..source.clone()
        };
        changed.level(range_hz, Weighting::A)
    };
    let difference = |share: f64| Some((with_share(share)? - source.level(range_hz, Weighting::A)?).abs());
    Uncertainty {
        minus: difference(1.0),
        plus: difference(0.0),
        basis: "absorption by the sand, from that of an infinite plane to none".to_owned(),
    }
}

/// A rigid tool body as the sphere of its volume in the cycle's motion: its power by the resistance of the sphere's surface,
/// and once more by its far field.
pub(super) fn rigid_tool_twice(design: &Design, record: &CycleRecord, air: &Air) -> Result<Sound, Error> {
    let sound = rigid_tool(design, record, air)?;
    let (acceleration, interval, volume) = (&record.tool.acceleration, record.sample_interval, design.body.volume());
    let settings = rigid_settings(design);
    let far_field = rigid_body_far_field("body", acceleration, interval, volume, air, &settings)?;
    let report = rigid_report(&far_field, &sound.spectrum, volume, air);
    Ok(Sound {
        radiation: Some(report),
        ..sound
    })
}

/// The rigid motion of a tool body as that of the sphere of its volume.
pub(super) fn rigid_tool(design: &Design, record: &CycleRecord, air: &Air) -> Result<Sound, Error> {
    let settings = rigid_settings(design);
    let (acceleration, interval, volume) = (&record.tool.acceleration, record.sample_interval, design.body.volume());
    Ok(Sound {
        spectrum: rigid_body_energy("body", acceleration, interval, volume, air, &settings)?,
        signals: vec![(
            "body",
            rigid_body_signals(acceleration, interval, volume, air, &settings)?,
        )],
        openings: Vec::new(),
        uncertainty: Uncertainty {
            minus: Some(0.0),
            plus: None,
            basis: "rigid motion only: vibration of the housing adds to it".to_owned(),
        },
        cross_check: None,
        radiation: None,
    })
}

fn rigid_settings(design: &Design) -> TransformSettings {
    TransformSettings {
        range_hz: [design.analysis.range_low, design.analysis.range_high],
        ..TransformSettings::default()
    }
}
