//! Forces and pressures on the tool's body at every sample of a shot.
//!
//! The shot names the surface of each force, down, and of each absolute pressure; gauge pressures p act on walls
//! without moving the tool. Where a body leaves a stiff stop of the housing within less than a sampling interval, the
//! mean of its force around each sample takes the place of the sample
//! ([`ShotRecord::impulse_corrections`](crate::stages::cycle::ShotRecord::impulse_corrections)).

use nailnoise_meshes::{Mesh, MeshError};
use nalgebra::DMatrix;

use crate::stages::bodies::tool_loads::{AXIAL, Bore, LOADS, PLENUM, RETURN, RINGS, SUPPLY, axial_index};
use crate::stages::cycle::{BORE, RETURN_WALL, ShotRecord};

/// Forces \[N\] and pressures \[Pa\] of all loads: loads x samples.
///
/// # Errors
/// [`MeshError::UnknownGroup`] for a mesh without a bore.
pub(super) fn histories(mesh: &Mesh, shot: &ShotRecord) -> Result<DMatrix<f64>, MeshError> {
    let bore = Bore::of(mesh)?;
    let ambient = shot.ambient_pressure;
    let mut histories = DMatrix::zeros(LOADS, shot.len());
    for load in shot.loads().chain(&shot.impulse_corrections) {
        if let Some(place) = axial_index(&load.surface) {
            let row = histories.row_mut(place).into_iter();
            row.zip(&load.force).for_each(|(sum, force)| *sum += force);
        }
    }
    for wall in shot.pressures() {
        let place = match wall.surface.as_str() {
            BORE => {
                for sample in 0..shot.len() {
                    for ring in 0..RINGS {
                        let share = bore.above(ring, wall.divide[sample]);
                        let (above, below) = (wall.pressure[sample] - ambient, wall.below[sample] - ambient);
                        histories[(AXIAL + ring, sample)] = share * above + (1.0 - share) * below;
                    }
                }
                continue;
            }
            "jacket" => SUPPLY,
            RETURN_WALL => RETURN,
            "plenum" => PLENUM,
            _ => continue,
        };
        for (sample, pressure) in wall.pressure.iter().enumerate() {
            histories[(place, sample)] = pressure - ambient;
        }
    }
    Ok(histories)
}
