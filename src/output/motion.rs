//! Animation of one mode for ParaView.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use nailnoise_meshes::vtu::{self, Field, Grid};

use crate::atomic_write::AtomicWrite;
use crate::error::Error;
use crate::stages::bodies::Body;

/// Number of instants in a period.
const FRAMES: usize = 24;

/// Largest displacement as a fraction of the body's diagonal: visible, but without folding the surface.
const AMPLITUDE: f64 = 0.05;

/// Writes one period of a mode as `mode-N.pvd` and one `.vtu` per instant. The surface is displaced by a cos(omega t)
/// phi, with `a` such that the largest displacement is a twentieth of the body; this displacement is also stored as a
/// vector \[m\].
pub(super) fn write(staging: &AtomicWrite, folder: &Path, body: &Body, mode: usize) -> Result<PathBuf, Error> {
    let name = format!("mode-{:04}", mode + 1);
    let shape = body.skin.column(mode).map(f64::from);
    let points = shape.as_slice().chunks_exact(3);
    let largest = points
        .map(|u| u.iter().map(|u| u * u).sum::<f64>().sqrt())
        .fold(0.0, f64::max);
    let (low, high) = body.mesh.bounds();
    let scale = AMPLITUDE * (high - low).norm() / largest;
    // A rigid-body mode has no period.
    let hz = if body.basis.rigid[mode] {
        1.0
    } else {
        body.basis.hz[mode]
    };
    let mut moved = body.surface.clone();
    let mut series = Vec::with_capacity(FRAMES);
    for frame in 0..FRAMES {
        let phase = frame as f64 / FRAMES as f64;
        let factor = scale * (TAU * phase).cos();
        let displacement: Vec<f64> = shape.iter().map(|u| factor * u).collect();
        for ((p, still), u) in moved
            .points
            .iter_mut()
            .zip(&body.surface.points)
            .zip(displacement.chunks(3))
        {
            *p = still + nalgebra::Vector3::new(u[0], u[1], u[2]);
        }
        let file = format!("{name}/{frame:02}.vtu");
        let field = Field {
            name: "displacement [m]",
            components: 3,
            values: &displacement,
        };
        staging.write(&folder.join(&file), &Grid::of_surface(&moved).to_bytes(&[field], &[])?)?;
        series.push((phase / hz, file));
    }
    let list = folder.join(format!("{name}.pvd"));
    staging.write(&list, vtu::series(&series).as_bytes())?;
    Ok(list)
}
