//! A mode as a picture: the deformed surface.

use nalgebra::Vector3;

use super::raster::{Triangle, picture, scale};
use crate::stages::bodies::Body;

/// Size of a picture \[px\].
const SIZE: [usize; 2] = [480, 330];

/// Largest displacement as a fraction of the body's diagonal: visible, but without folding the surface.
pub(super) const AMPLITUDE: f64 = 0.06;

/// The picture as a data URL; the colour shows the displacement at the centre of a face relative to the largest.
pub(super) fn mode(body: &Body, mode: usize) -> String {
    let surface = &body.surface;
    let shape = body.skin.column(mode);
    let moves: Vec<Vector3<f64>> = (0..surface.points.len())
        .map(|point| shape.fixed_rows::<3>(3 * point).map(f64::from))
        .collect();
    let largest = moves.iter().map(Vector3::norm).fold(f64::MIN_POSITIVE, f64::max);
    let (low, high) = body.mesh.bounds();
    let amplitude = AMPLITUDE * (high - low).norm() / largest;
    let moved = |point: usize| surface.points[point].coords + amplitude * moves[point];
    let mut triangles = Vec::new();
    for face in &surface.faces {
        let corners: Vec<usize> = (0..face.kind.corners()).map(|corner| face.nodes[corner]).collect();
        let size = corners.iter().map(|&p| moves[p]).sum::<Vector3<f64>>().norm() / (corners.len() as f64 * largest);
        triangles.extend((2..corners.len()).map(|last| Triangle {
            corners: [0, last - 1, last].map(|corner| moved(corners[corner])),
            colour: scale(size),
        }));
    }
    picture(&triangles, SIZE)
}
