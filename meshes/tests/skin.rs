//! Laws of the built-in meshes and their skins.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use nailnoise_meshes::{Block, Mesh, MeshError, Surface, Worktable, block, element_size, worktable};
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;

fn table() -> Worktable {
    Worktable {
        top: [0.450, 0.400],
        thickness: 0.038,
        leg: [0.089, 0.089],
        height: 0.670,
        element_size: 0.045,
        leg_element_size: 0.080,
        top_layers: 1,
        origin: [0.0; 3],
    }
}

fn close(a: f64, b: f64, relative: f64) {
    assert!((a - b).abs() <= relative * b.abs(), "{a} against {b}");
}

/// Each patch of a plane body has one normal; the integral of the normal over a closed surface vanishes.
fn assert_sound(mesh: &Mesh) -> Surface {
    let surface = Surface::of(mesh);
    assert_eq!(surface.open_edges(), 0);
    let closure: Vector3<f64> = surface.quadrature(2).unwrap().iter().map(|q| q.normal * q.weight).sum();
    assert!(closure.norm() < 1e-14);
    for q in surface.quadrature(2).unwrap() {
        let face = &surface.faces[q.face];
        let x: Vector3<f64> = (0..8).map(|a| q.shape[a] * surface.points[face.nodes[a]].coords).sum();
        assert!((x - q.position.coords).norm() < 1e-15);
        assert!((q.normal.norm() - 1.0).abs() < 1e-14);
    }
    for (point, &node) in surface.points.iter().zip(&surface.volume_nodes) {
        assert_eq!(point, &mesh.nodes[node]);
    }
    surface
}

#[test]
fn block_skin_has_area_volume_and_outward_normals() {
    let spec = Block {
        size: [0.4064, 0.1524, 0.09525],
        divisions: [6, 3, 2],
        origin: [-0.1, 0.2, 0.3],
    };
    let mesh = block(&spec).unwrap();
    let [a, b, c] = spec.size;
    let surface = assert_sound(&mesh);
    close(surface.area(), 2.0 * (a * b + b * c + c * a), 1e-13);
    close(surface.volume(), a * b * c, 1e-13);
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
fn worktable_is_one_conforming_body() {
    let spec = table();
    let mesh = worktable(&spec).unwrap();
    let surface = assert_sound(&mesh);
    let (leg, top) = (0.089 * 0.089, 0.450 * 0.400);
    close(surface.volume(), top * 0.038 + 4.0 * leg * 0.632, 1e-13);
    let areas = [
        ("top", top),
        ("underside", top - 4.0 * leg),
        ("sides", 2.0 * (0.450 + 0.400) * 0.038),
        ("leg_sides", 16.0 * 0.089 * 0.632),
        ("floor", 4.0 * leg),
    ];
    for (name, area) in areas {
        close(surface.patch_area(surface.patch(name).unwrap()), area, 1e-13);
    }
    assert_eq!(surface.patches.len(), 5);
    assert!(
        mesh.group_nodes("floor")
            .unwrap()
            .iter()
            .all(|&n| mesh.nodes[n].z == 0.0)
    );
    assert_eq!(mesh.part_names, ["top", "leg"]);
}

#[test]
fn a_shared_node_is_one_node() {
    let mesh = worktable(&table()).unwrap();
    let mut keys: Vec<[i64; 3]> = mesh
        .nodes
        .iter()
        .map(|p| [p.x, p.y, p.z].map(|v| (v * 1e9).round() as i64))
        .collect();
    let count = keys.len();
    keys.sort_unstable();
    keys.dedup();
    assert_eq!(keys.len(), count);
    let mut used = vec![false; count];
    mesh.connectivity.iter().for_each(|&i| used[i] = true);
    assert!(used.into_iter().all(|u| u));
}

#[test]
fn impossible_bodies_are_refused() {
    let legs = Worktable {
        leg: [0.3, 0.089],
        ..table()
    };
    assert!(matches!(worktable(&legs), Err(MeshError::DoesNotFit { .. })));
    let thick = Worktable {
        thickness: 0.7,
        ..table()
    };
    assert!(matches!(worktable(&thick), Err(MeshError::DoesNotFit { .. })));
    let nan = Worktable {
        height: f64::NAN,
        ..table()
    };
    assert!(matches!(worktable(&nan), Err(MeshError::Dimension { .. })));
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
    assert!(matches!(
        Surface::of(&worktable(&table()).unwrap()).patch("lid"),
        Err(MeshError::UnknownGroup { .. })
    ));
}

#[test]
fn element_size_follows_the_slowest_wave() {
    // 557 m/s at 10 kHz is 56 mm; three elements a wavelength are below 20 mm.
    close(element_size(10e3, 557.0, 3.0).unwrap(), 0.018567, 1e-4);
    assert!(element_size(0.0, 557.0, 3.0).is_err());
    let spec = Block::with_element_size([0.4064, 0.1524, 0.09525], 0.018567, [0.0; 3]).unwrap();
    assert_eq!(spec.divisions, [22, 9, 6]);
}

proptest! {
    #[test]
    fn location_reproduces_the_point_and_partitions_unity(
        s in prop::array::uniform3(0.0..=1.0f64)
    ) {
        let spec = Block { size: [0.4064, 0.1524, 0.09525], divisions: [5, 3, 2], origin: [0.1, -0.2, 0.3] };
        let mesh = block(&spec).unwrap();
        let p = Point3::from([0, 1, 2].map(|k| spec.origin[k] + s[k] * spec.size[k]));
        let at = mesh.locate(p).unwrap();
        let x: Vector3<f64> = at.nodes.iter().zip(&at.weights).map(|(&n, w)| mesh.nodes[n].coords * *w).sum();
        prop_assert!((x - p.coords).norm() < 1e-13);
        prop_assert!((at.weights.iter().sum::<f64>() - 1.0).abs() < 1e-13);

        // The nearest point of the top, from slightly above it.
        let top = Point3::new(p.x, p.y, spec.origin[2] + spec.size[2]);
        let at = mesh.locate_on("top", top + Vector3::z() * 1e-4, 1e-3).unwrap();
        let x: Vector3<f64> = at.nodes.iter().zip(&at.weights).map(|(&n, w)| mesh.nodes[n].coords * *w).sum();
        prop_assert!((x - top.coords).norm() < 1e-13);

        // The point above it itself, by shape functions carried on.
        let above = top + Vector3::z() * 1e-4;
        let at = mesh.locate_within(above, 2e-4).unwrap();
        let x: Vector3<f64> = at.nodes.iter().zip(&at.weights).map(|(&n, w)| mesh.nodes[n].coords * *w).sum();
        prop_assert!((x - above.coords).norm() < 1e-13);
        match mesh.locate_within(above, 0.9e-4) {
            Err(MeshError::Outside { distance, .. }) => prop_assert!((distance - 1e-4).abs() < 1e-12),
            found => prop_assert!(false, "{found:?}"),
        }
        prop_assert_eq!(mesh.locate_within(p, 0.0).unwrap(), mesh.locate(p).unwrap());
    }
}

#[test]
fn points_outside_are_refused_with_their_distance() {
    let mesh = block(&Block {
        size: [1.0; 3],
        divisions: [2; 3],
        origin: [0.0; 3],
    })
    .unwrap();
    match mesh.locate(Point3::new(0.5, 0.5, 1.25)) {
        Err(MeshError::Outside { distance, .. }) => close(distance, 0.25, 1e-12),
        other => panic!("{other:?}"),
    }
    assert!(matches!(
        mesh.locate_on("top", Point3::new(0.5, 0.5, 0.5), 1e-3),
        Err(MeshError::Outside { .. })
    ));
    assert!(matches!(
        mesh.locate_on("lid", Point3::origin(), 1.0),
        Err(MeshError::UnknownGroup { .. })
    ));
}
