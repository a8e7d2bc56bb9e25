//! Thin-walled and layered structures by 20-node solid elements.

use std::f64::consts::FRAC_PI_2;

use nailnoise_fem::{Constraints, Material, ModalSettings, Orthotropic, assemble, modes};
use nailnoise_meshes::{Block, Grid, Mesh, block};
use nalgebra::{Matrix3, Point3, Rotation3, Vector3};

use super::plates::frequencies;
use super::row::{Case, Row};
use crate::error::Error;

const FV32: Case = Case {
    name: "NAFEMS FV32, tapered membrane",
    source: "NAFEMS FV32, in plane, root clamped, plane stress",
};
const CYLINDER: Case = Case {
    name: "clamped cylinder, torsion",
    source: "c_s/(2 L), closed form",
};
const TWO_WAVES: Case = Case {
    name: "clamped cylinder, two waves around",
    source: "R 0.1 m, L 0.4 m, wall 10 mm; value passed on without its source",
};
const BOX: Case = Case {
    name: "cantilevered double-cell box",
    source: "Fan and Luah, J. Sound Vib. 179 (1995) 763",
};
const COMPOSITE: Case = Case {
    name: "cantilevered graphite-epoxy plate",
    source: "NASA Lewis, measured by laser holography",
};

/// Mean radius, length and wall of the cylinder \[m\]; Young's modulus \[Pa\], Poisson's ratio, density \[kg/m³\].
const RADIUS: f64 = 0.1;
const LENGTH: f64 = 0.4;
const WALL: f64 = 0.01;
const CYLINDER_MATERIAL: [f64; 3] = [200e9, 0.3, 7800.0];

/// Whether a coordinate is zero but for rounding.
fn is_zero(c: f64) -> bool {
    c.abs() < 1e-9
}

/// A membrane 10 m long, 5 m high at its root and 1 m at its tip, 0.05 m thick. Half its thickness is meshed, above the
/// midplane, which stays plane.
pub(super) fn membrane() -> Result<Vec<Row>, Error> {
    let [length, root, tip, thickness] = [10.0, 5.0, 1.0, 0.05];
    let mut mesh = block(&Block {
        size: [length, root, 0.5 * thickness],
        divisions: [16, 8, 1],
        origin: [0.0, -0.5 * root, 0.0],
    })?;
    for node in &mut mesh.nodes {
        node.y *= 1.0 - (1.0 - tip / root) * node.x / length;
    }
    let mut constraints = Constraints::free();
    for (node, p) in mesh.nodes.iter().enumerate() {
        if is_zero(p.x) {
            [0, 1].iter().for_each(|&axis| constraints.hold(node, axis));
        }
        if is_zero(p.z) {
            constraints.hold(node, 2);
        }
    }
    let system = assemble(&mesh, &[Material::isotropic(200e9, 0.3, 8000.0)?], &constraints)?;
    let basis = modes(&system, &ModalSettings::below(400.0), &|_, _| ())?;
    let reference = [44.623, 130.03, 162.70, 246.05, 379.90, 391.44];
    Ok(frequencies(FV32, &basis, &reference, 5e-3))
}

/// Symmetry of a motion about the planes x = 0 and y = 0.
#[derive(Clone, Copy, PartialEq)]
enum Symmetry {
    /// Points of a plane stay in it: an even number of waves around.
    Even,
    /// Points of a plane leave it along its normal: torsion.
    Odd,
}

/// Frequencies \[Hz\] of the modes of one symmetry of a cylinder of mean radius 0.1 m, length 0.4 m and wall 10 mm,
/// clamped at both ends, by a quarter of it.
fn cylinder_modes(symmetry: Symmetry, below_hz: f64) -> Result<Vec<f64>, Error> {
    let mut mesh = block(&Block {
        size: [WALL, FRAC_PI_2, LENGTH],
        divisions: [1, 6, 12],
        origin: [RADIUS - 0.5 * WALL, 0.0, 0.0],
    })?;
    for node in &mut mesh.nodes {
        *node = Point3::new(node.x * node.y.cos(), node.x * node.y.sin(), node.z);
    }
    let mut constraints = Constraints::free();
    for (node, p) in mesh.nodes.iter().enumerate() {
        let ends = is_zero(p.z) || is_zero(p.z - LENGTH);
        let [in_x, in_y] = [is_zero(p.x), is_zero(p.y)];
        let held = match symmetry {
            Symmetry::Even => [in_x, in_y, false],
            Symmetry::Odd => [in_y, in_x, in_x || in_y],
        };
        (0..3)
            .filter(|&axis| ends || held[axis])
            .for_each(|axis| constraints.hold(node, axis));
    }
    let [e, nu, rho] = CYLINDER_MATERIAL;
    let system = assemble(&mesh, &[Material::isotropic(e, nu, rho)?], &constraints)?;
    Ok(modes(&system, &ModalSettings::below(below_hz), &|_, _| ())?.hz)
}

/// The torsion and the lowest mode with two waves around of a clamped cylinder.
pub(super) fn cylinder() -> Result<Vec<Row>, Error> {
    let [e, nu, rho] = CYLINDER_MATERIAL;
    let exact = (e / (2.0 * (1.0 + nu)) / rho).sqrt() / (2.0 * LENGTH);
    let odd = cylinder_modes(Symmetry::Odd, 4500.0)?;
    let nearest = odd
        .into_iter()
        .min_by(|a, b| (a - exact).abs().total_cmp(&(b - exact).abs()));
    let lowest = cylinder_modes(Symmetry::Even, 2500.0)?.first().copied();
    let torsion = CYLINDER.row("torsion, Hz", exact, nearest.unwrap_or(f64::NAN));
    let two_waves = TWO_WAVES.row("lowest mode, Hz", 1701.0, lowest.unwrap_or(f64::NAN));
    Ok(vec![torsion.within_part(1e-3), two_waves.within_part(2e-2)])
}

/// Lines of a grid across cells between walls of a thickness about equidistant middles; `parts` elements a cell.
fn lines(cells: usize, pitch: f64, wall: f64, parts: usize) -> Vec<f64> {
    let clear = pitch - wall;
    let cell = |c: usize| {
        let from = c as f64 * pitch + 0.5 * wall;
        (0..=parts).map(move |i| from + clear * i as f64 / parts as f64)
    };
    let ends = [-0.5 * wall, cells as f64 * pitch + 0.5 * wall];
    let mut lines: Vec<f64> = (0..cells).flat_map(cell).chain(ends).collect();
    lines.sort_by(f64::total_cmp);
    lines
}

/// Two square cells of 1.27 m side by side, 2.54 m long, walls of 12.7 mm, clamped at one end.
pub(super) fn double_cell_box() -> Result<Vec<Row>, Error> {
    let [pitch, length, wall] = [1.27, 2.54, 0.0127];
    let parts = 10;
    let along = (0..=16).map(|i| length * f64::from(i) / 16.0).collect();
    let grid = Grid::new(along, lines(2, pitch, wall, parts), lines(1, pitch, wall, parts))?;
    // A wall lies before, between and behind the cells.
    let in_wall = |index: usize| index.is_multiple_of(parts + 1);
    let mesh = grid.mesh(
        &["box"],
        |[_, y, z]| (in_wall(y) || in_wall(z)).then_some(0),
        |_, axis, upper, _| if axis == 0 && !upper { "root" } else { "rest" },
    );
    let system = assemble(
        &mesh,
        &[Material::isotropic(207e9, 0.3, 7850.0)?],
        &Constraints::clamped(&mesh, "root")?,
    )?;
    let basis = modes(&system, &ModalSettings::below(30.0), &|_, _| ())?;
    Ok(frequencies(BOX, &basis, &[20.28, 25.43], 2e-2))
}

/// Angles of the plies of one half of the laminate, from its face \[degrees\].
const PLIES: [f64; 10] = [22.5, -22.5, 0.0, 0.0, -22.5, 0.0, 0.0, 22.5, 0.0, 0.0];

/// A layer of elements a ply, transversely isotropic about its fibres.
pub(super) fn composite() -> Result<Vec<Row>, Error> {
    let [length, width, thickness] = [228.6e-3, 76.2e-3, 2.54e-3];
    let mut mesh: Mesh = block(&Block {
        size: [length, width, thickness],
        divisions: [12, 4, 2 * PLIES.len()],
        origin: [0.0; 3],
    })?;
    let angles = [22.5, -22.5, 0.0];
    mesh.part_names = angles.map(|angle| format!("{angle} degrees")).into();
    let layer = mesh.element_count() / (2 * PLIES.len());
    for (element, part) in mesh.parts.iter_mut().enumerate() {
        let ply = element / layer;
        let angle = PLIES[ply.min(2 * PLIES.len() - 1 - ply)];
        *part = angles.iter().position(|own| *own == angle).unwrap_or(0);
    }
    let [e1, e2, g12, nu12, nu23] = [154.65e9, 9.997e9, 6.322e9, 0.25, 0.4];
    let constants = Orthotropic {
        e1,
        e2,
        e3: e2,
        g12,
        g13: g12,
        g23: e2 / (2.0 * (1.0 + nu23)),
        nu12,
        nu13: nu12,
        nu23,
    };
    let materials = angles.map(|angle| {
        let axes: Matrix3<f64> = *Rotation3::from_axis_angle(&Vector3::z_axis(), f64::to_radians(angle)).matrix();
        Material::orthotropic(&constants, &axes, 1600.2)
    });
    let materials = materials.into_iter().collect::<Result<Vec<_>, _>>()?;
    let system = assemble(&mesh, &materials, &Constraints::clamped(&mesh, "x_min")?)?;
    let basis = modes(&system, &ModalSettings::below(500.0), &|_, _| ())?;
    Ok(frequencies(COMPOSITE, &basis, &[69.0, 270.0, 427.0], 5e-2))
}
