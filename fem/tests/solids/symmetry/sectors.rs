//! Mirror planes change only the cost of a solution.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use crate::bodies::{PINE, clamped_table, free_workpiece, pine_block, workpiece};
use nailnoise_fem::{
    Attachments, Constraints, GroundSpring, Material, ModalBasis, ModalSettings, Place, System, assemble,
    assemble_with, modes,
};
use nailnoise_meshes::jointed_block;
use nalgebra::{DMatrix, Matrix3, Vector3};

const DIVISIONS: [usize; 3] = [14, 6, 4];

fn solve(system: &System, top_hz: f64, mirrors: bool) -> ModalBasis {
    // Loads at an inner node, in all directions.
    let dofs = system.equations.dofs();
    let mut loads = DMatrix::zeros(dofs, 3);
    (0..3).for_each(|axis| loads[(3 * (dofs / 7) + axis, axis)] = 1.0);
    let settings = ModalSettings {
        mirrors,
        ..ModalSettings::below(top_hz).with_loads(loads)
    };
    modes(system, &settings, &|_, _| ()).unwrap()
}

/// Receptance at the loaded node far below the elastic modes, from modes and static corrections.
fn compliance(system: &System, basis: &ModalBasis) -> Matrix3<f64> {
    let node = system.equations.dofs() / 7;
    let rows = basis.shapes.rows(3 * node, 3).into_owned();
    let mut sum = Matrix3::zeros();
    for (column, hz) in rows.column_iter().zip(basis.all_hz()).filter(|(_, hz)| *hz > 0.0) {
        sum += column * column.transpose() / (std::f64::consts::TAU * hz).powi(2);
    }
    sum
}

fn assert_same(system: &System, top_hz: f64, sectors: usize) {
    let (divided, whole) = (solve(system, top_hz, true), solve(system, top_hz, false));
    assert_eq!((divided.work.sectors, whole.work.sectors), (sectors, 1));
    assert_eq!(divided.sturm, whole.sturm);
    assert_eq!(divided.rigid, whole.rigid);
    assert_eq!(divided.hz.len(), divided.sturm.count);
    for (a, b) in divided.hz.iter().zip(&whole.hz) {
        assert!((a - b).abs() <= 1e-10 * b, "{a} Hz in sectors, {b} Hz in one piece");
    }
    assert!(divided.residuals.iter().all(|&r| r < 1e-8));
    assert!(divided.orthonormality < 1e-10, "{}", divided.orthonormality);
    let (a, b) = (compliance(system, &divided), compliance(system, &whole));
    assert!((a - b).norm() < 1e-8 * b.norm(), "{a} {b}");
    if sectors > 1 {
        assert!(divided.work.factor_values < whole.work.factor_values);
    }
}

#[test]
fn the_free_block_falls_into_eight_sectors() {
    assert_same(&free_workpiece(DIVISIONS), 6e3, 8);
}

/// Where they touch, both have a node at the same place.
#[test]
fn two_pieces_that_touch_fall_into_four_sectors() {
    let mesh = jointed_block([0.4064, 0.1524, 0.09525], 0.025, [0.0; 3], 0.05).unwrap();
    let system = assemble(&mesh, &[pine_block(), pine_block()], &Constraints::free()).unwrap();
    assert_same(&system, 4e3, 4);
}

#[test]
fn the_clamped_worktable_falls_into_four_sectors() {
    assert_same(&clamped_table(0.045), 1e3, 4);
}

#[test]
fn an_oblique_grain_leaves_the_plane_it_lies_in() {
    let (sin, cos) = 0.3_f64.sin_cos();
    let axes = Matrix3::from_columns(&[Vector3::new(cos, sin, 0.0), Vector3::z(), Vector3::new(sin, -cos, 0.0)]);
    let grain = Material::orthotropic(&PINE, &axes, 429.46).unwrap();
    let system = assemble(&workpiece(DIVISIONS), &[grain], &Constraints::free()).unwrap();
    assert_same(&system, 5e3, 2);
}

#[test]
fn a_soft_spring_at_a_face_breaks_its_plane_only() {
    let mesh = workpiece(DIVISIONS);
    let group = mesh.groups[0].name.clone();
    let spring = GroundSpring {
        place: Place::Group(group),
        stiffness: Matrix3::from_diagonal_element(1e4),
    };
    let attachments = Attachments {
        springs: vec![spring],
        ..Attachments::default()
    };
    let system = assemble_with(&mesh, &[pine_block()], &Constraints::free(), &attachments).unwrap();
    let basis = modes(&system, &ModalSettings::below(3e3), &|_, _| ()).unwrap();
    assert_eq!(basis.work.sectors, 4);
}

#[test]
fn a_mesh_that_is_not_symmetric_stays_whole() {
    let mut mesh = workpiece(DIVISIONS);
    let inner = mesh.nodes.len() / 3;
    mesh.nodes[inner] += Vector3::new(1e-5, 2e-5, 3e-5);
    let system = assemble(&mesh, &[pine_block()], &Constraints::free()).unwrap();
    assert_eq!(
        modes(&system, &ModalSettings::below(3e3), &|_, _| ())
            .unwrap()
            .work
            .sectors,
        1
    );
}

#[test]
fn sectors_do_not_depend_on_the_threads() {
    let solve = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| solve(&free_workpiece(DIVISIONS), 5e3, true))
    };
    assert_eq!(solve(1), solve(3));
}

#[test]
fn the_work_in_sectors_is_as_frozen() {
    let basis = modes(&free_workpiece(DIVISIONS), &ModalSettings::below(8e3), &|_, _| ()).unwrap();
    insta::assert_json_snapshot!(basis.work);
}
