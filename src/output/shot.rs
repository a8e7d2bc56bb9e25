//! The shot as a film for ParaView: velocity of each body's surface at instants around the events.

use std::path::Path;

use nailnoise_dynamics::Events;
use nailnoise_fem::transient::{ModalResponse, Motion};
use nailnoise_meshes::vtu::{Field, write_series, write_surface};
use nalgebra::{DMatrix, DMatrixView, DMatrixViewMut};
use rayon::prelude::*;

use super::fields::on_surface;
use crate::error::Error;
use crate::pipeline::{Body, Driven, Vibration};

/// Instants shown after each event \[s\]: at once, and while the waves run through the body.
const AROUND: [f64; 3] = [5e-5, 3e-4, 1e-3];

/// Modes replayed at once, which bounds the memory.
const BLOCK: usize = 128;

/// Writes `BODY-shot.pvd` and the `.vtu` of each instant: the velocity vector \[m/s\] on every point of the surface.
pub(super) fn write(folder: &Path, vibration: &Vibration, events: &Events) -> Result<(), Error> {
    for Driven {
        body, response, index, ..
    } in vibration.driven()
    {
        let samples = instants(events, response);
        let velocity = velocities(index, body, response, &samples)?;
        let name = format!("{}-shot", body.name);
        super::create(&folder.join(&name))?;
        let frames: Vec<usize> = (0..samples.len()).collect();
        let series: Vec<(f64, String)> = frames
            .into_par_iter()
            .map(|frame| {
                let file = format!("{name}/{frame:03}.vtu");
                let field = Field {
                    name: "velocity [m/s]",
                    components: 3,
                    values: velocity.column(frame).data.into_slice(),
                };
                write_surface(&folder.join(&file), &body.surface, &[field], &[])?;
                Ok((samples[frame] as f64 * response.step, file))
            })
            .collect::<Result<_, Error>>()?;
        write_series(&folder.join(format!("{name}.pvd")), &series)?;
    }
    Ok(())
}

/// Samples of the response around the events, ascending, each once.
fn instants(events: &Events, response: &ModalResponse) -> Vec<usize> {
    let last = response.samples() - 1;
    let mut samples: Vec<usize> = events
        .to_array()
        .iter()
        .flatten()
        .flat_map(|event| AROUND.map(|offset| ((event + offset) / response.step).round()))
        .filter(|&sample| sample >= 0.0 && sample <= last as f64)
        .map(|sample| sample as usize)
        .collect();
    samples.sort_unstable();
    samples.dedup();
    samples
}

/// Instants whose velocities are summed at once.
const INSTANTS: usize = 16;

/// 3 surface points x instants \[m/s\].
fn velocities(index: usize, body: &Body, response: &ModalResponse, samples: &[usize]) -> Result<DMatrix<f64>, Error> {
    let on_surface = on_surface(body);
    let modes = body.omega.len();
    let rows = on_surface.nrows();
    let mut velocity = DMatrix::zeros(rows, samples.len());
    for first in (0..modes).step_by(BLOCK) {
        let range = first..modes.min(first + BLOCK);
        let shapes = on_surface.columns(first, range.len());
        let motion = response.modal(index, range.clone(), Motion::Velocity)?;
        let chosen = motion.select_rows(samples).transpose();
        velocity
            .as_mut_slice()
            .par_chunks_mut(INSTANTS * rows)
            .zip(chosen.as_slice().par_chunks(INSTANTS * chosen.nrows()))
            .for_each(|(velocity, chosen)| {
                let count = velocity.len() / rows;
                let mut velocity = DMatrixViewMut::from_slice(velocity, rows, count);
                velocity.gemm(1.0, &shapes, &DMatrixView::from_slice(chosen, range.len(), count), 1.0);
            });
    }
    Ok(velocity)
}
