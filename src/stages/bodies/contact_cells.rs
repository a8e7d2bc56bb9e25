//! Contact cells: areas where two plane faces touch.

use nailnoise_fem::supports::{ContactGrid, GridRule};
use nailnoise_fem::{LoadVector, Rectangle};
use nailnoise_meshes::{Mesh, MeshError};
use nalgebra::{Point3, Vector3};
use serde::Serialize;

/// Cells where the underside of the workpiece touches its support.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ContactCells {
    /// Lengths of the underside along x and y \[m\].
    pub size: [f64; 2],
    /// Number of cells along x and y.
    pub cells: [u32; 2],
}

impl ContactCells {
    /// Their centres and areas.
    pub fn grid(&self) -> ContactGrid {
        let ([length, width], [along, across]) = (self.size, self.cells.map(|n| n as usize));
        ContactGrid::new(length, width, along, across, GridRule::CellCentred)
    }

    /// Mean displacement of each cell on a face group at a height \[m\] along a direction.
    pub(super) fn load_vectors(
        &self,
        mesh: &Mesh,
        group: &str,
        height: f64,
        direction: Vector3<f64>,
    ) -> Result<Vec<LoadVector>, MeshError> {
        let size = [0, 1].map(|axis| self.size[axis] / f64::from(self.cells[axis]));
        let cell = |&[x, y]: &[f64; 2]| {
            let cell = Rectangle::horizontal(Point3::new(x, y, height), size);
            LoadVector::rectangle(mesh, group, &cell, direction)
        };
        self.grid().points.iter().map(cell).collect()
    }
}
