//! Sound power of a pulsating sphere, given as a triangle mesh, by boundary elements.
//!
//! Exact: W = rho c S v² (ka)²/(1 + (ka)²) for the rms velocity v.

use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::{Boundary, BoundaryMesh, Exterior, Panel};
use nailnoise_meshes::FaceKind;
use nalgebra::{DMatrix, Point3};
use std::f64::consts::PI;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Rings of 40 points around the z axis between two poles, with outward triangles.
    let (radius, rings, around) = (0.1, 19, 40);
    let mut points = vec![Point3::new(0.0, 0.0, radius)];
    for (ring, step) in (1..=rings).flat_map(|ring| (0..around).map(move |step| (ring, step))) {
        let (theta, phi) = (
            PI * f64::from(ring) / f64::from(rings + 1),
            2.0 * PI * f64::from(step) / f64::from(around),
        );
        points.push(Point3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()) * radius);
    }
    points.push(Point3::new(0.0, 0.0, -radius));
    let (last, at) = (points.len() - 1, |ring: i32, step: i32| {
        (1 + (ring - 1) * around + step % around) as usize
    });
    let mut triangles = Vec::new();
    for step in 0..around {
        triangles.push([0, at(1, step), at(1, step + 1)]);
        triangles.push([at(rings, step), last, at(rings, step + 1)]);
        for ring in 1..rings {
            triangles.push([at(ring, step), at(ring + 1, step), at(ring, step + 1)]);
            triangles.push([at(ring, step + 1), at(ring + 1, step), at(ring + 1, step + 1)]);
        }
    }
    let panels = triangles
        .iter()
        .filter_map(|nodes| Panel::new(FaceKind::Tri3, nodes, 0))
        .collect();
    let patches = vec!["sphere".to_owned()];
    let air = Air::default();
    let exterior = Exterior::new(
        Boundary::new(
            BoundaryMesh {
                points,
                panels,
                patches,
            },
            None,
        )?,
        &air,
    );

    // One pattern of normal velocities: 1 m/s everywhere.
    let velocity = DMatrix::from_element(exterior.boundary().velocity_values(), 1, 1.0);
    let (hz, ka) = (air.sound_speed / (2.0 * PI * radius), 1.0);
    let power = exterior.resistance(hz, &velocity)?.far_field[(0, 0)];
    let exact = air.impedance() * 4.0 * PI * radius * radius * ka * ka / (1.0 + ka * ka);
    println!("{hz:.0} Hz: {power:.3} W, exact {exact:.3} W");
    assert!((power / exact - 1.0).abs() < 0.02, "the facets cost less than 2 %");
    Ok(())
}
