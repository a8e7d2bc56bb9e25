//! Blocks and their element sizes.
#![allow(clippy::unwrap_used)] // a test may panic, in its helpers too

mod common;

use common::close;
use nailnoise_meshes::{Block, MeshError, block, element_size};

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
