//! Spheres against closed forms.

use crate::boundary_meshes::{octants, sphere};
use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::{Boundary, BoundaryMesh, Exterior};
use nalgebra::{Complex, DMatrix};
use std::f64::consts::PI;

/// Specific impedances z_0 and z_1 of the pulsating and the oscillating sphere for e^{+j omega t}:
/// z_n = -j h_n(x)/h_n'(x) with h_n the spherical Hankel functions of the second kind.
fn exact(x: f64) -> [Complex<f64>; 2] {
    let j = Complex::<f64>::i();
    let z0 = j * x / (1.0 + j * x);
    let z1 = j * x * (1.0 + j * x) / (2.0 - x * x + 2.0 * j * x);
    [z0, z1]
}

/// The exterior of a unit sphere with a pulsating and a vertically oscillating pattern.
fn problem(mesh: BoundaryMesh, floor: Option<f64>) -> (Exterior, DMatrix<f64>) {
    let boundary = Boundary::new(mesh, floor).unwrap();
    let v = boundary.project(2, |_, _, point, v| {
        v[0] = 1.0;
        v[1] = point.area_vector().normalize().z;
    });
    let problem = Exterior::new(boundary, &Air::default());
    (problem.with_panels_per_wavelength(1.0).unwrap(), v)
}

/// Errors of the two powers relative to the exact ones, by the far field and by the surface.
fn errors((problem, v): &(Exterior, DMatrix<f64>), ka: f64) -> [[f64; 2]; 2] {
    let air = problem.air();
    let two = problem.resistance(ka * air.sound_speed / (2.0 * PI), v).unwrap();
    let z = exact(ka);
    let error = |r: &DMatrix<f64>| {
        let areas = [4.0 * PI, 4.0 * PI / 3.0];
        [0, 1].map(|i| r[(i, i)] / (air.impedance() * areas[i] * z[i].re) - 1.0)
    };
    assert!(two.asymmetry < 1e-6, "asymmetry {:e}", two.asymmetry);
    [error(&two.far_field), error(&two.patches[0])]
}

#[test]
fn pulsating_and_oscillating_sphere_from_ka_0_1_to_20() {
    let sphere = problem(sphere(1.0, 9, true), None);
    assert_eq!(sphere.0.boundary().mesh().panels.len(), 1620);
    // pi and 4.4934 are resonances of the inside.
    for (ka, limit) in [
        (0.1, 1e-4),
        (1.0, 1e-4),
        (PI, 1e-4),
        (4.493_409_457_909_064, 1e-4),
        (10.0, 2e-4),
        (20.0, 2e-3),
    ] {
        let [far, surface] = errors(&sphere, ka);
        println!("ka {ka:6.3}: far field {far:?}, surface {surface:?}");
        assert!(far[0].abs() < limit && far[1].abs() < limit, "ka {ka}: {far:?}");
        if ka == 1.0 {
            assert!(surface[0].abs() < 5e-4 && surface[1].abs() < 5e-4, "{surface:?}");
        }
    }
}

#[test]
fn reactance_is_the_mass_of_air_that_moves_along() {
    let (problem, v) = problem(sphere(1.0, 4, true), None);
    let air = *problem.air();
    for ka in [0.05, 1.0, 4.0] {
        let solution = problem.solve(ka * air.sound_speed / (2.0 * PI), &v).unwrap();
        let z = &problem.impedance(&v, &solution).unwrap()[0];
        for (i, area) in [4.0 * PI, 4.0 * PI / 3.0].into_iter().enumerate() {
            let exact = exact(ka)[i] * area * air.impedance();
            let error = (z[(i, i)] - exact).norm() / exact.norm();
            assert!(error < 1e-3, "ka {ka}, order {i}: {error:e}");
        }
    }
}

/// Least-squares slope of ln |error| over ln n.
fn order(errors: &[(usize, f64)]) -> f64 {
    let points: Vec<(f64, f64)> = errors.iter().map(|&(n, e)| ((n as f64).ln(), e.abs().ln())).collect();
    let count = points.len() as f64;
    let (mx, my) = points
        .iter()
        .fold((0.0, 0.0), |(a, b), p| (a + p.0 / count, b + p.1 / count));
    let (up, down) = points.iter().fold((0.0, 0.0), |(a, b), p| {
        (a + (p.0 - mx) * (p.1 - my), b + (p.0 - mx).powi(2))
    });
    -up / down
}

#[test]
fn power_converges_with_the_second_order_on_facets_and_the_fourth_on_curved_panels() {
    for (quadratic, expected, slack) in [(false, 2.0, 0.1), (true, 4.0, 0.5)] {
        let found: Vec<(usize, [f64; 2])> = [3, 4, 6, 8]
            .map(|n| (n, errors(&problem(sphere(1.0, n, quadratic), None), 1.0)[0]))
            .to_vec();
        for i in 0..2 {
            let series: Vec<(usize, f64)> = found.iter().map(|(n, e)| (*n, e[i])).collect();
            let order = order(&series);
            println!("quadratic {quadratic}, order {i}: {series:?} -> {order:.2}");
            assert!((order - expected).abs() < slack, "{order}");
        }
    }
}

#[test]
fn hemisphere_on_the_floor_is_half_a_sphere() {
    let half = octants(&[[1, 1, 1], [-1, 1, 1], [1, -1, 1], [-1, -1, 1]], 6, false);
    let (problem, v) = problem(half, Some(0.0));
    let air = *problem.air();
    for ka in [0.2, 1.0, PI] {
        let two = problem.resistance(ka * air.sound_speed / (2.0 * PI), &v).unwrap();
        let exact = air.impedance() * 2.0 * PI * exact(ka)[0].re;
        for r in [two.far_field[(0, 0)], two.patches[0][(0, 0)]] {
            assert!((r / exact - 1.0).abs() < 3e-4, "ka {ka}: {}", r / exact - 1.0);
        }
    }
}
