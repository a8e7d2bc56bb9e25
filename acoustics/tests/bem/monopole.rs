//! A point source inside a body: the body's surface, moving as the field around the source does, radiates its power.

use crate::boundary_meshes::{cuboid, monopole_slope, octants};
use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::{Boundary, Exterior};
use nalgebra::{Complex, DMatrix, Point3};
use std::f64::consts::PI;

/// Errors in dB of the power by the far field and by the surface.
///
/// p = G(x, s) + G(x, s') radiates (1 + sin(2kh)/(2kh)) / (8 pi rho c) into the half space, h the source's height.
fn errors(problem: &Exterior, source: Point3<f64>, hz: f64) -> [f64; 2] {
    let (air, boundary) = (*problem.air(), problem.boundary());
    let omega = 2.0 * PI * hz;
    let k = omega / air.sound_speed;
    // v = -1/(j omega rho) dp/dn as a real and an imaginary pattern.
    let v = boundary.project(2, |_, _, point, v| {
        let normal = point.area_vector().normalize();
        let mut slope = monopole_slope(k, source, point.position, normal);
        if let Some(z) = boundary.floor() {
            let image = Point3::new(source.x, source.y, 2.0 * z - source.z);
            slope += monopole_slope(k, image, point.position, normal);
        }
        let velocity = -slope / Complex::new(0.0, omega * air.density);
        (v[0], v[1]) = (velocity.re, velocity.im);
    });
    let two = problem.resistance(hz, &v).unwrap();
    let kh = boundary.floor().map_or(f64::INFINITY, |z| 2.0 * k * (source.z - z));
    let exact = (1.0 + if kh.is_finite() { kh.sin() / kh } else { 0.0 }) / (8.0 * PI * air.impedance());
    let power = |r: &DMatrix<f64>| 10.0 * (0.5 * (r[(0, 0)] + r[(1, 1)]) / exact).log10();
    let surface = two.patches.iter().fold(DMatrix::zeros(2, 2), |sum, p| sum + p);
    [power(&two.far_field), power(&surface)]
}

/// The field around the body is that of the point source and its image, in magnitude and phase.
#[test]
fn the_pressure_at_points_is_that_of_the_source() {
    let lift = 0.3;
    let mesh = cuboid([-0.2, -0.15, lift], [0.2, 0.15, lift + 0.26], 0.04, true);
    let problem = Exterior::new(Boundary::new(mesh, Some(0.0)).unwrap(), &Air::default());
    let (air, source) = (*problem.air(), Point3::new(0.03, -0.02, lift + 0.11));
    let image = Point3::new(source.x, source.y, -source.z);
    let points = [
        Point3::new(1.0, 0.0, 0.8),
        Point3::new(-1.0, -1.0, 1.6),
        Point3::new(0.0, 0.0, 1.6),
        Point3::new(0.3, 0.1, 0.0),
    ];
    for hz in [150.0, 572.0, 1400.0] {
        let omega = 2.0 * PI * hz;
        let k = omega / air.sound_speed;
        let v = problem.boundary().project(2, |_, _, point, v| {
            let normal = point.area_vector().normalize();
            let slope =
                monopole_slope(k, source, point.position, normal) + monopole_slope(k, image, point.position, normal);
            let velocity = -slope / Complex::new(0.0, omega * air.density);
            (v[0], v[1]) = (velocity.re, velocity.im);
        });
        let solution = problem.solve(hz, &v).unwrap();
        let parts = problem.pressure_at(&points, &v, &solution).unwrap();
        let wave = |r: f64| Complex::from_polar(1.0 / (4.0 * PI * r), -k * r);
        for (i, point) in points.iter().enumerate() {
            let exact = [source, image].map(|from| wave((point - from).norm()));
            let found = [0, 1].map(|path| parts[path][(i, 0)] + Complex::<f64>::i() * parts[path][(i, 1)]);
            let error = (found[0] + found[1] - exact[0] - exact[1]).norm() / exact[0].norm();
            println!("{hz} Hz, point {i}: {error:.1e}");
            assert!(error < 1e-2, "{hz} Hz, point {i}: {error:e}");
        }
    }
    let v = DMatrix::zeros(problem.boundary().velocity_values(), 1);
    let solution = problem.solve(200.0, &v).unwrap();
    let refused = |point| problem.pressure_at(&[point], &v, &solution).unwrap_err().to_string();
    assert!(refused(Point3::new(1.0, 0.0, -0.1)).contains("below the floor"));
    assert!(refused(Point3::new(0.21, 0.0, 0.4)).contains("the longest edge of a panel"));
}

/// Frequencies from 100 Hz to the mesh's highest, with the inner resonances of a box among them.
fn sweep(sides: [f64; 3], highest: f64) -> Vec<f64> {
    let mut sweep: Vec<f64> = (0..6)
        .map(|i| 100.0 * (highest / 100.0).powf(f64::from(i) / 5.0))
        .collect();
    let c = Air::default().sound_speed;
    for m in 1..4 {
        for n in 1..3 {
            for l in 1..3 {
                let orders = [m, n, l].map(f64::from);
                let sum: f64 = orders.iter().zip(sides).map(|(m, a)| (m / a).powi(2)).sum();
                let hz = 0.5 * c * sum.sqrt();
                if hz < highest {
                    sweep.push(hz);
                }
            }
        }
    }
    sweep
}

fn check(quads: bool, lift: f64) {
    let (low, high) = ([-0.2, -0.15, lift], [0.2, 0.15, lift + 0.26]);
    let mesh = cuboid(low, high, 0.04, quads);
    let problem = Exterior::new(Boundary::new(mesh, Some(0.0)).unwrap(), &Air::default());
    let highest = problem.estimate().highest_hz;
    let frequencies = sweep([0.4, 0.3, 0.26], highest);
    assert!(frequencies.iter().any(|&hz| hz > problem.estimate().irregular_hz));
    for hz in frequencies {
        let [far, surface] = errors(&problem, Point3::new(0.03, -0.02, lift + 0.11), hz);
        println!("quads {quads}, {lift} m, {hz:6.1} Hz: {far:7.4} {surface:7.4} dB");
        assert!(far.abs() < 0.1 && surface.abs() < 0.1, "{hz} Hz: {far} {surface} dB");
    }
}

#[test]
fn in_a_box_above_the_floor() {
    check(true, 0.3);
    check(false, 0.05);
}

#[test]
fn in_a_box_on_the_floor() {
    check(true, 0.0);
    check(false, 0.0);
}

#[test]
fn in_a_cats_eye() {
    let all = [1, -1].map(|x| [1, -1].map(|y| [1, -1].map(|z| [x, y, z])));
    let seven: Vec<[i32; 3]> = all
        .into_iter()
        .flatten()
        .flatten()
        .filter(|&s| s != [1, 1, 1])
        .collect();
    let c = Air::default().sound_speed;
    for n in [5, 7] {
        let mesh = octants(&seven, n, true);
        let problem = Exterior::new(Boundary::new(mesh, None).unwrap(), &Air::default());
        let problem = problem.with_panels_per_wavelength(2.5).unwrap();
        for ka in [0.5, PI, 4.493_409_457_909_064] {
            let [far, surface] = errors(&problem, Point3::new(-0.2, -0.3, -0.1), ka * c / (2.0 * PI));
            println!("n {n}, ka {ka:.3}: {far:7.4} {surface:7.4} dB");
            assert!(far.abs() < 0.05 && surface.abs() < 0.05, "ka {ka}: {far} {surface} dB");
        }
    }
}
