//! Place of the nail, and the stations along its axis where its force acts on the wood.

use nailnoise_fem::{LoadVector, Rectangle};
use nailnoise_meshes::{Mesh, MeshError};
use nalgebra::{Point3, Vector3};
use serde::Serialize;

/// Number of stations from the surface to the depth of a fully driven tip; for a 12d nail their spacing is 7.5 mm,
/// finer than the elements.
pub(crate) const STATIONS: usize = 12;

/// Depths of the stations below the nail's entry \[m\].
pub(crate) fn depths(nail_length: f64) -> [f64; STATIONS] {
    std::array::from_fn(|k| nail_length * k as f64 / (STATIONS - 1) as f64)
}

/// Place of the nail and of the tool's nose on the top of the workpiece.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct NailPlace {
    /// Position (x, y) \[m\].
    pub at: [f64; 2],
    /// Height of the top \[m\].
    pub top: f64,
    /// Height at which the nail enters the wood: that of the top, or of the bottom of a groove \[m\].
    pub entry: f64,
    /// Length of the nail \[m\].
    pub length: f64,
    /// Lengths of the nose along x and y \[m\].
    pub nose: [f64; 2],
}

impl NailPlace {
    /// Downward displacement of the nail stations, then of the nose.
    pub(super) fn load_vectors(&self, mesh: &Mesh) -> Result<Vec<LoadVector>, MeshError> {
        let ([x, y], down) = (self.at, -Vector3::z());
        let station = |depth: f64| LoadVector::point(mesh, Point3::new(x, y, self.entry - depth), down, 0.0);
        let nose = Rectangle::horizontal(Point3::new(x, y, self.top), self.nose);
        let stations = depths(self.length).map(station).into_iter();
        stations
            .chain([LoadVector::rectangle(mesh, "top", &nose, down)])
            .collect()
    }
}
