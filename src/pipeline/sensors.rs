//! Displacement of a body's modes at the sensors on it.

use nailnoise_fem::LoadVector;
use nailnoise_meshes::MeshError;

use super::Body;
use super::bodies::GraphBody;
use crate::design::inputs;
use crate::design::{Carrier, Design};
use crate::error::Error;
use crate::stages::sensors::{BodySensors, SensorPoint};

/// How far off its body a sensor may be \[m\]: less than half its base, more than the chords of a mesh are off the
/// cylinders that they stand for.
const OFF: f64 = 1e-3;

/// The sensors of a design on one of its bodies.
///
/// # Errors
/// [`DesignError::Sensor`](crate::design::DesignError::Sensor) for a sensor that is not on its body, and those of
/// [`GraphBody::modes`].
pub(super) fn shapes(design: &Design, carrier: Carrier, body: &GraphBody) -> Result<BodySensors, Error> {
    let points = inputs::sensors::points(design, carrier)?;
    let vectors = load_vectors(&points, body).map_err(|error| inputs::sensors::located(design, error))?;
    Ok(BodySensors {
        shapes: body.participation(vectors)?,
        names: points.into_iter().map(|point| point.name).collect(),
    })
}

fn load_vectors(points: &[SensorPoint], body: &Body) -> Result<Vec<LoadVector>, Error> {
    let of_point = |point: &SensorPoint| {
        LoadVector::point(&body.mesh, point.position.into(), point.direction.into(), OFF).map_err(|error| match error {
            MeshError::Outside { distance, .. } => Error::SensorOffBody {
                sensor: point.name.clone(),
                body: body.name,
                distance,
            },
            other => other.into(),
        })
    };
    points.iter().map(of_point).collect()
}
