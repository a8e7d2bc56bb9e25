//! The shot as a film for ParaView: velocity of each body's surface at instants around the events.

use nailnoise_dynamics::network::EventTime;
use nailnoise_fem::vibration::{ModalResponse, Motion};
use nailnoise_meshes::vtu::Array;
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::film::Fields;
use crate::error::Error;
use crate::stages::spectra::BodyInMotion;

/// Instants shown after each event \[s\]: immediately after it, and while the waves travel through the body.
const AROUND: [f64; 3] = [5e-5, 3e-4, 1e-3];

/// Number of surface rows whose velocities are computed together.
const ROWS: usize = 512;

/// Adds `BODY-shot.pvd` and the `.vtu` of each instant: the velocity vector \[m/s\] on every point of the surface.
pub(super) fn add(fields: &mut Fields, driven: &BodyInMotion, events: &[EventTime]) -> Result<(), Error> {
    let (response, skin) = (&*driven.vibration.response, &driven.body.skin);
    let samples = instants(events, response);
    let mut velocities = response.at(driven.index, &samples, Motion::Velocity)?;
    if let Some(coordinates) = &driven.vibration.coordinates[driven.index] {
        velocities = coordinates * velocities;
    }
    let amplitudes = velocities.map(|v| v as f32);
    let rows = skin.nrows();
    let starts: Vec<usize> = (0..rows).step_by(ROWS).collect();
    let velocities: Vec<DMatrix<f32>> = starts
        .into_par_iter()
        .map(|first| skin.rows(first, ROWS.min(rows - first)) * &amplitudes)
        .collect();
    let frame = |(frame, sample): (usize, &usize)| {
        let mut values = Vec::with_capacity(rows);
        velocities
            .iter()
            .for_each(|part| values.extend(part.column(frame).iter()));
        let values = Array::new("velocity [m/s]", 3, &values);
        (*sample as f64 * response.step, format!("{frame:03}"), values)
    };
    let frames = samples.par_iter().enumerate().map(frame).collect();
    fields.series(&format!("{}-shot", driven.body.name), frames);
    Ok(())
}

/// Samples of the response around the events, ascending, each once.
fn instants(events: &[EventTime], response: &ModalResponse) -> Vec<usize> {
    let last = response.samples() - 1;
    let mut samples: Vec<usize> = events
        .iter()
        .filter_map(|event| event.time)
        .flat_map(|event| AROUND.map(|offset| ((event + offset) / response.step).round()))
        .filter(|&sample| sample >= 0.0 && sample <= last as f64)
        .map(|sample| sample as usize)
        .collect();
    samples.sort_unstable();
    samples.dedup();
    samples
}
