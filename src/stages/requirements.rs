//! Requirements that a run places on a body, checked as soon as it is meshed, before time is spent on its modes.

use std::sync::Arc;

use nailnoise_meshes::Surface;
use serde::{Deserialize, Serialize};

use super::bodies::tool_loads::MASS_LIMIT;
use super::bodies::{BodyKind, FoundSurface, Meshed, Model, SensorPoint};
use super::radiation::{CapSurface, Places, ToolRadiation, WorkpieceRadiation};
use super::{Code, OnDemand, Postcard, Progress, Stage, Stored, all, code};
use crate::error::Error;
use crate::stages::bodies::BodyError;

/// Requirements that a run places on a body: places of forces, contacts, springs and sensors, its mass, one connected
/// piece, and a surface that can radiate.
#[derive(Serialize)]
pub struct Requirements {
    /// The body.
    pub kind: BodyKind,
    /// The meshed body.
    pub meshed: Stored<Meshed>,
    /// Its finite elements with the load vectors of the shot.
    pub model: OnDemand<Stored<Model>>,
    /// Sensors on it.
    pub sensors: Vec<SensorPoint>,
    /// Required mass \[kg\]; `None` for a body whose mass is that of its mesh.
    pub mass: Option<f64>,
    /// The radiating surface.
    pub radiating: Option<Radiating>,
}

/// A radiating surface of one body or of several.
#[derive(Serialize)]
pub enum Radiating {
    /// The tool's body, its cap if separate, and the microphones.
    Tool(ToolRadiation, Option<CapSurface>, Places),
    /// The workpiece, a table below it, and the microphones.
    Workpiece(WorkpieceRadiation, Vec<Stored<Meshed>>, Places),
}

/// A body that a run can use.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Preflight {
    /// Surfaces that its file does not name.
    pub surfaces: Vec<FoundSurface>,
}

impl Stage for Requirements {
    type Output = Preflight;
    type Error = Error;
    type Codec = Postcard;
    const NAME: &'static str = "requirements of a body";
    const CODE: Code = code!(
        meshes,
        fem,
        acoustics,
        stages_bodies,
        stages_radiation,
        stages_requirements
    );

    fn compute(&self, _: &Progress) -> Result<Preflight, Error> {
        let (meshed, body) = (self.meshed.get()?, self.kind.name());
        let of_model = self.model.get().map(drop);
        let others = match &self.radiating {
            Some(Radiating::Workpiece(_, bodies, _)) => all(bodies)?,
            _ => Vec::new(),
        };
        // These checks are independent of each other; their findings stay in order.
        let of_pieces = || meshed.check_pieces(body);
        let of_radiation = || match &self.radiating {
            Some(radiating) => radiating.check(&Surface::of(&meshed.imported.mesh), &others),
            None => Ok(()),
        };
        let (of_pieces, of_radiation) = rayon::join(of_pieces, of_radiation);
        let mut problems = Vec::new();
        let mut check = |result: Result<(), Error>| problems.extend(result.err().into_iter().flat_map(Error::parts));
        check(of_model);
        check(of_pieces);
        for sensor in &self.sensors {
            check(sensor.load_vector(&meshed.imported.mesh, body).map(drop));
        }
        if let Some(expected) = self.mass.filter(|_| meshed.unplaced.is_empty()) {
            let found = meshed.mass()?;
            if (found / expected - 1.0).abs() > MASS_LIMIT {
                check(Err(BodyError::OtherMass { found, tool: expected }.into()));
            }
        }
        check(of_radiation);
        Error::of_body(body, problems)?;
        Ok(Preflight {
            surfaces: meshed.surfaces.clone(),
        })
    }
}

impl Radiating {
    fn check(&self, own: &Surface, others: &[Arc<Meshed>]) -> Result<(), Error> {
        match self {
            Self::Tool(radiation, cap, places) => radiation.check(own, cap.as_ref(), places),
            Self::Workpiece(radiation, _, places) => {
                let surfaces = others.iter().map(|meshed| Surface::of(&meshed.imported.mesh));
                radiation.check(&surfaces.collect::<Vec<_>>(), places)
            }
        }
    }
}
