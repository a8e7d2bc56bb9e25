//! Worktables on hollow legs.
#![allow(clippy::unwrap_used)] // a test may panic, in its helpers too

use crate::common::{area, close};
use nailnoise_meshes::{Mesh, Worktable, tube_worktable};

const SPEC: Worktable = Worktable {
    top: [0.45, 0.4],
    thickness: 0.006,
    leg: [0.05; 2],
    height: 0.67,
    element_size: 0.03,
    leg_element_size: 0.03,
    top_layers: 2,
    origin: [-0.225, -0.2, -0.67],
};

/// Cross-section of a leg \[m2\]: 50 mm square with walls of 2 mm.
const RING: f64 = 0.05 * 0.05 - 0.046 * 0.046;

fn table() -> Mesh {
    tube_worktable(&SPEC, 0.002).unwrap()
}

#[test]
fn plate_and_legs_are_five_closed_pieces() {
    let quality = table().quality().unwrap();
    assert_eq!((quality.inverted, quality.open_edges, quality.pieces), (0, 0, 5));
}

#[test]
fn plate_and_legs_have_their_volumes() {
    let mesh = table();
    assert_eq!(mesh.part_names, ["top", "leg"]);
    let volumes = mesh.part_volumes().unwrap();
    close(volumes[0], 0.45 * 0.4 * 0.006, 1e-12);
    close(volumes[1], 4.0 * RING * 0.664, 1e-12);
}

#[test]
fn named_groups_have_their_areas() {
    let mesh = table();
    for (group, expected) in [
        ("top", 0.45 * 0.4),
        ("weld_master", 0.45 * 0.4),
        ("weld_slave", 4.0 * RING),
        ("floor", 4.0 * RING),
        ("sides", 2.0 * (0.45 + 0.4) * 0.006),
        ("leg_sides", 4.0 * 4.0 * (0.05 + 0.046) * 0.664),
    ] {
        close(area(&mesh, group), expected, 1e-12);
    }
}

#[test]
fn the_legs_touch_the_underside_of_the_plate() {
    let mesh = table();
    for node in mesh.group_nodes("weld_slave").unwrap() {
        assert!((mesh.nodes[node].z + 0.006).abs() < 1e-15);
    }
}

#[test]
fn a_wall_thicker_than_half_a_leg_or_negative_is_refused() {
    assert!(
        tube_worktable(&SPEC, 0.025)
            .unwrap_err()
            .to_string()
            .contains("two walls")
    );
    assert!(tube_worktable(&SPEC, -0.002).is_err());
}
