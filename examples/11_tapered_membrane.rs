//! First mode of a tapered membrane compared with NAFEMS FV32, 44.623 Hz: `cargo run --release --example
//! 11_tapered_membrane`.

use nailnoise_fem::{Constraints, Material, ModalSettings, assemble, modes};
use nailnoise_meshes::{Block, block};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // 10 m long, 5 m high at its clamped root and 1 m at its tip; half of the 50 mm thickness, above the midplane.
    let size = [10.0, 5.0, 0.025];
    let mut mesh = block(&Block {
        size,
        divisions: [16, 8, 1],
        origin: [0.0, -2.5, 0.0],
    })?;
    mesh.nodes.iter_mut().for_each(|node| node.y *= 1.0 - 0.08 * node.x);
    let mut constraints = Constraints::free();
    for (node, p) in mesh.nodes.iter().enumerate() {
        if p.x.abs() < 1e-9 {
            [0, 1].iter().for_each(|&axis| constraints.hold(node, axis));
        }
        if p.z.abs() < 1e-9 {
            constraints.hold(node, 2);
        }
    }
    let system = assemble(&mesh, &[Material::isotropic(200e9, 0.3, 8000.0)?], &constraints)?;
    let first = modes(&system, &ModalSettings::below(100.0), &|_, _| ())?.hz[0];
    println!("{first:.3} Hz, NAFEMS has 44.623 Hz");
    assert!((first / 44.623 - 1.0).abs() < 5e-3);
    Ok(())
}
