//! Solves the NAFEMS benchmarks FV41 (a quarter of a free cylinder) and FV22 (clamped thick rhombic plate) on 20-node
//! hexahedra, and writes the same meshes for CalculiX: `cargo run --release -p nailnoise-fem --example nafems --
//! FOLDER`.
//!
//! For each benchmark, `FOLDER/NAME.inp` is the input of CalculiX and `FOLDER/NAME.csv` contains our frequencies in Hz;
//! `tests/peers/calculix.py` runs CalculiX and compares.

#[path = "../tests/common/kinds.rs"]
mod kinds;

use std::f64::consts::FRAC_PI_2;
use std::fmt::Write;
use std::path::Path;

use kinds::structured;
use nailnoise_fem::{Constraints, Material, ModalSettings, assemble, modes};
use nailnoise_meshes::{ElementKind, Mesh};
use nalgebra::Point3;

/// Young's modulus \[Pa\], Poisson ratio and density \[kg/m^3\] of both benchmarks.
const STEEL: (f64, f64, f64) = (200e9, 0.3, 8000.0);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).ok_or("name a folder for the files")?;
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder)?;
    // Length 10 m, mean radius 2 m, wall 0.4 m; r comes first, so that elements are right-handed.
    let cylinder = structured(ElementKind::Hex20, [2, 8, 16], |[r, t, z]| {
        let (radius, angle) = (1.8 + 0.4 * r, FRAC_PI_2 * t);
        Point3::new(radius * angle.cos(), radius * angle.sin(), 10.0 * z)
    });
    let symmetry = |p: &Point3<f64>| [p.x.abs() < 1e-9, p.y.abs() < 1e-9, false];
    solve(folder, "fv41", &cylinder, symmetry, 420.0)?;
    // Sides of 10 m at 45 degrees, thickness 1 m.
    let leg = 10.0 * 0.5f64.sqrt();
    let plate = structured(ElementKind::Hex20, [12, 12, 2], |[a, b, c]| {
        Point3::new(10.0 * a + leg * b, leg * b, c)
    });
    let edges = |p: &Point3<f64>| {
        let b = p.y / leg;
        let a = (p.x - p.y) / 10.0;
        [a.min(b).min(1.0 - a).min(1.0 - b) < 1e-9; 3]
    };
    solve(folder, "fv22", &plate, edges, 400.0)?;
    Ok(())
}

fn solve(
    folder: &Path,
    name: &str,
    mesh: &Mesh,
    held: impl Fn(&Point3<f64>) -> [bool; 3],
    top_hz: f64,
) -> Result<(), Box<dyn std::error::Error>> {
    let (e, nu, rho) = STEEL;
    let mut constraints = Constraints::free();
    let mut boundary = String::new();
    for (node, p) in mesh.nodes.iter().enumerate() {
        for axis in (0..3).filter(|&k| held(p)[k]) {
            constraints.hold(node, axis);
            writeln!(boundary, "{}, {}, {}", node + 1, axis + 1, axis + 1)?;
        }
    }
    let system = assemble(mesh, &[Material::isotropic(e, nu, rho)?], &constraints)?;
    let basis = modes(&system, &ModalSettings::below(top_hz), &|_, _| ())?;
    let mut input = String::from("*NODE, NSET=NALL\n");
    for (node, p) in mesh.nodes.iter().enumerate() {
        writeln!(input, "{}, {:.12e}, {:.12e}, {:.12e}", node + 1, p.x, p.y, p.z)?;
    }
    input.push_str("*ELEMENT, TYPE=C3D20, ELSET=ALL\n");
    for (number, element) in mesh.elements().enumerate() {
        let nodes: Vec<String> = element.nodes.iter().map(|n| (n + 1).to_string()).collect();
        // A line may contain at most sixteen entries.
        writeln!(
            input,
            "{}, {},\n{}",
            number + 1,
            nodes[..10].join(", "),
            nodes[10..].join(", ")
        )?;
    }
    write!(
        input,
        "*MATERIAL, NAME=STEEL\n*ELASTIC\n{e:e}, {nu}\n*DENSITY\n{rho}\n*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL\n\
         *BOUNDARY\n{boundary}*STEP\n*FREQUENCY\n{}\n*END STEP\n",
        basis.hz.len()
    )?;
    std::fs::write(folder.join(format!("{name}.inp")), input)?;
    let hz: Vec<String> = basis.hz.iter().map(|f| format!("{f:.6}")).collect();
    std::fs::write(folder.join(format!("{name}.csv")), hz.join("\n"))?;
    println!(
        "{name}: {} dofs, {} modes below {top_hz} Hz",
        basis.dofs,
        basis.hz.len()
    );
    Ok(())
}
