//! Spheres against closed forms.
#![allow(clippy::unwrap_used)]

mod bem_common;

use bem_common::sphere;
use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::{Boundary, Exterior};
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

fn spheres(n: usize, quadratic: bool) -> (Exterior, DMatrix<f64>) {
    let boundary = Boundary::new(sphere(1.0, n, quadratic), None).unwrap();
    let v = boundary.project(2, |_, _, point, v| {
        v[0] = 1.0;
        v[1] = point.area_vector().normalize().z;
    });
    let problem = Exterior::new(boundary, &Air::default());
    (problem.with_panels_per_wavelength(1.0).unwrap(), v)
}

/// Relative errors of the power of the pulsating and the oscillating sphere, by the far field and by the surface.
fn errors(n: usize, quadratic: bool, ka: f64) -> [[f64; 2]; 2] {
    let air = Air::default();
    let (problem, v) = spheres(n, quadratic);
    let two = problem.resistance(ka * air.sound_speed / (2.0 * PI), &v).unwrap();
    let z = exact(ka);
    let error = |r: &DMatrix<f64>| {
        let areas = [4.0 * PI, 4.0 * PI / 3.0];
        [0, 1].map(|i| r[(i, i)] / (air.impedance() * areas[i] * z[i].re) - 1.0)
    };
    let result = [error(&two.far_field), error(&two.patches[0])];
    println!(
        "n {n} {quadratic} ka {ka}: {result:?} asymmetry {:.1e}",
        two.asymmetry
    );
    result
}

#[test]
fn quick() {
    for n in [2, 4] {
        for ka in [0.1, 1.0, 3.0] {
            errors(n, true, ka);
        }
    }
    errors(4, false, 1.0);
    for ka in [
        0.1,
        0.5,
        1.0,
        3.141592653589793,
        4.493409457909064,
        5.0,
        10.0,
        15.0,
        20.0,
    ] {
        errors(9, true, ka);
    }
}
