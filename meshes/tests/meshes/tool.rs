//! The shipped mesh of the body of the tool.
#![allow(clippy::unwrap_used)] // a test may panic, in its helpers too

use std::collections::HashSet;
use std::f64::consts::PI;
use std::sync::LazyLock;

use nailnoise_meshes::msh::Imported;
use nailnoise_meshes::{Surface, SurfaceFace, Tool, tool, tool_ships};
use nailnoise_quantities::dimension::LENGTH;
use nailnoise_quantities::positive;

use crate::base_design::{group, number};
use crate::common::{area, close};

const MM: f64 = 1e-3;

/// The N80CB, as its design has it.
fn n80cb() -> Tool {
    Tool {
        dimensions: group("body"),
        sleeve_radius: number("piston.bore", positive(LENGTH)) / 2.0,
        size: number("analysis.body_element", positive(LENGTH)),
    }
}

/// The mesh of the N80CB that is part of the crate. With other dimensions, gmsh would be needed.
static SHIPPED: LazyLock<Imported> = LazyLock::new(|| tool(&n80cb(), false).unwrap());

#[test]
fn the_shipped_mesh_has_the_signature_of_its_dimensions() {
    assert_eq!(SHIPPED.comment, n80cb().signature());
}

#[test]
fn only_the_mesh_of_these_dimensions_ships() {
    let mut other = n80cb();
    assert!(tool_ships(&other));
    other.dimensions.cap_wall += 1e-4;
    assert!(!tool_ships(&other));
}

#[test]
fn the_shipped_mesh_is_one_closed_piece() {
    let quality = SHIPPED.mesh.quality().unwrap();
    assert_eq!((quality.inverted, quality.open_edges, quality.pieces), (0, 0, 1));
    assert_eq!(quality.coincident_nodes, 0);
}

#[test]
fn the_parts_of_the_shipped_mesh_have_their_volumes() {
    let mesh = &SHIPPED.mesh;
    assert_eq!(mesh.part_names, ["cap", "housing", "nose", "sleeve"]);
    let volumes = mesh.part_volumes().unwrap();
    // Closed on both sides, with walls of 2.65 mm. Quadratic sides lie on the cylinders within a few parts in a
    // thousand.
    let cap = PI * (46.0_f64.powi(2) * 45.0 - 43.35_f64.powi(2) * 39.7) * MM.powi(3);
    close(volumes[0], cap, 5e-3);
    let nose = (20.0 * 30.0 - 8.0 * 18.0) * 112.0 * MM.powi(3);
    close(volumes[2], nose, 1e-5);
    let sleeve = PI * (32.0_f64.powi(2) - 30.0_f64.powi(2)) * 150.0 * MM.powi(3);
    close(volumes[3], sleeve, 5e-3);
}

#[test]
fn the_shipped_mesh_has_the_outer_dimensions_of_the_tool() {
    let (low, high) = SHIPPED.mesh.bounds();
    close(high.z - low.z, 345.0 * MM, 1e-6);
    close(high.x, (33.0 + 170.0) * MM, 1e-6);
}

#[test]
fn the_groups_of_the_shipped_mesh_have_their_areas() {
    let mesh = &SHIPPED.mesh;
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
fn the_signature_contains_every_dimension() {
    let signature = n80cb().signature();
    for (k, (name, _)) in n80cb().dimensions().iter().enumerate() {
        assert!(signature.contains(&format!(" {name}=")), "{name}");
        let words: Vec<&str> = signature.split(' ').collect();
        assert!(words[k + 1].starts_with(name), "{name}");
    }
    let mut other = n80cb();
    other.dimensions.sleeve_wall += 1e-6 * MM;
    assert_ne!(other.signature(), signature);
}

#[test]
fn the_shipped_mesh_is_its_own_image_and_has_no_crack_between_its_halves() {
    let mesh = &SHIPPED.mesh;
    let bits = |p: &nalgebra::Point3<f64>, sign: f64| [p.x, sign * p.y + 0.0, p.z].map(f64::to_bits);
    let nodes: HashSet<[u64; 3]> = mesh.nodes.iter().map(|p| bits(p, 1.0)).collect();
    assert!(mesh.nodes.iter().all(|p| nodes.contains(&bits(p, -1.0))));
    let flat = |face: &SurfaceFace| {
        mesh.face_nodes(face.of)
            .into_iter()
            .all(|node| mesh.nodes[node].y == 0.0)
    };
    assert_eq!(Surface::of(mesh).faces.iter().filter(|face| flat(face)).count(), 0);
}
