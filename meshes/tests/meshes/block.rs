//! Blocks and their element sizes.
#![allow(clippy::unwrap_used)] // a test may panic, in its helpers too

use crate::common::close;
use nailnoise_meshes::{Block, JOINT, MeshError, Surface, block, element_size, jointed_block};

#[test]
fn the_element_size_is_a_third_of_the_shortest_wavelength() {
    // 557 m/s at 10 kHz is 56 mm; three elements a wavelength are below 20 mm.
    close(element_size(10e3, 557.0, 3.0).unwrap(), 0.018567, 1e-4);
    assert!(element_size(0.0, 557.0, 3.0).is_err());
}

#[test]
fn a_block_is_divided_by_the_element_size() {
    let spec = Block::with_element_size([0.4064, 0.1524, 0.09525], 0.018567, [0.0; 3]).unwrap();
    assert_eq!(spec.divisions, [22, 9, 6]);
}

#[test]
fn a_block_without_thickness_or_elements_is_refused() {
    let flat = Block {
        size: [1.0, 1.0, 0.0],
        divisions: [1; 3],
        origin: [0.0; 3],
    };
    assert!(matches!(block(&flat), Err(MeshError::Dimension { .. })));
    let none = Block {
        size: [1.0; 3],
        divisions: [1, 0, 1],
        origin: [0.0; 3],
    };
    assert!(matches!(block(&none), Err(MeshError::NoElements { .. })));
}

#[test]
fn two_pieces_touch_on_all_of_their_joint_and_share_no_node() {
    let (size, height) = ([0.4, 0.15, 0.09], 0.05);
    let mesh = jointed_block(size, 0.03, [-0.2, -0.075, 0.0], height).unwrap();
    assert_eq!(mesh.pieces(), 2);
    let volumes = mesh.part_volumes().unwrap();
    for (volume, thickness) in volumes.into_iter().zip([height, size[2] - height]) {
        close(volume, size[0] * size[1] * thickness, 1e-12);
    }
    let surface = Surface::of(&mesh);
    let points = surface.quadrature(2).unwrap();
    for (group, outward) in JOINT.into_iter().zip([1.0, -1.0]) {
        let patch = surface.patch(group).unwrap();
        let on_patch = points.iter().filter(|point| surface.faces[point.face].patch == patch);
        let (area, z, normal) = on_patch.fold((0.0, 0.0, 0.0), |(area, z, normal), point| {
            let weight = point.weight;
            (
                area + weight,
                z + weight * point.position.z,
                normal + weight * point.normal.z,
            )
        });
        close(area, size[0] * size[1], 1e-12);
        close(z / area, height, 1e-12);
        close(normal / area, outward, 1e-12);
    }
}

#[test]
fn a_joint_outside_the_block_is_refused() {
    for height in [0.0, 0.09, 0.1, -0.01] {
        let mesh = jointed_block([0.4, 0.15, 0.09], 0.03, [0.0; 3], height);
        assert!(matches!(mesh, Err(MeshError::Dimension { .. })), "{height}");
    }
}
