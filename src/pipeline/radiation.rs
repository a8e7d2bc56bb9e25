//! Sound energy of the moving surfaces: the workpiece with its support, and the tool body.

use nailnoise_acoustics::Air;
use nailnoise_acoustics::fourier::TransformSettings;
use nailnoise_acoustics::levels::{SourceSpectrum, Weighting};
use nailnoise_acoustics::radiation::{
    AbsorbingSand, Erp, ModalSpectra, MovingSand, RadiatingSurface, Rayleigh, Sampling, radiated_energy,
    radiated_signals, rigid_body_energy, rigid_body_signals,
};
use nailnoise_dynamics::CycleRecord;
use nailnoise_fem::supports::Sand;
use nailnoise_fem::transient::{ModalResponse, Motion};
use nailnoise_meshes::QuadraturePoint;
use nalgebra::{DMatrix, Point3, Vector3};

use super::bodies::{Body, Structure};
use super::sound::Sound;
use crate::design::{Design, SupportKind};
use crate::error::Error;
use crate::result::Uncertainty;

/// Gauss points along each side of a face; the modes are quadratic on it, so their squares are integrated exactly on
/// rectangular faces.
const FACE_POINTS: usize = 3;

/// Highest radiation efficiency of a plate, near coincidence.
const HIGHEST_EFFICIENCY: f64 = 1.76;

/// Lowest frequency at which a radiation resistance is sampled \[Hz\]; below it each entry follows its own power law.
const LOWEST_SAMPLE: f64 = 40.0;

/// Fourier transforms of every body's modal accelerations.
pub(super) fn modal_spectra(
    design: &Design,
    structure: &Structure,
    response: &ModalResponse,
) -> Result<Vec<ModalSpectra>, Error> {
    structure
        .bodies()
        .enumerate()
        .map(|(index, body)| body_spectra(design, index, body, response))
        .collect()
}

fn body_spectra(design: &Design, index: usize, body: &Body, response: &ModalResponse) -> Result<ModalSpectra, Error> {
    let settings = TransformSettings {
        range_hz: [design.analysis.range_low, body.top_hz.min(design.analysis.range_high)],
        ..TransformSettings::default()
    };
    // The index is a mode of this body, so the response has it; an empty record is refused by the transform.
    let record = |mode: usize| {
        let motion = response.modal(index, mode..mode + 1, Motion::Acceleration);
        motion.map_or_else(|_| Vec::new(), |motion| motion.as_slice().to_vec())
    };
    let modes = body.omega.len();
    Ok(ModalSpectra::from_accelerations(
        modes,
        response.samples(),
        response.step,
        &settings,
        record,
    )?)
}

/// The workpiece with its support as one source.
pub(super) fn workpiece(
    design: &Design,
    structure: &Structure,
    spectra: &[ModalSpectra],
    air: &Air,
) -> Result<Sound, Error> {
    match design.support.kind {
        SupportKind::Sandbox => flush_top(design, &structure.workpiece, &spectra[0], air),
        SupportKind::Worktable | SupportKind::Floor | SupportKind::Clamped => {
            free_standing(design, structure, spectra, air)
        }
    }
}

/// Energy of the workpiece with its support alone, without its course in time: by ERP, in sand by Rayleigh's integral.
pub(super) fn workpiece_energy(
    design: &Design,
    structure: &Structure,
    spectra: &[ModalSpectra],
    air: &Air,
) -> Result<SourceSpectrum, Error> {
    if design.support.kind == SupportKind::Sandbox {
        return Ok(flush_top(design, &structure.workpiece, &spectra[0], air)?.spectrum);
    }
    let mut parts = Vec::new();
    for (body, spectrum) in structure.bodies().zip(spectra) {
        let surface = radiating(body, |patch, p| is_hidden(design, body, patch, p))?;
        parts.push(radiated_energy(body.name, &Erp::new(&surface, air), spectrum)?);
    }
    let mut source = SourceSpectrum::sum("workpiece", "ERP", &parts);
    source.range_hz = spectra[0].range_hz;
    Ok(source)
}

/// Whether a face of a free-standing body lies on another one.
fn is_hidden(design: &Design, body: &Body, patch: &str, p: &Point3<f64>) -> bool {
    let half = [0.5 * design.workpiece.length, 0.5 * design.workpiece.width];
    match patch {
        "bottom" | "floor" => true,
        _ if patch.ends_with("_slave") => true, // tied to another face
        "top" => body.name == "worktable" && p.x.abs() < half[0] && p.y.abs() < half[1],
        _ => false,
    }
}

/// ERP of block and table. Where they face each other, under the table's feet and at welds, no sound gets out.
fn free_standing(design: &Design, structure: &Structure, spectra: &[ModalSpectra], air: &Air) -> Result<Sound, Error> {
    let (mut parts, mut signals) = (Vec::new(), Vec::new());
    for (body, spectrum) in structure.bodies().zip(spectra) {
        let surface = radiating(body, |patch, p| is_hidden(design, body, patch, p))?;
        let erp = Erp::new(&surface, air);
        let part = radiated_energy(body.name, &erp, spectrum)?;
        signals.push((body.name, radiated_signals(&erp, spectrum, &part)?));
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
    })
}

/// Rayleigh's integral over the block's top, flush with the sand.
fn flush_top(design: &Design, body: &Body, spectrum: &ModalSpectra, air: &Air) -> Result<Sound, Error> {
    let sand = &design.support.sand;
    let surface = radiating(body, |patch, _| patch != "top")?;
    let mut rayleigh = Rayleigh::new(&surface, air)?;
    let absorbing = AbsorbingSand {
        resistivity: sand.flow_resistivity,
        share: sand.absorption_share,
    };
    if sand.absorption_share > 0.0 {
        rayleigh = rayleigh.with_absorbing_sand(absorbing)?;
    }
    if sand.moving_surface {
        rayleigh = rayleigh.with_moving_sand(moving_sand(design)?)?;
    }
    let top = spectrum.range_hz[1];
    let sampled = rayleigh.sampled(&Sampling {
        range_hz: [LOWEST_SAMPLE.min(0.5 * top), top],
        ..Sampling::default()
    })?;
    let source = radiated_energy("workpiece", &sampled, spectrum)?;
    let signals = vec![("workpiece", radiated_signals(&sampled, spectrum, &source)?)];
    let uncertainty = sand_band(&source, &absorbing, spectrum.range_hz);
    Ok(Sound {
        spectrum: source,
        signals,
        openings: Vec::new(),
        uncertainty,
        cross_check: None,
    })
}

/// The sand's surface as it moves with the block.
pub(super) fn moving_sand(design: &Design) -> Result<MovingSand, Error> {
    let (block, sand) = (&design.workpiece, &design.support.sand);
    let around = |length: f64| [-0.5 * length, 0.5 * length];
    let ground = Sand::new(sand.shear_modulus, sand.density, sand.poisson_ratio)?;
    Ok(MovingSand {
        footprint: [around(block.length), around(block.width)],
        sand: [around(sand.box_length), around(sand.box_width)],
        shear_speed: ground.shear_speed(),
        loss_factor: sand.loss_factor,
        to_hz: sand.moving_surface_top,
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

/// The surface of a body with the normal displacements of its modes, less what is hidden.
fn radiating(body: &Body, hidden: impl Fn(&str, &Point3<f64>) -> bool) -> Result<RadiatingSurface, Error> {
    let surface = &body.surface;
    let points: Vec<QuadraturePoint> = surface
        .quadrature(FACE_POINTS)?
        .into_iter()
        .filter(|point| !hidden(&surface.patches[surface.faces[point.face].patch], &point.position))
        .collect();
    let mut modes = DMatrix::zeros(points.len(), body.shapes.ncols());
    for (shape, mut column) in body.shapes.column_iter().zip(modes.column_iter_mut()) {
        for (point, value) in points.iter().zip(column.iter_mut()) {
            let nodes = &surface.faces[point.face].nodes;
            *value = nodes
                .iter()
                .zip(&point.shape)
                .map(|(&node, weight)| {
                    let dof = 3 * surface.volume_nodes[node];
                    weight * Vector3::new(shape[dof], shape[dof + 1], shape[dof + 2]).dot(&point.normal)
                })
                .sum();
        }
    }
    let mut patches: Vec<usize> = points.iter().map(|p| surface.faces[p.face].patch).collect();
    let mut shown = patches.clone();
    shown.sort_unstable();
    shown.dedup(); // a patch that is wholly hidden has no level to show
    for patch in &mut patches {
        *patch = shown.partition_point(|p| p < patch);
    }
    Ok(RadiatingSurface::new(
        points.iter().map(|p| p.position).collect(),
        points.iter().map(|p| p.normal).collect(),
        points.iter().map(|p| p.weight).collect(),
        patches,
        shown.iter().map(|&patch| surface.patches[patch].clone()).collect(),
        modes,
    )?)
}

/// The tool body as the sphere of its volume in the cycle's rigid motion.
pub(super) fn tool_body(design: &Design, record: &CycleRecord, air: &Air) -> Result<Sound, Error> {
    let settings = TransformSettings {
        range_hz: [design.analysis.range_low, design.analysis.range_high],
        ..TransformSettings::default()
    };
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
    })
}
