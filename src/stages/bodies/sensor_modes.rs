//! Displacement of sensors in each mode.

use nailnoise_fem::LoadVector;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::body::{Body, participation};
use super::modes::WholeModes;
use crate::error::Error;
use crate::stages::{Code, Input, Postcard, Progress, Stage, Stored, code, matrix};

/// Evaluates the modes of a body at sensors. The result is kept, because it takes the whole shapes.
#[derive(Serialize)]
pub struct SensorModes {
    /// Load vectors of the sensors.
    pub vectors: Vec<LoadVector>,
    /// The body.
    pub body: Stored<Body>,
    /// Its whole modes.
    pub modes: Stored<WholeModes>,
}

/// Displacement along the axis of each sensor in each mode.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SensorShapes {
    /// Modes x sensors \[kg^-1/2\].
    #[serde(with = "matrix")]
    pub shapes: DMatrix<f64>,
}

impl Stage for SensorModes {
    type Output = SensorShapes;
    type Codec = Postcard;
    const NAME: &'static str = "sensor modes";
    const CODE: Code = code!(fem, stages_bodies);

    fn inputs(&self) -> Vec<&dyn Input> {
        vec![&self.body, &self.modes]
    }

    fn compute(&self, _: &Progress) -> Result<SensorShapes, Error> {
        let (body, modes) = (self.body.get()?, self.modes.get()?);
        Ok(SensorShapes {
            shapes: participation(&self.vectors, body.shapes(&modes)?),
        })
    }
}
