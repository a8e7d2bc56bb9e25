//! The shot as a film for ParaView: velocity of each body's surface at instants around the events.

use std::path::Path;

use nailnoise_dynamics::Events;
use nailnoise_fem::transient::{ModalResponse, Motion};
use nailnoise_meshes::vtu::{Field, write_series, write_surface};
use nalgebra::DMatrix;

use crate::error::Error;
use crate::pipeline::{Body, Driven, Run};

/// Instants shown after each event \[s\]: at once, and while the waves run through the body.
const AROUND: [f64; 3] = [5e-5, 3e-4, 1e-3];

/// Modes replayed at once, which bounds the memory.
const BLOCK: usize = 32;

/// Writes `BODY-shot.pvd` and the `.vtu` of each instant: the velocity vector \[m/s\] on every point of the surface.
pub(super) fn write(folder: &Path, run: &Run) -> Result<(), Error> {
    for Driven {
        body, response, index, ..
    } in run.driven()
    {
        let samples = instants(&run.record.events, response);
        let velocity = velocities(index, body, response, &samples)?;
        let name = format!("{}-shot", body.name);
        super::create(&folder.join(&name))?;
        let mut series = Vec::with_capacity(samples.len());
        for (frame, (&sample, values)) in samples.iter().zip(velocity.column_iter()).enumerate() {
            let file = format!("{name}/{frame:03}.vtu");
            let field = Field {
                name: "velocity [m/s]",
                components: 3,
                values: values.as_slice(),
            };
            write_surface(&folder.join(&file), &body.surface, &[field], &[])?;
            series.push((sample as f64 * response.step, file));
        }
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

/// 3 surface points x instants \[m/s\].
fn velocities(index: usize, body: &Body, response: &ModalResponse, samples: &[usize]) -> Result<DMatrix<f64>, Error> {
    let dofs: Vec<usize> = body
        .surface
        .volume_nodes
        .iter()
        .flat_map(|n| [3 * n, 3 * n + 1, 3 * n + 2])
        .collect();
    let modes = body.omega.len();
    let mut velocity = DMatrix::zeros(dofs.len(), samples.len());
    for first in (0..modes).step_by(BLOCK) {
        let range = first..modes.min(first + BLOCK);
        let shapes = body.shapes.columns(first, range.len()).select_rows(&dofs);
        let motion = response.modal(index, range, Motion::Velocity)?;
        let chosen = motion.select_rows(samples).transpose();
        velocity.gemm(1.0, &shapes, &chosen, 1.0);
    }
    Ok(velocity)
}
