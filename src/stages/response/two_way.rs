//! Stages of the two-way coupled response.

use std::sync::Arc;

use nailnoise_dynamics::CouplingWork;
use serde::{Deserialize, Serialize};

use super::coupling::Coupled;
use super::shot::ShotInputs;
use super::{CODE, Structure, Vibration, checks};
use crate::error::Error;
use crate::result::Check;
use crate::stages::cycle::{Engine, ShotRecord};
use crate::stages::{Code, Postcard, Progress, Stage, Stored, Uncached};

/// Cycle and response of workpiece and support together, each acting on the other.
#[derive(Serialize)]
pub struct CoupledResponse {
    /// Supports and duration.
    pub shot: ShotInputs,
    /// The bodies.
    pub structure: Structure,
    /// The engine of the cycle.
    pub engine: Engine,
}

impl Stage for CoupledResponse {
    type Output = Coupled;
    type Error = Error;
    /// An intermediate result of stored outputs.
    type Codec = Uncached;
    const NAME: &'static str = "nailing cycle with workpiece and support";
    const CODE: Code = CODE;

    fn compute(&self, _: &Progress) -> Result<Coupled, Error> {
        let (bodies, coordinates) = self.structure.modal_bodies(&self.shot)?;
        let coupled = self.shot.two_way(&bodies, &self.engine)?;
        Ok(Coupled { coordinates, ..coupled })
    }
}

/// The cycle of a coupled response.
#[derive(Serialize)]
pub struct CoupledCycle(pub Stored<Coupled>);

impl Stage for CoupledCycle {
    type Output = ShotRecord;
    type Error = Error;
    type Codec = Uncached;
    const NAME: &'static str = "nailing cycle of the coupled response";
    const CODE: Code = CODE;

    fn compute(&self, _: &Progress) -> Result<ShotRecord, Error> {
        Ok(self.0.get()?.shot.clone())
    }
}

/// The motion of a coupled response.
#[derive(Serialize)]
pub struct CoupledVibration(pub Stored<Coupled>);

impl Stage for CoupledVibration {
    type Output = Vibration;
    type Error = Error;
    type Codec = Uncached;
    const NAME: &'static str = "motion of the coupled response";
    const CODE: Code = CODE;

    fn compute(&self, _: &Progress) -> Result<Vibration, Error> {
        let both = self.0.get()?;
        let response = Arc::clone(&both.response);
        Ok(Vibration {
            checks: checks("response", &response),
            coordinates: both.coordinates.clone(),
            response,
        })
    }
}

/// Iterations and checks of a coupled response.
#[derive(Serialize)]
pub struct CouplingReport(pub Stored<Coupled>);

/// Output of [`CouplingReport`].
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Reported {
    /// Iterations and the remaining difference.
    pub work: CouplingWork,
    /// Forces and work on both sides.
    pub checks: Vec<Check>,
}

impl Stage for CouplingReport {
    type Output = Reported;
    type Error = Error;
    type Codec = Postcard;
    const NAME: &'static str = "checks of the coupling";
    const CODE: Code = CODE;

    fn compute(&self, _: &Progress) -> Result<Reported, Error> {
        let both = self.0.get()?;
        Ok(Reported {
            work: both.work,
            checks: both.checks.clone(),
        })
    }
}
