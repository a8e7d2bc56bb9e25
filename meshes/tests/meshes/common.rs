//! Shared by the tests of meshes.
#![allow(dead_code, clippy::unwrap_used)] // each file of tests uses its part; a test may panic, in its helpers too

use nailnoise_meshes::{Mesh, Surface};
use nalgebra::Vector3;

/// Area of a named group \[m2\].
pub(crate) fn area(mesh: &Mesh, group: &str) -> f64 {
    let surface = Surface::of(mesh);
    surface.patch_area(surface.patch(group).unwrap())
}

/// Asserts that a value has its expected value within a relative tolerance.
#[track_caller]
pub(crate) fn close(found: f64, expected: f64, relative: f64) {
    assert!(
        (found / expected - 1.0).abs() < relative,
        "{found:e} instead of {expected:e}"
    );
}

/// Asserts that the surface is closed, that the integral of its normal vanishes, and that positions, normals and nodes
/// agree with the mesh.
pub(crate) fn assert_sound(mesh: &Mesh) -> Surface {
    let surface = Surface::of(mesh);
    assert_eq!(surface.open_edges(), 0);
    let closure: Vector3<f64> = surface.quadrature(2).unwrap().iter().map(|q| q.normal * q.weight).sum();
    assert!(closure.norm() < 1e-14);
    for q in surface.quadrature(2).unwrap() {
        let face = &surface.faces[q.face];
        let x: Vector3<f64> = (0..8).map(|a| q.shape[a] * surface.points[face.nodes[a]].coords).sum();
        assert!((x - q.position.coords).norm() < 1e-15);
        assert!((q.normal.norm() - 1.0).abs() < 1e-14);
    }
    for (point, &node) in surface.points.iter().zip(&surface.volume_nodes) {
        assert_eq!(point, &mesh.nodes[node]);
    }
    surface
}
