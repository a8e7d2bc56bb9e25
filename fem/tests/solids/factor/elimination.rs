//! Systems that are assembled in their order of elimination.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use nailnoise_fem::{
    Attachments, Constraints, Coupling, FemError, LumpedMass, ModalSettings, assemble_in_order, assemble_with,
    elimination_order, modes,
};
use nailnoise_meshes::{Block, Mesh, block};
use nalgebra::{DMatrix, Matrix3, Point3};

use crate::bodies::pine_block;

fn bar(divisions: [usize; 3]) -> Mesh {
    let size = [0.5, 0.12, 0.08];
    block(&Block {
        size,
        divisions,
        origin: [0.0; 3],
    })
    .unwrap()
}

/// A mass at one end.
fn weighted(mass: f64, coupling: Coupling) -> Attachments {
    Attachments {
        masses: vec![LumpedMass {
            group: "x_max".to_owned(),
            mass,
            inertia: Matrix3::identity() * (1e-4 * mass),
            centre: Point3::new(0.52, 0.05, 0.04),
            coupling,
        }],
        ..Attachments::default()
    }
}

/// Load patterns of the tests: forces on every third degree of freedom.
fn loads(mesh: &Mesh) -> DMatrix<f64> {
    DMatrix::from_fn(3 * mesh.nodes.len(), 2, |dof, load| {
        f64::from(u8::from(dof % 3 == load))
    })
}

#[test]
fn modes_in_the_order_of_elimination_are_those_in_the_order_of_the_mesh() {
    let (mesh, material) = (bar([10, 4, 3]), [pine_block()]);
    let held = Constraints::clamped(&mesh, "x_min").unwrap();
    for coupling in [Coupling::Rigid, Coupling::Distributed] {
        let attachments = weighted(0.4, coupling);
        let order = elimination_order(&mesh, &held, &attachments).unwrap().unwrap();
        let plain = assemble_with(&mesh, &material, &held, &attachments).unwrap();
        let ordered = assemble_in_order(&mesh, &material, &held, &attachments, &order).unwrap();
        let settings = ModalSettings::below(8e3).with_loads(loads(&mesh));
        let [plain, ordered] = [plain, ordered].map(|system| modes(&system, &settings, &|_, _| ()).unwrap());
        assert_eq!(plain.sturm.count, ordered.sturm.count);
        assert!(plain.hz.len() > 10);
        for (a, b) in plain.all_hz().into_iter().zip(ordered.all_hz()) {
            assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
        }
        assert!(ordered.residuals.iter().all(|r| *r < 1e-8));
        // The signs of modes are open.
        for (a, b) in plain.shapes.column_iter().zip(ordered.shapes.column_iter()) {
            let sign = a.dot(&b).signum();
            assert!((a - b * sign).amax() < 1e-6 * a.amax());
        }
    }
}

#[test]
fn the_order_does_not_depend_on_how_heavy_a_mass_is() {
    let mesh = bar([6, 3, 2]);
    let order = |mass| elimination_order(&mesh, &Constraints::free(), &weighted(mass, Coupling::Distributed)).unwrap();
    assert!(order(0.1).is_some());
    assert_eq!(order(0.1), order(5.0));
}

#[test]
fn a_body_with_mirror_planes_has_no_order_of_its_own() {
    let mesh = bar([16, 6, 4]);
    let order = elimination_order(&mesh, &Constraints::free(), &Attachments::default()).unwrap();
    assert_eq!(order, None);
}

#[test]
fn an_order_of_other_nodes_is_refused() {
    let (mesh, material) = (bar([4, 2, 2]), [pine_block()]);
    let none = Attachments::default();
    let order = elimination_order(&mesh, &Constraints::free(), &none).unwrap().unwrap();
    let held = Constraints::clamped(&mesh, "x_min").unwrap();
    for (held, order) in [(&held, &order[..]), (&Constraints::free(), &order[1..])] {
        let refused = assemble_in_order(&mesh, &material, held, &none, order);
        assert!(matches!(refused, Err(FemError::Order { .. })));
    }
}

#[test]
fn no_bit_depends_on_the_number_of_threads() {
    let (mesh, material) = (bar([10, 4, 3]), [pine_block()]);
    let attachments = weighted(0.4, Coupling::Distributed);
    let order = elimination_order(&mesh, &Constraints::free(), &attachments)
        .unwrap()
        .unwrap();
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let system = assemble_in_order(&mesh, &material, &Constraints::free(), &attachments, &order).unwrap();
            modes(&system, &ModalSettings::below(8e3).with_loads(loads(&mesh)), &|_, _| ()).unwrap()
        })
    };
    assert_eq!(with(1), with(3));
}
