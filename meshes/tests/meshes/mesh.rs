//! Meshes that are changed after meshing: straightened and joined.
#![allow(clippy::unwrap_used)] // a test may panic, in its helpers too

use crate::common::close;
use nailnoise_meshes::{Block, block};

#[test]
fn straightening_restores_folded_elements_and_keeps_straight_ones() {
    let straight = block(&Block {
        size: [1.0, 1.0, 1.0],
        divisions: [2, 1, 1],
        origin: [0.0; 3],
    })
    .unwrap();
    let mut mesh = straight.clone();
    assert_eq!(mesh.straighten(), 0);
    let middle = mesh.connectivity[8];
    mesh.nodes[middle].y += 2.0;
    mesh.nodes[middle].z += 2.0;
    assert!(mesh.quality().unwrap().inverted > 0);
    assert!(mesh.straighten() > 0);
    let off = mesh.nodes.iter().zip(&straight.nodes).map(|(a, b)| (a - b).norm());
    assert!(off.fold(0.0, f64::max) < 1e-15);
}

#[test]
fn joined_meshes_keep_their_elements_and_share_part_names() {
    let one = block(&Block {
        size: [1.0, 1.0, 1.0],
        divisions: [1, 1, 1],
        origin: [0.0; 3],
    })
    .unwrap();
    let mut two = one.clone();
    two.nodes.iter_mut().for_each(|p| p.x += 3.0);
    let mut both = one.clone();
    both.join(&two);
    assert_eq!(both.part_names, one.part_names);
    assert_eq!(both.group("top").unwrap().faces.len(), 2);
    let quality = both.quality().unwrap();
    assert_eq!((quality.pieces, quality.open_edges), (2, 0));
    close(quality.volume, 2.0, 1e-12);
}
