//! The lowest mode of a square steel plate clamped along one side, compared with plate theory.
//!
//! ```text
//! f = 3.492 / (2 pi a^2) sqrt(D / (rho h)),   D = E h^3 / (12 (1 - nu^2))
//! ```
//!
//! with nu = 0.3 (A. W. Leissa, *Vibration of Plates*, NASA SP-160, 1969, cantilever square plate):
//! `cargo run --release -p nailnoise-fem --example modes_of_a_plate`.

use std::f64::consts::TAU;

use nailnoise_fem::{Constraints, Material, ModalSettings, assemble, modes};
use nailnoise_meshes::{Block, block};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (a, h) = (0.3, 0.003);
    let (e, nu, rho) = (207e9, 0.3, 7850.0);
    let mesh = block(&Block {
        size: [a, a, h],
        divisions: [12, 12, 1],
        origin: [0.0; 3],
    })?;
    let steel = Material::isotropic(e, nu, rho)?;
    let system = assemble(&mesh, &[steel], &Constraints::clamped(&mesh, "x_min")?)?;
    let basis = modes(&system, &ModalSettings::below(500.0), &|_, _| ())?;
    println!("{} modes below 500 Hz: {:.1?}", basis.hz.len(), basis.hz);

    let stiffness = e * h.powi(3) / (12.0 * (1.0 - nu * nu));
    let expected = 3.492 / (TAU * a * a) * (stiffness / (rho * h)).sqrt();
    println!("lowest mode {:.2} Hz, plate theory {expected:.2} Hz", basis.hz[0]);
    assert!((basis.hz[0] / expected - 1.0).abs() < 0.01);
    Ok(())
}
