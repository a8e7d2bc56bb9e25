//! The compressed matrix against closed forms and against the dense matrix.
#![allow(clippy::unwrap_used)]

mod bem_common;

use bem_common::{cuboid, sphere};
use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::{Boundary, EquationSolver, Exterior, Parity, Patterns};
use nalgebra::DMatrix;

fn compressed(boundary: Boundary) -> Exterior {
    Exterior::new(boundary, &Air::default()).with_equation_solver(EquationSolver::Compressed)
}

/// Waves of various directions along the surface.
fn waves(boundary: &Boundary, patterns: usize, k: f64) -> DMatrix<f64> {
    boundary.project(patterns, |_, _, point, v| {
        let [x, y, z] = point.position.into();
        for (m, v) in v.iter_mut().enumerate() {
            let (sine, cosine) = (m as f64).sin_cos();
            *v = (k * (x * cosine + y * sine + 0.3 * z * m as f64 / patterns as f64)).cos();
        }
    })
}

/// Largest difference of a pattern's power by the far field, and of the pressure relative to the largest.
fn differences(dense: Exterior, hz: f64, v: &DMatrix<f64>) -> (f64, f64) {
    let exact = dense.solve(hz, v).unwrap();
    let r_exact = dense.far_field_resistance(v, &exact).unwrap();
    let compressed = dense.with_equation_solver(EquationSolver::Compressed);
    let found = compressed.solve(hz, v).unwrap();
    let r_found = compressed.far_field_resistance(v, &found).unwrap();
    let power = (0..v.ncols())
        .map(|m| (10.0 * (r_found[(m, m)] / r_exact[(m, m)]).log10()).abs())
        .fold(0.0, f64::max);
    let pressure = (&found.pressure - &exact.pressure).norm() / exact.pressure.norm();
    (power, pressure)
}

#[test]
fn a_box_above_the_floor_radiates_as_with_the_dense_matrix() {
    let c = Air::default().sound_speed;
    for (quads, low) in [(false, 0.1), (true, 0.1), (true, 0.0)] {
        let mesh = cuboid([0.0, 0.0, low], [0.5, 0.4, low + 0.3], 0.025, quads);
        let dense = Exterior::new(Boundary::new(mesh, Some(0.0)).unwrap(), &Air::default());
        let top = dense.estimate().highest_hz;
        for hz in [100.0, 0.5 * top, top] {
            let v = waves(dense.boundary(), 8, 2.0 * std::f64::consts::PI * hz / c);
            let mesh = cuboid([0.0, 0.0, low], [0.5, 0.4, low + 0.3], 0.025, quads);
            let dense = Exterior::new(Boundary::new(mesh, Some(0.0)).unwrap(), &Air::default());
            let (power, pressure) = differences(dense, hz, &v);
            println!("quads {quads}, {low} m, {hz:.0} Hz: {power:.1e} dB, pressure {pressure:.1e}");
            assert!(power < 0.01);
        }
    }
}
