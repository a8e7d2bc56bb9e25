//! First longitudinal mode of a free rod of 20-node elements compared with sqrt(E/rho)/(2 l): `cargo run --release
//! --example 10_rod`.

use nailnoise_fem::{Constraints, Material, ModalSettings, assemble, modes};
use nailnoise_meshes::{Block, block};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (length, e, rho): (f64, f64, f64) = (0.2, 210e9, 7850.0);
    let mesh = block(&Block {
        size: [length, 0.02, 0.02],
        divisions: [10, 1, 1],
        origin: [0.0; 3],
    })?;
    // Points of the rod move only along it, and with a Poisson's ratio of zero its cross-sections remain plane.
    let mut along = Constraints::free();
    for node in 0..mesh.nodes.len() {
        [1, 2].iter().for_each(|&axis| along.hold(node, axis));
    }
    let closed = (e / rho).sqrt() / (2.0 * length);
    let system = assemble(&mesh, &[Material::isotropic(e, 0.0, rho)?], &along)?;
    let basis = modes(&system, &ModalSettings::below(1.2 * closed), &|_, _| ())?;
    let found = basis.hz.iter().copied().find(|hz| (0.9..1.1).contains(&(hz / closed)));
    let found = found.ok_or("no mode near the closed form")?;
    println!("{found:.1} Hz, closed form {closed:.1} Hz");
    assert!((found / closed - 1.0).abs() < 1e-4);
    Ok(())
}
