//! Meshes a block of 600 x 89 x 38 mm (a 2 x 4 of 24 in), takes its surface and writes both for ParaView and gmsh:
//! `cargo run -p nailnoise-meshes --example surface_of_a_block -- FOLDER`.

use std::path::PathBuf;

use nailnoise_meshes::msh::{self, Format};
use nailnoise_meshes::vtu::{Field, Grid};
use nailnoise_meshes::{Block, Surface, block};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).map_or_else(std::env::temp_dir, PathBuf::from);
    let size = [0.6, 0.089, 0.038];
    // Hexahedra of 20 nodes, no longer than 20 mm.
    let mesh = block(&Block::with_element_size(size, 0.02, [0.0; 3])?)?;
    let surface = Surface::of(&mesh);

    let [x, y, z] = size;
    let exact = 2.0 * (x * y + y * z + z * x);
    println!("{} elements, surface {:.6} m2", mesh.element_count(), surface.area());
    assert!((surface.area() / exact - 1.0).abs() < 1e-12);

    let height: Vec<f64> = surface.points.iter().map(|p| p.z).collect();
    let field = Field {
        name: "height [m]",
        components: 1,
        values: &height,
    };
    std::fs::write(
        folder.join("surface.vtu"),
        Grid::of_surface(&surface).to_bytes(&[field], &[])?,
    )?;
    std::fs::write(folder.join("block.vtu"), Grid::of_mesh(&mesh).to_bytes(&[], &[])?)?;
    std::fs::write(
        folder.join("block.msh"),
        msh::to_bytes(&mesh, Format::Text41, "a 2 x 4"),
    )?;
    Ok(())
}
