//! Contact cells: areas where two plane faces touch.

use nailnoise_fem::vibration::supports::{ContactGrid, GridRule};
use nailnoise_fem::{LoadVector, Rectangle};
use nailnoise_meshes::{Mesh, MeshError};
use nalgebra::{Point3, Vector3};
use serde::Serialize;

/// Equal cells of a rectangle in which two plane faces touch.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ContactCells {
    /// Centre of the rectangle, x and y \[m\].
    pub centre: [f64; 2],
    /// Its lengths along x and y \[m\].
    pub size: [f64; 2],
    /// Number of cells along x and y.
    pub cells: [u32; 2],
}

impl ContactCells {
    /// Their centres and areas.
    pub fn grid(&self) -> ContactGrid {
        let ([length, width], [along, across]) = (self.size, self.cells.map(|n| n as usize));
        let mut grid = ContactGrid::new(length, width, along, across, GridRule::CellCentred);
        let [x, y] = self.centre;
        grid.points = grid.points.iter().map(|point| [point[0] + x, point[1] + y]).collect();
        grid
    }

    /// The cells as part of a body's face.
    pub fn on(self, group: &'static str, outward: [f64; 3]) -> ContactFace {
        ContactFace {
            cells: self,
            group,
            outward,
        }
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

/// Contact cells on a face of a body.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ContactFace {
    /// The cells.
    pub cells: ContactCells,
    /// The face group that they lie on, in the plane z = 0.
    pub group: &'static str,
    /// Its outward normal.
    pub outward: [f64; 3],
}

impl ContactFace {
    /// Mean displacement of each cell along the outward normal.
    pub(super) fn load_vectors(&self, mesh: &Mesh) -> Result<Vec<LoadVector>, MeshError> {
        let outward = Vector3::from(self.outward);
        self.cells.load_vectors(mesh, self.group, 0.0, outward)
    }
}
