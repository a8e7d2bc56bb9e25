//! Stress at a point: exact for linear displacement on a curved mesh, converging for bending.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use nailnoise_fem::{Material, stress_at};
use nailnoise_meshes::{Block, Mesh, block};
use nalgebra::{DMatrix, Matrix3, Point3, Vector3, Vector6};

const E: f64 = 2e11;
const NU: f64 = 0.3;

fn bar(divisions: [usize; 3]) -> Mesh {
    block(&Block {
        size: [1.0, 0.2, 0.1],
        divisions,
        origin: [0.0, -0.1, -0.05],
    })
    .unwrap()
}

/// The displacement of every node as one field.
fn field(mesh: &Mesh, displacement: impl Fn(&Point3<f64>) -> Vector3<f64>) -> DMatrix<f64> {
    let values = mesh.nodes.iter().flat_map(|p| <[f64; 3]>::from(displacement(p)));
    DMatrix::from_iterator(3 * mesh.nodes.len(), 1, values)
}

#[test]
fn linear_displacement_has_its_stress_in_distorted_elements() {
    let mut mesh = bar([3, 2, 2]);
    for p in &mut mesh.nodes {
        p.y += 0.02 * (3.0 * p.x).sin();
        p.z += 0.01 * p.x * p.y;
    }
    let gradient = Matrix3::new(1.0, 2.0, -1.0, 0.5, -3.0, 0.7, 0.2, 0.4, 1.5) * 1e-4;
    let shapes = field(&mesh, |p| gradient * p.coords);
    let material = Material::isotropic(E, NU, 8000.0).unwrap();
    let strain = Vector6::new(1.0, -3.0, 1.5, 1.1, -0.8, 2.5) * 1e-4;
    let expected = material.stiffness() * strain;
    let point = mesh.nodes[mesh.element(5).nodes[0]] + Vector3::new(0.03, 0.01, 0.01);
    let found = stress_at(&mesh, &[material], &shapes, point).unwrap();
    assert!((found.column(0) - expected).norm() < 1e-9 * expected.norm(), "{found}");
}

#[test]
fn pure_bending_has_the_stress_of_the_beam() {
    let mesh = bar([4, 2, 2]);
    // Exact for a bar bent to the curvature k: u = -k x z, w = k (x^2 + nu (z^2 - y^2)) / 2, v = nu k y z.
    let k = 1e-3;
    let shapes = field(&mesh, |p| {
        let w = 0.5 * k * (p.x * p.x + NU * (p.z * p.z - p.y * p.y));
        Vector3::new(-k * p.x * p.z, NU * k * p.y * p.z, w)
    });
    let material = Material::isotropic(E, NU, 8000.0).unwrap();
    let found = stress_at(&mesh, &[material], &shapes, Point3::new(0.4, 0.03, 0.05)).unwrap();
    assert!((found[0] / (-E * k * 0.05) - 1.0).abs() < 1e-9, "{found}");
    assert!(found.rows(1, 5).amax() < 1e-9 * found[0].abs(), "{found}");
}
