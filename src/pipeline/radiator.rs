//! Radiation of the workpiece with its support per unit of modal motion, before the motion is known.

use std::io::Read;

use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::ModalBem;
use nailnoise_acoustics::radiation::{AbsorbingSand, Archive, Erp, ModalRadiation, Rayleigh, Sampling};
use nailnoise_acoustics::sound::FlushSound;
use nalgebra::Point3;

use super::bodies::{Body, Structure};
use super::microphones;
use super::radiation::{moving_sand, radiating};
use super::standing::standing;
use crate::design::{Design, RadiationMethod, SupportKind};
use crate::error::Error;
use crate::stages::Progress;
use crate::store::{Key, Store};

/// Lowest frequency at which a radiation resistance is sampled \[Hz\]; below it each entry follows its own power law.
pub(super) const LOWEST_SAMPLE: f64 = 40.0;

/// A mode that radiates less than this share of the best radiator is interpolated as well as that share asks for.
pub(super) const FLOOR: f64 = 1e-2;

/// Most frequencies of one range.
pub(super) const MOST_SAMPLES: usize = 100;

/// How the workpiece with its support radiates.
pub(super) enum Radiator {
    /// Boundary elements on block and table as one surface above the floor, or on a block alone.
    Bem(Box<ModalBem>),
    /// Equivalent radiated power, body by body.
    Erp(Vec<Erp>),
    /// Rayleigh's integral over the block's top, flush with the sand.
    Rayleigh(Box<Flush>),
}

/// The block's top, flush with the sand.
pub(super) struct Flush {
    /// Its radiation by spherical waves and by the intensity on the surface, and what the microphones hear of it.
    pub(super) sound: FlushSound,
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
        cache: &Store,
        progress: &Progress,
    ) -> Result<Self, Error> {
        match (design.support.kind, design.acoustics.method) {
            (SupportKind::Sandbox, _) => {
                let flush = flush_top(design, &structure.workpiece, air, cache, progress)?;
                Ok(Self::Rayleigh(Box::new(flush)))
            }
            (_, RadiationMethod::Erp) => standing_erp(design, structure, air),
            (_, RadiationMethod::Bem) => {
                let bem = standing(design, structure, air, cache, progress)?;
                Ok(Self::Bem(Box::new(bem)))
            }
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
            Self::Rayleigh(flush) => vec![damping_of(&flush.sound.waves, &structure.workpiece.omega)],
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

/// Rayleigh's integral over it: the top by itself once for every air; sand that moves along in the design's own, which takes
/// little longer than to read it would.
fn flush_top(design: &Design, body: &Body, air: &Air, cache: &Store, progress: &Progress) -> Result<Flush, Error> {
    let sand = &design.support.sand;
    let surface = radiating(body, |patch, _| patch != "top")?;
    let absorbing = (sand.absorption_share > 0.0).then(|| absorbing_sand(design));
    let top = body.top_hz.min(design.analysis.range_high);
    let standard = Air::default();
    let apart = (air.sound_speed / standard.sound_speed).ln().abs() > FlushSound::WIDEST.ln();
    let computed = if apart { *air } else { standard };
    let places = microphones::positions(design);
    let middle = Point3::new(0.0, 0.0, design.workpiece.thickness);
    let sampling_to = |top: f64| Sampling {
        range_hz: [LOWEST_SAMPLE.min(0.5 * top), top],
        ..Sampling::default()
    };
    let sampled = |rayleigh: &Rayleigh, sampling: &Sampling| {
        progress.count_each(("Rayleigh's integral", "frequencies"), 0, |one_more| {
            FlushSound::new(rayleigh, sampling, &places, middle, one_more).map_err(Error::from)
        })
    };
    let sampling = sampling_to(top * FlushSound::WIDEST);
    let points: Vec<[f64; 3]> = surface.points().iter().map(|p| [p.x, p.y, p.z]).collect();
    let normals: Vec<[f64; 3]> = surface.normals().iter().map(|n| [n.x, n.y, n.z]).collect();
    let of_top = Key::new()
        .with(&format!("{places:?}"))
        .with(&points)
        .with(&normals)
        .with(surface.weights())
        .with(surface.patch())
        .with(surface.patch_names())
        .with(surface.normal_modes().as_slice())
        .with(&format!("{computed:?} {sampling:?}"));
    let read = |from: &mut dyn Read, length| Ok::<_, Error>(FlushSound::from_reader(from, length)?);
    let alone = cache.decoded_or("radiation of the workpiece in a plane", &of_top, read, || {
        Ok(sampled(&Rayleigh::new(&surface, &computed)?, &sampling)?.to_bytes())
    })?;
    let mut sound = alone.in_air(&computed, air, absorbing);
    if sand.moving_surface {
        let to = top.min(moving_sand(design)?.to_hz);
        sound = sampled(&flush_surface(design, body, air)?, &sampling_to(to))?.continued(sound);
    }
    Ok(Flush {
        sound,
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

/// ERP of block and table, or of a block alone. Where they face each other, under the table's feet and at welds, no sound gets out.
fn standing_erp(design: &Design, structure: &Structure, air: &Air) -> Result<Radiator, Error> {
    let half = [0.5 * design.workpiece.length, 0.5 * design.workpiece.width];
    // A gap sounds, be it ever so narrow.
    let hung = design.support.kind == SupportKind::Springs && design.support.clearance > 0.0;
    let of_body = |body: &Body| {
        let hidden = |patch: &str, p: &Point3<f64>| match patch {
            "bottom" => body.name != "workpiece" || !hung,
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
