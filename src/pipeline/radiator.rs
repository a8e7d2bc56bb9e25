//! Radiation of the workpiece with its support and of the tool, from the store where it is known.

use std::io::Read;

use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::ModalBem;
use nailnoise_acoustics::radiation::{Archive, Erp, ModalRadiation};
use nailnoise_acoustics::sound::FlushSound;

use super::Body;
use super::bodies::Structure;
use crate::design::Design;
use crate::design::inputs;
use crate::error::Error;
use crate::stages::Progress;
use crate::stages::radiation::{FlushTop, MovingSurface, WorkpieceRadiation};
use crate::store::{Key, Store};

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
    /// Its radiation by spherical waves and by the intensity on the surface, and its pressure at the microphones.
    pub(super) sound: FlushSound,
    /// Its equivalent radiated power.
    pub(super) erp: Erp,
}

impl Radiator {
    /// The operator that the design asks for, from the store where it is known.
    ///
    /// # Errors
    /// Those of mesh and radiation.
    pub(super) fn new(
        design: &Design,
        structure: &Structure,
        air: &Air,
        store: &Store,
        progress: &Progress,
    ) -> Result<Self, Error> {
        let inputs = inputs::radiation::workpiece(design)?;
        let surfaces: Vec<MovingSurface<'_>> = structure.bodies().map(Body::moving_surface).collect();
        match &inputs {
            WorkpieceRadiation::BoundaryElements(elements) => {
                let key = structure.bodies().fold(Key::new().with(&inputs), |key, body| {
                    key.with(body.name).with(&body.identity)
                });
                let stage = ("radiation of workpiece and worktable", &key);
                let bem = stored_matrix(store, stage, || elements.compute(&surfaces, progress))?;
                Ok(Self::Bem(Box::new(bem.in_air(&Air::default(), air))))
            }
            WorkpieceRadiation::Erp(covered) => {
                let erps = surfaces.iter().map(|surface| covered.erp(surface, air));
                Ok(Self::Erp(erps.collect::<Result<_, _>>()?))
            }
            WorkpieceRadiation::Rayleigh(top) => {
                let flush = flush(top, &structure.workpiece, air, store, progress)?;
                Ok(Self::Rayleigh(Box::new(flush)))
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

/// The block's top from the store, where it is known without sand.
fn flush(top: &FlushTop, block: &Body, air: &Air, store: &Store, progress: &Progress) -> Result<Flush, Error> {
    let surface = top.surface(&block.moving_surface())?;
    let computed = FlushTop::computed_air(air);
    let sampling = top.sampling(block.top_hz);
    let points: Vec<[f64; 3]> = surface.points().iter().map(|p| [p.x, p.y, p.z]).collect();
    let normals: Vec<[f64; 3]> = surface.normals().iter().map(|n| [n.x, n.y, n.z]).collect();
    let key = Key::new()
        .with(&top.places)
        .with(&points)
        .with(&normals)
        .with(surface.weights())
        .with(surface.patch())
        .with(surface.patch_names())
        .with(surface.normal_modes().as_slice())
        .with(&format!("{computed:?} {sampling:?}"));
    let read = |from: &mut dyn Read, length| Ok::<_, Error>(FlushSound::from_reader(from, length)?);
    let alone = store.decoded_or("radiation of the workpiece in a plane", &key, read, || {
        Ok(top.alone(&surface, (&computed, &sampling), progress)?.to_bytes())
    })?;
    Ok(Flush {
        sound: top.in_sand(alone, (&surface, block.top_hz), (&computed, air), progress)?,
        erp: Erp::new(&surface, air),
    })
}

/// Boundary elements on the tool's housing, from the store where they are known; none where the design asks for none.
///
/// # Errors
/// Those of mesh and radiation.
pub(super) fn tool_radiation(
    design: &Design,
    body: &Body,
    air: &Air,
    store: &Store,
    progress: &Progress,
) -> Result<Option<ModalBem>, Error> {
    let Some(inputs) = inputs::radiation::tool(design) else {
        return Ok(None);
    };
    let key = Key::new().with(&inputs).with(&body.identity);
    let compute = || inputs.compute(&body.moving_surface(), progress);
    let bem = stored_matrix(store, ("radiation of the tool", &key), compute)?;
    Ok(Some(bem.in_air(&Air::default(), air)))
}

/// A radiation matrix in standard air, from the store where it is known.
fn stored_matrix(
    store: &Store,
    (stage, key): (&str, &Key),
    compute: impl FnOnce() -> Result<ModalBem, Error>,
) -> Result<ModalBem, Error> {
    let read = |from: &mut dyn Read, length| Ok::<_, Error>(ModalBem::from_reader(from, length)?);
    store.decoded_or(stage, key, read, || Ok::<_, Error>(compute()?.to_bytes()))
}
