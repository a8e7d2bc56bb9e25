//! The bodies as radiators in the ambient air, and the effect of that air on their modes.

use nailnoise_acoustics::radiation::Erp;
use nailnoise_acoustics::radiation::boundary_elements::ModalBem;
use nailnoise_acoustics::radiation::fluid_loading::DryModes;
use nailnoise_acoustics::radiation::flush_with_sand::{FlushRadiator, FlushSound};
use nailnoise_acoustics::radiation::radiator::{FluidLoads, Loading, Radiator, SeparateBodies};
use nailnoise_acoustics::{AcousticsError, Air};
use serde::Serialize;

use super::CODE;
use super::covered::CoveredFaces;
use super::flush_with_sand::{FlushTop, top_of};
use super::matrices::FlushMatrix;
use crate::error::Error;
use crate::stages::bodies::Body;
use crate::stages::{Code, OnDemand, Postcard, Progress, Stage, Stored, Uncached, all};

/// Method for the radiation of the workpiece with its support, with the results in standard air.
#[derive(Serialize)]
pub enum WorkpieceMethod {
    /// By boundary elements.
    BoundaryElements(Stored<ModalBem>),
    /// By the equivalent radiated power of each body.
    Erp(CoveredFaces),
    /// By Rayleigh's integral over the block's top, flush with the sand.
    Rayleigh(FlushTop, Stored<FlushSound>),
}

/// Workpiece and support as a radiator in the ambient air.
#[derive(Serialize)]
pub struct WorkpieceRadiator {
    /// The method.
    pub method: WorkpieceMethod,
    /// The bodies.
    pub bodies: OnDemand<Vec<Stored<Body>>>,
    /// The ambient air.
    pub air: Air,
}

impl Stage for WorkpieceRadiator {
    type Output = Box<dyn Radiator>;
    type Error = Error;
    type Codec = Uncached;
    const NAME: &'static str = "radiation in the ambient air";
    const CODE: Code = CODE;

    fn compute(&self, progress: &Progress) -> Result<Box<dyn Radiator>, Error> {
        let air = &self.air;
        Ok(match &self.method {
            WorkpieceMethod::BoundaryElements(matrix) => Box::new(matrix.get()?.in_air(&Air::default(), air)),
            WorkpieceMethod::Erp(covered) => {
                let mut parts = Vec::new();
                for body in self.bodies.iter() {
                    let body = body.get()?;
                    parts.push((body.name, covered.erp(&body.moving_surface(), air)?));
                }
                Box::new(SeparateBodies(parts))
            }
            WorkpieceMethod::Rayleigh(top, alone) => {
                let surface = top_of(&self.bodies[0].get()?.moving_surface())?;
                let computed = FlushMatrix::computed_air(air);
                let alone = FlushSound::clone(&*alone.get()?);
                Box::new(FlushRadiator {
                    sound: top.in_sand(alone, &surface, (&computed, air), progress)?,
                    erp: Erp::new(&surface, air),
                    sand: top.absorbing,
                })
            }
        })
    }
}

/// The tool's housing as a radiator in the ambient air.
#[derive(Serialize)]
pub struct ToolRadiator {
    /// Its boundary elements in standard air.
    pub matrix: Stored<ModalBem>,
    /// The ambient air.
    pub air: Air,
}

impl Stage for ToolRadiator {
    type Output = ModalBem;
    type Error = Error;
    type Codec = Uncached;
    const NAME: &'static str = "radiation of the tool in the ambient air";
    const CODE: Code = CODE;

    fn compute(&self, _: &Progress) -> Result<ModalBem, Error> {
        Ok(self.matrix.get()?.in_air(&Air::default(), &self.air))
    }
}

/// Damping and added mass due to the air, for each mode of each body.
#[derive(Serialize)]
#[serde(bound = "R: Send + Sync + 'static")]
pub struct FluidLoadings<R> {
    /// The radiator.
    pub radiator: Stored<R>,
    /// The bodies.
    pub bodies: Vec<Stored<Body>>,
    /// Damping ratio of the structure of each body \[-\], if the added mass of the air is to act.
    pub with_mass: Option<Vec<f64>>,
}

impl<R: Radiator + 'static> Stage for FluidLoadings<R> {
    /// One for each body.
    type Output = Vec<FluidLoads>;
    type Error = Error;
    type Codec = Postcard;
    const NAME: &'static str = "fluid loading";
    const CODE: Code = CODE;

    fn compute(&self, _: &Progress) -> Result<Vec<FluidLoads>, Error> {
        let mut modes = Vec::new();
        for (index, body) in all(&self.bodies)?.iter().enumerate() {
            let zeta = self.with_mass.as_ref().map_or(0.0, |zeta| zeta[index]);
            let omega = body.omega.clone();
            let zeta = vec![zeta; omega.len()];
            modes.push(DryModes::new(omega, zeta).map_err(AcousticsError::from)?);
        }
        let acts = match self.with_mass {
            Some(_) => Loading::Full,
            None => Loading::Damping,
        };
        Ok(self.radiator.get()?.loads(&modes, acts)?)
    }
}
