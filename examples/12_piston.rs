//! Radiation resistance of a piston in a baffle compared with 1 - J_1(2 ka)/ka, 0.4233 at ka = 1: `cargo run --release
//! --example 12_piston`.

use std::f64::consts::TAU;

use nailnoise_acoustics::Air;
use nailnoise_acoustics::radiation::RadiatingSurface;
use nailnoise_acoustics::radiation::flush_with_sand::Rayleigh;
use nailnoise_meshes::gauss_legendre;
use nalgebra::{DMatrix, Point3, Vector3};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A unit disc: Gauss points in the radius, equal steps in angle.
    let (mut points, mut areas, around) = (Vec::new(), Vec::new(), 40);
    for (x, weight) in gauss_legendre(12) {
        let radius = 0.5 * (1.0 + x);
        for step in 0..around {
            let (sine, cosine) = (TAU * f64::from(step) / f64::from(around)).sin_cos();
            points.push(Point3::new(radius * cosine, radius * sine, 0.0));
            areas.push(0.5 * weight * radius * TAU / f64::from(around));
        }
    }
    let (count, air) = (points.len(), Air::default());
    let motion = DMatrix::from_element(count, 1, 1.0);
    let patches = vec!["piston".to_owned()];
    let surface = RadiatingSurface::new(
        points,
        vec![Vector3::z(); count],
        areas,
        vec![0; count],
        patches,
        motion,
    )?;
    let resistance = Rayleigh::new(&surface, &air)?.resistance(air.sound_speed / TAU);
    let resistance: f64 = resistance.iter().map(|patch| patch.real[(0, 0)]).sum();
    let found = resistance / (air.impedance() * 0.5 * TAU);
    println!("{found:.6}, closed form {:.6}", 1.0 - libm::j1(2.0));
    assert!((found - (1.0 - libm::j1(2.0))).abs() < 1e-6);
    Ok(())
}
