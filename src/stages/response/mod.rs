//! Response of workpiece and support to a shot: modal bodies on supports that can lose contact.
//!
//! With one-way coupling, the cycle has its own lumped workpiece, and its forces on the wood drive the bodies:
//! [`Response`]. With two-way coupling, cycle and bodies are computed together: [`CoupledResponse`]. [`CoupledCycle`],
//! [`CoupledVibration`] and [`CouplingReport`] are the parts of its output that other stages use. If no contact can
//! open, [`LinearResponse`] adds the effect of the complete radiation impedance.

mod coupling;
mod fluid;
mod linear;
mod nail_force;
mod shot;
mod two_way;

use std::sync::Arc;

use nailnoise_acoustics::radiation::radiator::FluidLoads;
use nailnoise_fem::vibration::{Ending, ModalBody, ModalResponse};
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

pub(in crate::stages) use fluid::in_air;

pub use coupling::{COUPLED_LOADS, Coupled, CoupledTool, couple};
pub use linear::LinearResponse;
pub use nail_force::{DrivenFastener, FastenerLaw};
pub use shot::{OneWay, ShotInputs};
pub use two_way::{CoupledCycle, CoupledResponse, CoupledVibration, CouplingReport, Reported};

use super::bodies::Body;
use super::{Code, Postcard, Progress, Stage, Stored, Uncached, code};
use crate::error::Error;
use crate::result::Check;
use crate::stages::cycle::ShotRecord;

/// Code that the stages of this module call.
const CODE: Code = code!(
    dynamics,
    meshes,
    fem,
    acoustics,
    stages_bodies,
    stages_response,
    stages_cycle
);

/// Motion of one or several bodies in a shot.
#[derive(Debug)]
pub struct Vibration {
    /// Forces and motion.
    pub response: Arc<ModalResponse>,
    /// For each body, amplitudes of its modes in vacuum in terms of its modes in the response, modes x coordinates;
    /// `None` if both are the same.
    pub coordinates: Vec<Option<DMatrix<f64>>>,
    /// Checks of the response.
    pub checks: Vec<Check>,
}

/// Workpiece and support, as needed for a response.
#[derive(Clone, Serialize)]
pub struct Structure {
    /// The workpiece, and the worktable if there is one.
    pub bodies: Vec<Stored<Body>>,
    /// Loss factor of the modes of each \[-\].
    pub loss_factors: Vec<f64>,
    /// Fluid loads of the air on the modes of each body, if the air acts on them.
    pub fluid: Option<Stored<Vec<FluidLoads>>>,
}

impl Structure {
    /// The bodies in the form that the transient solver needs, workpiece first, with [`Vibration::coordinates`].
    fn modal_bodies(&self, shot: &ShotInputs) -> Result<(Vec<ModalBody>, Vec<Option<DMatrix<f64>>>), Error> {
        let mut bodies = Vec::new();
        for (index, (body, loss_factor)) in self.bodies.iter().zip(&self.loss_factors).enumerate() {
            bodies.push(shot.modal_body(&*body.get()?, *loss_factor, index == 0));
        }
        let Some(fluid) = &self.fluid else {
            let coordinates = vec![None; bodies.len()];
            return Ok((bodies, coordinates));
        };
        let fluid = fluid.get()?;
        let in_air = bodies
            .into_iter()
            .zip(fluid.iter())
            .map(|(body, loads)| in_air(body, loads));
        Ok(in_air.unzip())
    }
}

/// Response of workpiece and support to the forces of a cycle.
#[derive(Serialize)]
pub struct Response {
    /// Supports, loads and duration.
    pub shot: ShotInputs,
    /// The bodies.
    pub structure: Structure,
    /// The cycle.
    pub cycle: Stored<ShotRecord>,
    /// Factor on the forces of the shot on the workpiece \[-\].
    pub force_scale: f64,
}

impl Stage for Response {
    type Output = Vibration;
    type Error = Error;
    /// An intermediate result of stored outputs.
    type Codec = Uncached;
    const NAME: &'static str = "response of workpiece and support";
    const CODE: Code = CODE;

    fn compute(&self, _: &Progress) -> Result<Vibration, Error> {
        let (bodies, coordinates) = self.structure.modal_bodies(&self.shot)?;
        let shot = self.shot.one_way(&bodies, &*self.cycle.get()?, self.force_scale)?;
        Ok(Vibration {
            checks: checks("response", &shot.response)
                .into_iter()
                .chain(shot.checks)
                .collect(),
            response: Arc::new(shot.response),
            coordinates,
        })
    }
}

/// End of all records of a shot.
#[derive(Serialize)]
pub struct End {
    /// The cycle.
    pub cycle: Stored<ShotRecord>,
    /// The longest response: that of an elastic tool if present, because its motion does not decay. None without
    /// bodies.
    pub longest: Option<Stored<Vibration>>,
}

impl Stage for End {
    /// Time \[s\].
    type Output = f64;
    type Error = Error;
    type Codec = Postcard;
    const NAME: &'static str = "end of the records";
    const CODE: Code = CODE;

    fn compute(&self, _: &Progress) -> Result<f64, Error> {
        let record = self.cycle.get()?;
        let of_cycle = record.sample_interval * record.len() as f64;
        let longest = self.longest.as_ref().map(Stored::get).transpose()?;
        Ok(longest.map_or(of_cycle, |own| own.response.duration().max(of_cycle)))
    }
}

/// Checks of bodies and response, and how the response ended.
#[derive(Serialize)]
pub struct ResponseReport {
    /// The bodies.
    pub bodies: Vec<Stored<Body>>,
    /// Their response.
    pub vibration: Stored<Vibration>,
}

/// Output of [`ResponseReport`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ResponseChecks {
    /// Checks of modes and response.
    pub checks: Vec<Check>,
    /// How the response ended, in words.
    pub ending: String,
}

impl Stage for ResponseReport {
    type Output = ResponseChecks;
    type Error = Error;
    type Codec = Postcard;
    const NAME: &'static str = "checks of the response";
    const CODE: Code = CODE;

    fn compute(&self, _: &Progress) -> Result<ResponseChecks, Error> {
        let mut checks = Vec::new();
        for body in &self.bodies {
            checks.extend(body.get()?.checks());
        }
        let vibration = self.vibration.get()?;
        checks.extend(vibration.checks.iter().cloned());
        Ok(ResponseChecks {
            checks,
            ending: ending(&vibration.response),
        })
    }
}

fn ending(response: &ModalResponse) -> String {
    let end = response.duration();
    match response.ending {
        Ending::Decayed { level, .. } if level == f64::NEG_INFINITY => {
            format!("response ended at {end:.3} s, all of its energy gone")
        }
        Ending::Decayed { level, .. } => format!("response ended at {end:.3} s, its energy {level:.0} dB down"),
        Ending::Duration { level, .. } => format!("response cut at {end:.3} s, its energy {level:.0} dB down"),
    }
}

/// Checks of a response, under the name of the body or bodies.
pub(crate) fn checks(of: &str, response: &ModalResponse) -> Vec<Check> {
    response.checks.iter().map(|check| check.clone().of(of)).collect()
}
