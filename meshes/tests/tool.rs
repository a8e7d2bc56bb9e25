//! The tool body that ships, the steel table, and elements that a mesher has folded.
#![allow(clippy::unwrap_used)] // a test may panic, in its helpers too

use std::f64::consts::PI;

use nailnoise_meshes::{Block, Mesh, Surface, Tool, Worktable, block, tool, tube_worktable};

const MM: f64 = 1e-3;

/// The N80CB, as its design has it.
fn n80cb() -> Tool {
    Tool {
        barrel_radius: 37.0 * MM,
        barrel_wall: 4.5 * MM,
        barrel_height: 190.0 * MM,
        cap_radius: 46.0 * MM,
        cap_wall: 5.0 * MM,
        cap_height: 45.0 * MM,
        handle_radius: 20.0 * MM,
        handle_wall: 3.5 * MM,
        handle_length: 170.0 * MM,
        handle_level: 270.0 * MM,
        magazine_radius: 55.0 * MM,
        magazine_wall: 3.0 * MM,
        magazine_height: 70.0 * MM,
        magazine_offset: 75.0 * MM,
        magazine_level: 75.0 * MM,
        arm_depth: 12.0 * MM,
        arm_height: 30.0 * MM,
        arm_reach: 39.0 * MM,
        nose_width: 20.0 * MM,
        nose_depth: 30.0 * MM,
        nose_wall: 6.0 * MM,
        nose_height: 110.0 * MM,
        nose_overlap: 2.0 * MM,
        sleeve_radius: 30.0 * MM,
        sleeve_wall: 2.0 * MM,
        sleeve_height: 150.0 * MM,
        sleeve_fit: 10.0 * MM,
        size: 18.0 * MM,
    }
}

fn area(mesh: &Mesh, group: &str) -> f64 {
    let surface = Surface::of(mesh);
    surface.patch_area(surface.patch(group).unwrap())
}

#[track_caller]
fn close(found: f64, expected: f64, relative: f64) {
    assert!(
        (found / expected - 1.0).abs() < relative,
        "{found:e} instead of {expected:e}"
    );
}

#[test]
fn the_mesh_that_ships_has_the_dimensions_it_was_made_for() {
    // Were it made for others, gmsh would be asked for, and the test would need it.
    let built = tool(&n80cb(), false).unwrap();
    assert_eq!(built.comment, n80cb().signature());
    let mesh = &built.mesh;
    assert_eq!(mesh.part_names, ["housing", "nose", "sleeve"]);
    let quality = mesh.quality().unwrap();
    assert_eq!((quality.inverted, quality.open_edges, quality.pieces), (0, 0, 1));
    assert_eq!(quality.coincident_nodes, 0);
    let volumes = mesh.part_volumes().unwrap();
    let nose = (20.0 * 30.0 - 8.0 * 18.0) * 112.0 * MM.powi(3);
    close(volumes[1], nose, 1e-5);
    // Quadratic sides lie on the cylinders within a few parts in a thousand.
    let sleeve = PI * (32.0_f64.powi(2) - 30.0_f64.powi(2)) * 150.0 * MM.powi(3);
    close(volumes[2], sleeve, 5e-3);
    let (low, high) = mesh.bounds();
    close(high.z - low.z, 345.0 * MM, 1e-6);
    close(high.x, (33.0 + 170.0) * MM, 1e-6);
    close(area(mesh, "nose_tip"), (20.0 * 30.0 - 8.0 * 18.0) * MM * MM, 1e-5);
    close(area(mesh, "gas_bore"), 2.0 * PI * 30.0 * 150.0 * MM * MM, 5e-3);
    close(area(mesh, "bumper_seat"), PI * (30.0 * MM).powi(2), 5e-3);
    close(area(mesh, "magazine"), 2.0 * PI * (55.0 * MM).powi(2), 5e-3);
    close(area(mesh, "fit_slave"), 2.0 * PI * 32.0 * 10.0 * MM * MM, 5e-3);
    close(area(mesh, "fit_master"), 2.0 * PI * 32.5 * 181.0 * MM * MM, 5e-3);
    for group in ["seat", "cap", "handle"] {
        assert!(area(mesh, group) > 0.0, "{group}");
    }
}

#[test]
fn a_signature_tells_every_dimension_apart() {
    let signature = n80cb().signature();
    for (k, (name, _)) in n80cb().dimensions().iter().enumerate() {
        assert!(signature.contains(&format!(" {name}=")), "{name}");
        let words: Vec<&str> = signature.split(' ').collect();
        assert!(words[k + 1].starts_with(name), "{name}");
    }
    let other = Tool {
        sleeve_wall: 2.000_001 * MM,
        ..n80cb()
    };
    assert_ne!(other.signature(), signature);
}

#[test]
fn a_steel_table_stands_on_hollow_legs_that_touch_its_plate() {
    let spec = Worktable {
        top: [0.45, 0.4],
        thickness: 0.006,
        leg: [0.05; 2],
        height: 0.67,
        element_size: 0.03,
        leg_element_size: 0.03,
        top_layers: 2,
        origin: [-0.225, -0.2, -0.67],
    };
    let mesh = tube_worktable(&spec, 0.002).unwrap();
    assert_eq!(mesh.part_names, ["top", "leg"]);
    let quality = mesh.quality().unwrap();
    assert_eq!((quality.inverted, quality.open_edges, quality.pieces), (0, 0, 5));
    let volumes = mesh.part_volumes().unwrap();
    let ring = 0.05_f64.powi(2) - 0.046_f64.powi(2);
    close(volumes[0], 0.45 * 0.4 * 0.006, 1e-12);
    close(volumes[1], 4.0 * ring * 0.664, 1e-12);
    for (group, expected) in [
        ("top", 0.45 * 0.4),
        ("weld_master", 0.45 * 0.4),
        ("weld_slave", 4.0 * ring),
        ("floor", 4.0 * ring),
        ("sides", 2.0 * (0.45 + 0.4) * 0.006),
        ("leg_sides", 4.0 * 4.0 * (0.05 + 0.046) * 0.664),
    ] {
        close(area(&mesh, group), expected, 1e-12);
    }
    for node in mesh.group_nodes("weld_slave").unwrap() {
        assert!((mesh.nodes[node].z + 0.006).abs() < 1e-15);
    }
    assert!(
        tube_worktable(&spec, 0.025)
            .unwrap_err()
            .to_string()
            .contains("two walls")
    );
    assert!(tube_worktable(&spec, -0.002).is_err());
}

#[test]
fn folded_mid_sides_are_put_back_and_straight_elements_left_alone() {
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
fn joined_meshes_keep_their_elements_and_share_names() {
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
