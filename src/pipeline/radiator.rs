//! Radiation of the workpiece with its support per unit of modal motion, before the motion is known.

use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::{
    Boundary, BoundaryMesh, Exterior, Level, ModalBem, MovingPart, Receivers, Side, SolidBox,
};
use nailnoise_acoustics::radiation::{
    AbsorbingSand, Archive, Erp, ModalRadiation, Rayleigh, SampledRadiation, Sampling, SurfaceEvaluations,
};
use nailnoise_acoustics::sound::SoundAbovePlane;
use nalgebra::Point3;

use super::Watched;
use super::bodies::{Body, Structure};
use super::microphones;
use super::radiation::{moving_sand, radiating};
use crate::cache::{Cache, Key};
use crate::design::{Design, RadiationMethod, SupportKind, WorktablePreset};
use crate::error::Error;

/// Lowest frequency at which a radiation resistance is sampled \[Hz\]; below it each entry follows its own power law.
pub(super) const LOWEST_SAMPLE: f64 = 40.0;

/// Tops of the ranges that have a mesh of their own, over the top of all.
const RANGES: [f64; 4] = [0.16, 0.4, 0.65, 1.0];

/// Longest side of a panel over the largest extent of the body: at low frequencies the shape asks for as much as the wave.
const COARSEST: f64 = 1.0 / 16.0;

/// A mode that radiates less than this share of the best radiator is interpolated as well as that share asks for.
pub(super) const FLOOR: f64 = 1e-2;

/// Most frequencies of one range.
pub(super) const MOST_SAMPLES: usize = 100;

/// Frequencies at which a range is sampled on the mesh below it, see [`expected_seconds`], as counted on the worktables.
const SAMPLES_PER_WAVELENGTH: f64 = 7.0;
const SAMPLES_BESIDE: f64 = 10.0;

/// Frequencies at which its own mesh corrects them.
const CORRECTIONS: f64 = 9.0;

/// Patches of the block on its table, and how many of them belong to the block.
const PATCHES: [&str; 6] = [
    "workpiece top",
    "workpiece sides",
    "worktable top",
    "worktable underside",
    "worktable edges",
    "worktable legs",
];
const OF_WORKPIECE: usize = 2;

/// Name of the stage in the cache.
const STAGE: &str = "radiation of workpiece and worktable";

/// How the workpiece with its support radiates.
pub(super) enum Radiator {
    /// Boundary elements on block and table as one surface above the floor.
    Bem(Box<ModalBem>),
    /// Equivalent radiated power, body by body.
    Erp(Vec<Erp>),
    /// Rayleigh's integral over the block's top, flush with the sand.
    Rayleigh(Box<Flush>),
}

/// The block's top, flush with the sand.
pub(super) struct Flush {
    /// Its radiation by plane waves.
    pub(super) waves: SampledRadiation,
    /// Its radiation by the intensity on the surface, in the middle of bands.
    pub(super) surface: SurfaceEvaluations,
    /// What the microphones hear of it.
    pub(super) heard: SoundAbovePlane,
    /// Its equivalent radiated power.
    pub(super) erp: Erp,
}

impl Radiator {
    /// The operator that the design asks for, from the cache where it is known.
    ///
    /// # Errors
    /// Those of mesh and radiation.
    pub(super) fn new(
        design: &Design,
        structure: &Structure,
        air: &Air,
        cache: &Cache,
        watched: &Watched<'_>,
    ) -> Result<Self, Error> {
        match (design.support.kind, design.acoustics.method) {
            (SupportKind::Sandbox, _) => {
                let flush = flush_top(design, &structure.workpiece, air, cache, watched)?;
                Ok(Self::Rayleigh(Box::new(flush)))
            }
            (SupportKind::Floor | SupportKind::Clamped | SupportKind::Springs, _)
            | (SupportKind::Worktable, RadiationMethod::Erp) => standing_erp(design, structure, air),
            (SupportKind::Worktable, RadiationMethod::Bem) => standing_bem(design, structure, air, cache, watched),
        }
    }

    /// Damping ratio that radiation adds to each mode of each body, R_jj(omega_j) / (2 omega_j) for modal masses of 1;
    /// zero for rigid modes, and with the equivalent radiated power, which is far too much at low frequencies.
    pub(super) fn damping(&self, structure: &Structure) -> Vec<Vec<f64>> {
        match self {
            Self::Bem(bem) => {
                let all: Vec<f64> = structure.bodies().flat_map(|body| body.omega.iter().copied()).collect();
                let mut rest = damping_of(bem.as_ref(), &all);
                structure
                    .bodies()
                    .map(|body| {
                        let tail = rest.split_off(body.omega.len());
                        std::mem::replace(&mut rest, tail)
                    })
                    .collect()
            }
            Self::Erp(_) => structure.bodies().map(|body| vec![0.0; body.omega.len()]).collect(),
            Self::Rayleigh(flush) => vec![damping_of(&flush.waves, &structure.workpiece.omega)],
        }
    }
}

/// Damping ratio that radiation adds to modes of these angular frequencies, see [`Radiator::damping`].
pub(super) fn damping_of(radiation: &dyn ModalRadiation, omega: &[f64]) -> Vec<f64> {
    let lowest = 2.0 * std::f64::consts::PI;
    let motion = |(j, w): (usize, &f64)| {
        let hz = (w.max(lowest) / std::f64::consts::TAU).min(radiation.highest_hz());
        (hz, vec![(j, 1.0)])
    };
    let motions: Vec<(f64, Vec<(usize, f64)>)> = omega.iter().enumerate().map(motion).collect();
    let ratio = |(r, w): (f64, &f64)| if *w > lowest { (r / (2.0 * w)).max(0.0) } else { 0.0 };
    let resistances = radiation.sparse_forms(&motions);
    resistances.into_iter().zip(omega).map(ratio).collect()
}

/// The block's top, flush with the sand.
pub(super) fn flush_surface(design: &Design, body: &Body, air: &Air) -> Result<Rayleigh, Error> {
    let sand = &design.support.sand;
    let surface = radiating(body, |patch, _| patch != "top")?;
    let mut rayleigh = Rayleigh::new(&surface, air)?;
    if sand.absorption_share > 0.0 {
        rayleigh = rayleigh.with_absorbing_sand(absorbing_sand(design))?;
    }
    if sand.moving_surface {
        rayleigh = rayleigh.with_moving_sand(moving_sand(design)?)?;
    }
    Ok(rayleigh)
}

/// Rayleigh's integral over it.
fn flush_top(design: &Design, body: &Body, air: &Air, cache: &Cache, watched: &Watched<'_>) -> Result<Flush, Error> {
    let sand = &design.support.sand;
    let surface = radiating(body, |patch, _| patch != "top")?;
    let absorbing = (sand.absorption_share > 0.0).then(|| absorbing_sand(design));
    let moving = sand.moving_surface.then(|| moving_sand(design)).transpose()?;
    let top = body.top_hz.min(design.analysis.range_high);
    let sampling = Sampling {
        range_hz: [LOWEST_SAMPLE.min(0.5 * top), top],
        ..Sampling::default()
    };
    let places = microphones::positions(design);
    let points: Vec<[f64; 3]> = surface.points().iter().map(|p| [p.x, p.y, p.z]).collect();
    let normals: Vec<[f64; 3]> = surface.normals().iter().map(|n| [n.x, n.y, n.z]).collect();
    let key = Key::new()
        .with(&format!("{air:?} {absorbing:?} {moving:?} {sampling:?} {places:?}"))
        .with(&points)
        .with(&normals)
        .with(surface.weights())
        .with(surface.patch())
        .with(surface.patch_names())
        .with(surface.normal_modes().as_slice());
    let read = |bytes: &[u8]| Ok::<_, Error>(Archive::from_bytes(bytes)?);
    let ((waves, surface_evaluations), heard) =
        cache.decoded_or("radiation of the workpiece in sand", &key, read, || {
            let rayleigh = flush_surface(design, body, air)?;
            let twice = SurfaceEvaluations::new(&rayleigh, top);
            let sampled = watched.counting_each(("Rayleigh's integral", "frequencies"), 0, |one_more| {
                rayleigh.sampled_telling(&sampling, one_more)
            })?;
            let middle = Point3::new(0.0, 0.0, design.workpiece.thickness);
            let heard = SoundAbovePlane::new(&rayleigh, &sampled, &places, middle)?;
            Ok(((sampled.with_roots(), twice), heard).to_bytes())
        })?;
    Ok(Flush {
        waves,
        surface: surface_evaluations,
        heard,
        erp: Erp::new(&surface, air),
    })
}

/// The sand's surface as an absorber.
pub(super) fn absorbing_sand(design: &Design) -> AbsorbingSand {
    AbsorbingSand {
        resistivity: design.support.sand.flow_resistivity,
        share: design.support.sand.absorption_share,
    }
}

/// ERP of block and table. Where they face each other, under the table's feet and at welds, no sound gets out.
fn standing_erp(design: &Design, structure: &Structure, air: &Air) -> Result<Radiator, Error> {
    let half = [0.5 * design.workpiece.length, 0.5 * design.workpiece.width];
    let of_body = |body: &Body| {
        let hidden = |patch: &str, p: &Point3<f64>| match patch {
            "bottom" => body.name != "workpiece" || design.support.kind != SupportKind::Springs,
            "floor" => true,
            _ if patch.ends_with("_slave") => true, // tied to another face
            "top" => body.name == "worktable" && p.x.abs() < half[0] && p.y.abs() < half[1],
            _ => false,
        };
        Ok::<_, Error>(Erp::new(&radiating(body, hidden)?, air))
    };
    Ok(Radiator::Erp(
        structure.bodies().map(of_body).collect::<Result<_, _>>()?,
    ))
}

fn standing_bem(
    design: &Design,
    structure: &Structure,
    air: &Air,
    cache: &Cache,
    watched: &Watched<'_>,
) -> Result<Radiator, Error> {
    // Once for every air: the matrix depends on the wavelength.
    let computed = Air::default();
    let read = |bytes: &[u8]| Ok::<_, Error>(ModalBem::from_bytes(bytes)?);
    let bem = cache.decoded_or(STAGE, &key(design, structure, &computed), read, || {
        let levels = levels(design, structure, &computed)?;
        let low = LOWEST_SAMPLE.min(0.5 * RANGES[0] * design.acoustics.bem_top);
        if let Some(finest) = levels.last() {
            let seconds = expected_seconds(&levels, low, structure);
            let estimate = finest.problem.estimate();
            watched.note(&format!(
                "boundary elements, computed once for this structure, about {seconds:.0} s of processor time in all; \
                 finest mesh: {estimate}"
            ));
        }
        let sampling = Sampling {
            range_hz: [low, design.acoustics.bem_top],
            tolerance: design.acoustics.bem_tolerance,
            floor: FLOOR,
            most_samples: MOST_SAMPLES,
        };
        let receivers = Receivers {
            points: microphones::positions(design),
            origin: Point3::origin(),
        };
        let expected: f64 = expected(&levels, low).iter().sum::<f64>() + ModalBem::IN_MEAN as f64;
        let bem = watched.counting_each(("boundary elements", "frequencies"), expected as u64, |one_more| {
            ModalBem::with_receivers_telling(levels, &sampling, &receivers, one_more)
        })?;
        Ok::<_, Error>(bem.to_bytes())
    })?;
    Ok(Radiator::Bem(Box::new(bem.in_air(&computed, air))))
}

/// Frequencies of each range: they follow how many more wavelengths twice the body's largest extent holds at its top than
/// at its bottom.
fn expected(levels: &[Level], low: f64) -> Vec<f64> {
    let mut from = low;
    let of_range = |level: &Level| {
        let problem = &level.problem;
        let wavelengths = 2.0 * problem.boundary().extents().max() * (level.top_hz - from) / problem.air().sound_speed;
        from = level.top_hz;
        SAMPLES_PER_WAVELENGTH * wavelengths + SAMPLES_BESIDE
    };
    levels.iter().map(of_range).collect()
}

/// Processor time of all ranges \[s\], about.
fn expected_seconds(levels: &[Level], low: f64, structure: &Structure) -> f64 {
    let modes: usize = structure.bodies().map(|body| body.shapes.ncols()).sum();
    let of_frequency = |level: &Level| {
        // Most modes of a symmetric body have one parity.
        let patterns = modes.div_ceil(level.problem.boundary().copies());
        level.problem.estimate().seconds_with(patterns)
    };
    let of_range = |(number, (level, sampled)): (usize, (&Level, f64))| {
        let kept = level.problem.estimate().seconds_kept;
        match number.checked_sub(1) {
            None => kept + sampled * of_frequency(level),
            Some(below) => kept + sampled * of_frequency(&levels[below]) + CORRECTIONS * of_frequency(level),
        }
    };
    let above = levels
        .last()
        .map_or(0.0, |level| ModalBem::IN_MEAN as f64 * of_frequency(level));
    above
        + levels
            .iter()
            .zip(expected(levels, low))
            .enumerate()
            .map(of_range)
            .sum::<f64>()
}

/// All that the radiation matrices depend on: boxes, air, how finely they are computed, and the skins' modes.
fn key(design: &Design, structure: &Structure, air: &Air) -> Key {
    let a = &design.acoustics;
    let mut key = Key::new()
        .with("coarser meshes, corrected; means above")
        .with(&format!("{:?} {air:?}", boxes(design)))
        .with(&[a.bem_top, a.bem_panels, a.bem_tolerance])
        .with(&format!("{:?}", microphones::positions(design)));
    for body in structure.bodies() {
        key = with_skin(key.with(body.name), body);
    }
    key
}

/// A key with the points of a body's skin and the motion of every mode there.
pub(super) fn with_skin(key: Key, body: &Body) -> Key {
    let surface = &body.surface;
    let points: Vec<f64> = surface.points.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
    body.shapes.column_iter().fold(key.with(&points), |key, mode| {
        let on_skin = surface
            .volume_nodes
            .iter()
            .flat_map(|&n| [mode[3 * n], mode[3 * n + 1], mode[3 * n + 2]]);
        key.with(&on_skin.collect::<Vec<f64>>())
    })
}

/// Height of the floor under the worktable; the block's underside is at 0 \[m\].
pub(super) fn floor(design: &Design) -> f64 {
    -design.support.worktable.height
}

fn largest_extent(design: &Design) -> f64 {
    let (block, table) = (&design.workpiece, &design.support.worktable);
    let height = table.height + block.thickness;
    [block.length, block.width, table.length, table.width]
        .into_iter()
        .fold(height, f64::max)
}

/// Block, table top and legs (tubes are closed by top and floor). Their grid is that of the bodies: the origin is the centre of the block's underside.
fn boxes(design: &Design) -> Vec<SolidBox> {
    let (block, table) = (&design.workpiece, &design.support.worktable);
    let (thickness, leg) = match table.preset {
        WorktablePreset::A => (table.top_thickness, table.leg_width),
        WorktablePreset::B => (table.steel.top_thickness_b, table.steel.tube_width),
        WorktablePreset::C => (table.steel.top_thickness_c, table.steel.tube_width),
    };
    let centred = |[x, y]: [f64; 2], [low, high]: [f64; 2], part| SolidBox {
        low: [-0.5 * x, -0.5 * y, low],
        high: [0.5 * x, 0.5 * y, high],
        part,
    };
    let mut boxes = vec![
        centred([block.length, block.width], [0.0, block.thickness], 0),
        centred([table.length, table.width], [-thickness, 0.0], 1),
    ];
    let (x, y) = (0.5 * table.length, 0.5 * table.width);
    for from in [[-x, -y], [x - leg, -y], [-x, y - leg], [x - leg, y - leg]] {
        boxes.push(SolidBox {
            low: [from[0], from[1], floor(design)],
            high: [from[0] + leg, from[1] + leg, -thickness],
            part: 2,
        });
    }
    boxes
}

/// The surface of block and table on meshes that get finer with frequency, with the velocities of all modes. In any air the
/// meshes and the wavelengths up to which they serve are those of the matrix that is kept, see [`standing_bem`].
pub(super) fn levels(design: &Design, structure: &Structure, air: &Air) -> Result<Vec<Level>, Error> {
    let a = &design.acoustics;
    let computed = Air::default();
    let bodies: Vec<&Body> = structure.bodies().collect();
    let patches = [0..OF_WORKPIECE, OF_WORKPIECE..PATCHES.len()];
    let parts: Vec<MovingPart<'_>> = bodies
        .iter()
        .zip(patches)
        .map(|(body, patches)| MovingPart {
            skin: &body.surface,
            modes: &body.shapes,
            patches,
        })
        .collect();
    let patch = |side: Side| match (side.part, side.axis, side.upper) {
        (0, 2, true) => 0,
        (0, _, _) => 1,
        (1, 2, true) => 2,
        (1, 2, false) => 3,
        (1, _, _) => 4,
        _ => 5,
    };
    let level = |share: &f64| {
        let top_hz = share * a.bem_top;
        let edge = (computed.sound_speed / (a.bem_panels * top_hz)).min(COARSEST * largest_extent(design));
        let (mirrors, floor) = ([Some(0.0); 2], floor(design));
        let names = PATCHES.map(str::to_owned).to_vec();
        let planes = [mirrors[0], mirrors[1], Some(floor)];
        let mesh = BoundaryMesh::of_boxes(&boxes(design), planes, edge, names, patch)?;
        let boundary = Boundary::symmetric(mesh, mirrors, Some(floor))?;
        let patterns = boundary.transfer(&parts)?;
        let problem = Exterior::new(boundary, air).with_panels_per_wavelength(a.bem_panels)?;
        Ok(Level {
            problem,
            top_hz: top_hz * (air.sound_speed / computed.sound_speed),
            patterns,
        })
    };
    RANGES.iter().map(level).collect()
}
