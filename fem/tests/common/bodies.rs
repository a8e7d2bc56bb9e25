//! Materials and bodies of the nailer's reference design, as test data.
#![allow(dead_code, unreachable_pub, reason = "each test file uses some of them")]
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use nailnoise_fem::{Constraints, Material, Orthotropic, System, assemble};
use nailnoise_meshes::{Block, Mesh, Worktable, block, worktable};
use nalgebra::{Matrix3, Vector3};

/// Pine, axes 1 = L, 2 = R, 3 = T.
pub const PINE: Orthotropic = Orthotropic {
    e1: 11.7e9,
    e2: 1.22e9,
    e3: 0.749e9,
    g12: 1.08e9,
    g13: 0.948e9,
    g23: 0.133e9,
    nu12: 0.33,
    nu13: 0.35,
    nu23: 0.43,
};

pub const PLYWOOD: Orthotropic = Orthotropic {
    e1: 8e9,
    e2: 6e9,
    e3: 0.7e9,
    g12: 0.7e9,
    g13: 0.2e9,
    g23: 0.15e9,
    nu12: 0.1,
    nu13: 0.3,
    nu23: 0.3,
};

/// Pine with x = L, y = T, z = R.
pub fn pine_block() -> Material {
    let axes = Matrix3::from_columns(&[Vector3::x(), Vector3::z(), Vector3::y()]);
    Material::orthotropic(&PINE, &axes, 429.46).unwrap()
}

/// Pine with the grain along z, x = T, y = R.
pub fn pine_leg() -> Material {
    let axes = Matrix3::from_columns(&[Vector3::z(), Vector3::y(), Vector3::x()]);
    Material::orthotropic(&PINE, &axes, 429.46).unwrap()
}

pub fn plywood() -> Material {
    Material::orthotropic(&PLYWOOD, &Matrix3::identity(), 600.0).unwrap()
}

pub fn workpiece(divisions: [usize; 3]) -> Mesh {
    block(&Block {
        size: [0.4064, 0.1524, 0.09525],
        divisions,
        origin: [0.0; 3],
    })
    .unwrap()
}

pub fn free_workpiece(divisions: [usize; 3]) -> System {
    assemble(&workpiece(divisions), &[pine_block()], &Constraints::free()).unwrap()
}

/// Worktable A.
pub fn table(element_size: f64) -> Mesh {
    worktable(&Worktable {
        top: [0.450, 0.400],
        thickness: 0.038,
        leg: [0.089, 0.089],
        height: 0.670,
        element_size,
        leg_element_size: element_size,
        top_layers: 2,
        origin: [0.0; 3],
    })
    .unwrap()
}

pub fn clamped_table(element_size: f64) -> System {
    let mesh = table(element_size);
    let feet = Constraints::clamped(&mesh, "floor").unwrap();
    assemble(&mesh, &[plywood(), pine_leg()], &feet).unwrap()
}
