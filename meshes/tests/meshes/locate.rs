//! Points located in a mesh.
#![allow(clippy::unwrap_used)] // a test may panic, in its helpers too

use std::sync::LazyLock;

use crate::common::close;
use nailnoise_meshes::{Block, ElementKind, FaceGroup, FaceRef, Location, Mesh, MeshError, block};
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;

const SIZE: [f64; 3] = [0.4064, 0.1524, 0.09525];
const ORIGIN: [f64; 3] = [0.1, -0.2, 0.3];

static MESH: LazyLock<Mesh> = LazyLock::new(|| {
    block(&Block {
        size: SIZE,
        divisions: [5, 3, 2],
        origin: ORIGIN,
    })
    .unwrap()
});

/// The point at fractions of the sides of the block.
fn point(s: [f64; 3]) -> Point3<f64> {
    Point3::from([0, 1, 2].map(|k| ORIGIN[k] + s[k] * SIZE[k]))
}

/// The point that nodes and weights of a location give.
fn carried(at: &Location) -> Point3<f64> {
    let sum: Vector3<f64> = at
        .nodes
        .iter()
        .zip(&at.weights)
        .map(|(&n, w)| MESH.nodes[n].coords * *w)
        .sum();
    Point3::from(sum)
}

proptest! {
    #[test]
    fn a_location_reproduces_its_point_and_its_weights_sum_to_one(s in prop::array::uniform3(0.0..=1.0f64)) {
        let at = MESH.locate(point(s)).unwrap();
        prop_assert!((carried(&at) - point(s)).norm() < 1e-13);
        prop_assert!((at.weights.iter().sum::<f64>() - 1.0).abs() < 1e-13);
    }

    #[test]
    fn a_location_on_a_group_is_its_nearest_point(x in 0.0..=1.0f64, y in 0.0..=1.0f64) {
        let top = point([x, y, 1.0]);
        let at = MESH.locate_on("top", top + Vector3::z() * 1e-4, 1e-3).unwrap();
        prop_assert!((carried(&at) - top).norm() < 1e-13);
    }

    #[test]
    fn a_point_within_a_distance_of_the_mesh_is_extrapolated(x in 0.0..=1.0f64, y in 0.0..=1.0f64) {
        let above = point([x, y, 1.0]) + Vector3::z() * 1e-4;
        let at = MESH.locate_within(above, 2e-4).unwrap();
        prop_assert!((carried(&at) - above).norm() < 1e-13);
    }

    #[test]
    fn a_point_beyond_the_distance_is_refused_with_its_own(x in 0.0..=1.0f64, y in 0.0..=1.0f64) {
        let above = point([x, y, 1.0]) + Vector3::z() * 1e-4;
        match MESH.locate_within(above, 0.9e-4) {
            Err(MeshError::Outside { distance, .. }) => prop_assert!((distance - 1e-4).abs() < 1e-12),
            found => prop_assert!(false, "{found:?}"),
        }
    }

    #[test]
    fn within_no_distance_a_point_is_located_inside(s in prop::array::uniform3(0.0..=1.0f64)) {
        prop_assert_eq!(MESH.locate_within(point(s), 0.0).unwrap(), MESH.locate(point(s)).unwrap());
    }
}

#[test]
fn a_point_outside_is_refused_with_its_distance() {
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

/// Two tetrahedra that are images of each other in y = 0. They share an edge of their upper faces and no face.
fn images() -> Mesh {
    let nodes = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.3, 1.0, 0.0],
        [0.5, 0.6, -1.0],
        [0.3, -1.0, 0.0],
        [0.5, -0.6, -1.0],
    ];
    let mut mesh = Mesh {
        nodes: nodes.map(Point3::from).to_vec(),
        kinds: vec![ElementKind::Tet4; 2],
        offsets: vec![0, 4, 8],
        connectivity: vec![0, 2, 1, 3, 0, 1, 4, 5],
        parts: vec![0; 2],
        part_names: vec!["body".to_owned()],
        groups: vec![],
    };
    let face = |element: usize| {
        let faces = (0..4).map(|face| FaceRef { element, face });
        let upper = |face: &FaceRef| mesh.face_nodes(*face).into_iter().all(|node| mesh.nodes[node].z == 0.0);
        faces.into_iter().find(upper).unwrap()
    };
    let faces = vec![face(0), face(1)];
    mesh.groups.push(FaceGroup {
        name: "top".to_owned(),
        faces,
    });
    mesh
}

#[test]
fn a_point_over_a_common_edge_has_the_mean_weights_of_both_elements() {
    let mesh = images();
    let point = Point3::new(0.4, 0.0, 0.05);
    let at = mesh.locate_near("top", point, 0.1).unwrap();
    let weight = |node: usize| at.nodes.iter().position(|&n| n == node).map_or(0.0, |k| at.weights[k]);
    assert!(weight(3) < -0.01);
    close(weight(5), weight(3), 1e-12);
    close(weight(4), weight(2), 1e-12);
    let sum: Vector3<f64> = (0..6).map(|node| mesh.nodes[node].coords * weight(node)).sum();
    assert!((sum - point.coords).norm() < 1e-12);
}

/// A tetrahedron whose edges below its upper face bend so much that no natural coordinates reach 0.05 above it.
#[test]
fn a_point_that_a_curved_element_does_not_reach_is_carried_by_its_tangent() {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.2, 0.2, -1.0]].map(Point3::from);
    let mut nodes = corners.to_vec();
    for [a, b] in ElementKind::Tet10.edges() {
        let mut middle = nalgebra::center(&corners[*a], &corners[*b]);
        if middle.z < 0.0 {
            middle.z = -0.2;
        }
        nodes.push(middle);
    }
    let mut mesh = Mesh {
        nodes,
        kinds: vec![ElementKind::Tet10],
        offsets: vec![0, 10],
        connectivity: (0..10).collect(),
        parts: vec![0],
        part_names: vec!["body".to_owned()],
        groups: vec![],
    };
    let faces = (0..4).map(|face| FaceRef { element: 0, face });
    let upper = |face: &FaceRef| mesh.face_nodes(*face).into_iter().all(|node| mesh.nodes[node].z == 0.0);
    let faces = faces.filter(upper).collect();
    mesh.groups.push(FaceGroup {
        name: "top".to_owned(),
        faces,
    });
    let point = Point3::new(0.3, 0.4, 0.05);
    let at = mesh.locate_near("top", point, 0.1).unwrap();
    close(at.weights.iter().sum(), 1.0, 1e-12);
    let nodes = at.nodes.iter().map(|&node| mesh.nodes[node].coords);
    let sum: Vector3<f64> = nodes.zip(&at.weights).map(|(node, weight)| node * *weight).sum();
    assert!((sum - point.coords).norm() < 1e-12);
}
