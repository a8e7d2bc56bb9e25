//! The surface of a block: area, volume, normals.
#![allow(clippy::unwrap_used)] // a test may panic, in its helpers too

use crate::common::{assert_sound, close};
use nailnoise_meshes::{Block, MeshError, Surface, block};
use nalgebra::Vector3;

const SIZE: [f64; 3] = [0.4064, 0.1524, 0.09525];

fn skin() -> Surface {
    let mesh = block(&Block {
        size: SIZE,
        divisions: [6, 3, 2],
        origin: [-0.1, 0.2, 0.3],
    });
    assert_sound(&mesh.unwrap())
}

#[test]
fn the_surface_has_the_area_and_the_volume_of_the_block() {
    let ([a, b, c], surface) = (SIZE, skin());
    close(surface.area(), 2.0 * (a * b + b * c + c * a), 1e-13);
    close(surface.volume(), a * b * c, 1e-13);
}

#[test]
fn each_patch_has_its_area_and_its_outward_normal() {
    let ([a, b, c], surface) = (SIZE, skin());
    let expected = [
        ("x_min", -Vector3::x(), b * c),
        ("x_max", Vector3::x(), b * c),
        ("y_min", -Vector3::y(), a * c),
        ("y_max", Vector3::y(), a * c),
        ("bottom", -Vector3::z(), a * b),
        ("top", Vector3::z(), a * b),
    ];
    for (name, normal, area) in expected {
        let patch = surface.patch(name).unwrap();
        close(surface.patch_area(patch), area, 1e-13);
        for q in surface
            .quadrature(2)
            .unwrap()
            .iter()
            .filter(|q| surface.faces[q.face].patch == patch)
        {
            assert!((q.normal - normal).norm() < 1e-13);
        }
    }
}

#[test]
fn an_unknown_patch_is_refused() {
    assert!(matches!(skin().patch("lid"), Err(MeshError::UnknownGroup { .. })));
}
