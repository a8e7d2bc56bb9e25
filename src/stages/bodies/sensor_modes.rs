//! Displacement of sensors in each mode.

use nailnoise_fem::LoadVector;
use nailnoise_meshes::{Mesh, MeshError};
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::body::{Body, participation};
use super::modes::WholeModes;
use crate::error::Error;
use crate::stages::bodies::BodyError;
use crate::stages::{Code, Postcard, Progress, Stage, Stored, code, matrix};

/// Maximum distance of a sensor from its body \[m\]: less than half its base, and larger than the deviation of a mesh
/// from a cylinder.
const OFF: f64 = 1e-3;

/// Place of a sensor on an elastic body.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SensorPoint {
    /// Name of the sensor.
    pub name: String,
    /// Position \[m\].
    pub position: [f64; 3],
    /// Direction of the measured displacement component \[-\].
    pub direction: [f64; 3],
}

/// Displacement of the modes of a body at the sensors on it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BodySensors {
    /// Names of the sensors.
    pub names: Vec<String>,
    /// Displacement along the axis of each sensor: modes x sensors \[kg^-1/2\].
    #[serde(with = "matrix")]
    pub shapes: DMatrix<f64>,
}

/// Evaluates the modes of a body at sensors. The result is stored, because it needs the full shapes.
#[derive(Serialize)]
pub struct SensorModes {
    /// Places of the sensors.
    pub points: Vec<SensorPoint>,
    /// The body.
    pub body: Stored<Body>,
    /// Its full modes.
    pub modes: Stored<WholeModes>,
}

impl Stage for SensorModes {
    type Output = BodySensors;
    type Error = Error;
    type Codec = Postcard;
    const NAME: &'static str = "sensor modes";
    const CODE: Code = code!(meshes, fem, stages_bodies);

    fn compute(&self, _: &Progress) -> Result<BodySensors, Error> {
        let (body, modes) = (self.body.get()?, self.modes.get()?);
        let vectors: Vec<LoadVector> = self
            .points
            .iter()
            .map(|point| point.load_vector(&body.mesh, body.name))
            .collect::<Result<_, _>>()?;
        Ok(BodySensors {
            names: self.points.iter().map(|point| point.name.clone()).collect(),
            shapes: participation(&vectors, body.shapes(&modes)?),
        })
    }
}

impl SensorPoint {
    /// The load vector on the mesh of a body that measures this displacement.
    ///
    /// # Errors
    /// [`BodyError::SensorOffBody`] with the distance.
    pub fn load_vector(&self, mesh: &Mesh, body: &'static str) -> Result<LoadVector, Error> {
        LoadVector::point(mesh, self.position.into(), self.direction.into(), OFF).map_err(|error| match error {
            MeshError::Outside { distance, .. } => BodyError::SensorOffBody {
                sensor: self.name.clone(),
                body,
                distance,
            }
            .into(),
            other => other.into(),
        })
    }
}
