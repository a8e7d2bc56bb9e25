//! Bodies meshed separately, lumped masses and springs: rigid motions stay free, and the elastic modes are those of one
//! body.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use nailnoise_fem::{
    Attachments, Constraints, Coupling, FemError, GroundSpring, LumpedMass, Material, ModalBasis, ModalSettings, Place,
    System, Tie, assemble, assemble_with, modes,
};
use nailnoise_meshes::{Block, FaceRef, Mesh, block};
use nalgebra::{DMatrix, Matrix3, Point3, Vector3};

fn beam(x: [f64; 2], divisions: [usize; 3]) -> Mesh {
    block(&Block {
        size: [x[1] - x[0], 0.1, 0.08],
        divisions,
        origin: [x[0], 0.0, 0.0],
    })
    .unwrap()
}

/// Two meshes in one, without a shared node; the groups and parts of the second are marked with a prime.
fn beside(mut first: Mesh, second: &Mesh) -> Mesh {
    let (nodes, elements) = (first.nodes.len(), first.element_count());
    let (entries, parts) = (first.connectivity.len(), first.part_names.len());
    first.nodes.extend_from_slice(&second.nodes);
    first.kinds.extend_from_slice(&second.kinds);
    first.offsets.extend(second.offsets[1..].iter().map(|o| o + entries));
    first.connectivity.extend(second.connectivity.iter().map(|n| n + nodes));
    first.parts.extend(second.parts.iter().map(|p| p + parts));
    first
        .part_names
        .extend(second.part_names.iter().map(|n| format!("{n}'")));
    for group in &second.groups {
        let mut group = group.clone();
        group.name.push('\'');
        group.faces.iter_mut().for_each(|f| {
            *f = FaceRef {
                element: f.element + elements,
                face: f.face,
            };
        });
        first.groups.push(group);
    }
    first
}

fn steel() -> Material {
    Material::isotropic(2e11, 0.3, 8000.0).unwrap()
}

fn solve(system: &System, top_hz: f64) -> ModalBasis {
    let basis = modes(system, &ModalSettings::below(top_hz), &|_, _| ()).unwrap();
    assert_eq!(basis.sturm.count, basis.hz.len());
    basis
}

fn quadratic_form(a: &nalgebra_sparse::CscMatrix<f64>, u: &DMatrix<f64>) -> f64 {
    a.triplet_iter()
        .map(|(i, j, v)| v * u[i] * u[j] * if i == j { 1.0 } else { 2.0 })
        .sum()
}

fn tie(slave: &str, master: &str, tolerance: f64) -> Attachments {
    Attachments {
        ties: vec![Tie {
            slave: slave.to_owned(),
            master: master.to_owned(),
            tolerance,
        }],
        ..Attachments::default()
    }
}

#[test]
fn a_split_block_with_meshes_that_do_not_match_has_the_modes_of_the_whole() {
    let materials = [steel(), steel()];
    let whole = assemble(&beam([0.0, 0.5], [10, 4, 4]), &materials[..1], &Constraints::free()).unwrap();
    let whole = solve(&whole, 8e3);
    let mesh = beside(beam([0.0, 0.26], [5, 3, 3]), &beam([0.26, 0.5], [5, 4, 4]));
    let system = assemble_with(&mesh, &materials, &Constraints::free(), &tie("x_min'", "x_max", 1e-9)).unwrap();
    // The slave's face has left the equations.
    let slaves = mesh.group_nodes("x_min'").unwrap();
    assert_eq!(system.equations.len(), 3 * (mesh.nodes.len() - slaves.len()));
    let split = solve(&system, 8e3);
    assert_eq!(split.rigid.iter().filter(|r| **r).count(), 6);
    assert_eq!(split.hz.len(), whole.hz.len());
    for (a, b) in split.hz.iter().zip(&whole.hz).skip(6) {
        assert!((a / b - 1.0).abs() < 4e-3, "{:?} against {:?}", split.hz, whole.hz);
    }
    // The shapes meet at the interface.
    for &node in &slaves {
        let at = mesh.locate_on("x_max", mesh.nodes[node], 1e-9).unwrap();
        for axis in 0..3 {
            let value = |n: usize| split.shapes[(3 * n + axis, 8)];
            let master: f64 = at.nodes.iter().zip(&at.weights).map(|(&n, w)| w * value(n)).sum();
            assert!((value(node) - master).abs() < 1e-10 * split.shapes.amax());
        }
    }
}

/// Rigid motions store no energy even where the surfaces do not quite meet and the tie bridges a gap.
#[test]
fn a_tie_across_a_gap_leaves_all_rigid_motions_free() {
    let mesh = beside(beam([0.0, 0.26], [4, 2, 2]), &beam([0.263, 0.5], [5, 3, 3]));
    let materials = [steel(), steel()];
    let system = assemble_with(&mesh, &materials, &Constraints::free(), &tie("x_min'", "x_max", 4e-3)).unwrap();
    let largest = system.stiffness.values().iter().fold(0.0, |a: f64, v| a.max(v.abs()));
    for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
        for rotation in [false, true] {
            let motion = |p: &Point3<f64>| if rotation { axis.cross(&p.coords) } else { axis };
            let u = DMatrix::from_iterator(
                3 * mesh.nodes.len(),
                1,
                mesh.nodes.iter().flat_map(|p| <[f64; 3]>::from(motion(p))),
            );
            let q = system.equations.select(&u).unwrap();
            assert!((system.equations.expand(&q) - &u).amax() < 1e-12 * u.amax());
            assert!(quadratic_form(&system.stiffness, &q).abs() < 1e-12 * largest * u.amax().powi(2));
        }
    }
    let basis = solve(&system, 4e3);
    assert_eq!(basis.rigid.iter().filter(|r| **r).count(), 6);
    // Too far for its tolerance, it is refused with the distance.
    let refused = assemble_with(&mesh, &materials, &Constraints::free(), &tie("x_min'", "x_max", 1e-3));
    assert!(matches!(refused, Err(FemError::Mesh(_))), "{refused:?}");
}

fn lumped(coupling: Coupling) -> LumpedMass {
    LumpedMass {
        group: "x_max".to_owned(),
        mass: 3.0,
        inertia: Matrix3::from_diagonal(&Vector3::new(0.02, 0.03, 0.025)),
        centre: Point3::new(0.6, 0.07, 0.04),
        coupling,
    }
}

/// A lumped mass adds its mass and its inertia about every axis, whichever way it is fixed.
#[test]
fn a_lumped_mass_adds_its_mass_and_inertia() {
    let mesh = beam([0.0, 0.5], [4, 2, 2]);
    let bare = assemble(&mesh, &[steel()], &Constraints::free()).unwrap();
    for coupling in [Coupling::Rigid, Coupling::Distributed] {
        let mass = lumped(coupling);
        let attachments = Attachments {
            masses: vec![mass.clone()],
            ..Attachments::default()
        };
        let system = assemble_with(&mesh, &[steel()], &Constraints::free(), &attachments).unwrap();
        for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
            let t = system.equations.translation(axis);
            let before = quadratic_form(&bare.mass, &bare.equations.translation(axis));
            let added = quadratic_form(&system.mass, &t) - before;
            assert!((added - mass.mass).abs() < 1e-10 * mass.mass, "{coupling:?}: {added}");
        }
        let basis = solve(&system, 6e3);
        assert_eq!(basis.rigid.iter().filter(|r| **r).count(), 6, "{coupling:?}");
        // Rigid modes span all rigid motions, so the sum of phi^T M e e^T M phi is the mass of the whole.
        let total = 8000.0 * 0.5 * 0.1 * 0.08 + mass.mass;
        let t = system.equations.translation(Vector3::y());
        let q = quadratic_form(&system.mass, &t);
        assert!((q - total).abs() < 1e-10 * total);
        // Flexible modes come down: the mass is on the end.
        let free = solve(&bare, 6e3);
        assert!(basis.hz[6] < 0.95 * free.hz[6], "{} {}", basis.hz[6], free.hz[6]);
    }
}

/// A short stiff block with a mass off its end on a soft spring: the pendulum frequencies of a rigid body.
#[test]
fn a_rigid_body_on_springs_has_its_frequencies() {
    let mesh = block(&Block {
        size: [0.1, 0.1, 0.1],
        divisions: [2; 3],
        origin: [-0.05; 3],
    })
    .unwrap();
    let stiffness = Matrix3::from_diagonal(&Vector3::new(3e5, 2e5, 1e5));
    let mut attachments = Attachments::default();
    for name in ["bottom", "top"] {
        attachments.springs.push(GroundSpring {
            place: Place::Group(name.to_owned()),
            stiffness: stiffness / 2.0,
        });
    }
    attachments.masses.push(LumpedMass {
        group: "x_max".to_owned(),
        mass: 4.0,
        inertia: Matrix3::from_diagonal_element(0.01),
        centre: Point3::origin(),
        coupling: Coupling::Distributed,
    });
    let system = assemble_with(&mesh, &[steel()], &Constraints::free(), &attachments).unwrap();
    let basis = solve(&system, 300.0);
    let m = 8000.0 * 1e-3 + 4.0;
    // The springs lie symmetric to the common centre of mass, so translations and rotations decouple.
    for k in [1e5, 2e5, 3e5f64] {
        let hz = (k / m).sqrt() / std::f64::consts::TAU;
        let near = basis.hz.iter().map(|f| (f / hz - 1.0).abs()).fold(1.0, f64::min);
        assert!(near < 2e-3, "{hz} not in {:?}", basis.hz);
    }
    assert_eq!(basis.hz.len(), 6);
    // About x the springs along z are spread evenly over y within 0.05, those along y act at z = 0.05 and -0.05.
    let inertia: f64 = 8.0 * 0.01 / 6.0 + 0.01;
    let k_rx = 1e5 * 0.1 * 0.1 / 12.0 + 2e5 * 0.05 * 0.05;
    let hz = (k_rx / inertia).sqrt() / std::f64::consts::TAU;
    let near = basis.hz.iter().map(|f| (f / hz - 1.0).abs()).fold(1.0, f64::min);
    assert!(near < 2e-3, "{hz} not in {:?}", basis.hz);
}

#[test]
fn a_spring_at_a_point_acts_there() {
    let mesh = beam([0.0, 0.5], [4, 2, 2]);
    let at = mesh.locate(Point3::new(0.2, 0.03, 0.05)).unwrap();
    let attachments = Attachments {
        springs: vec![GroundSpring {
            place: Place::Point(at),
            stiffness: Matrix3::from_diagonal_element(1e6),
        }],
        ..Attachments::default()
    };
    let system = assemble_with(&mesh, &[steel()], &Constraints::free(), &attachments).unwrap();
    let t = system.equations.translation(Vector3::z());
    let k = quadratic_form(&system.stiffness, &t);
    assert!((k - 1e6).abs() < 1.0, "{k}");
    // Rotations about the point remain free.
    assert_eq!(solve(&system, 2e3).rigid.iter().filter(|r| **r).count(), 3);
}

fn refused(attachments: &Attachments, hold: Option<&str>) -> FemError {
    let mesh = beside(beam([0.0, 0.26], [4, 2, 2]), &beam([0.26, 0.5], [5, 3, 3]));
    let constraints = hold.map_or_else(Constraints::free, |group| Constraints::clamped(&mesh, group).unwrap());
    assemble_with(&mesh, &[steel(), steel()], &constraints, attachments)
        .map(|_| ())
        .unwrap_err()
}

#[test]
fn a_group_that_is_tied_twice_is_refused() {
    let mut twice = tie("x_min'", "x_max", 1e-9);
    twice.ties.push(twice.ties[0].clone());
    assert!(matches!(refused(&twice, None), FemError::TiedTwice { .. }));
}

#[test]
fn ties_in_a_circle_are_refused() {
    let mut circle = tie("x_min'", "x_max", 1e-9);
    circle.ties.extend(tie("x_max", "x_min'", 1e-9).ties);
    assert!(matches!(refused(&circle, None), FemError::TieCycle { .. }));
}

#[test]
fn a_group_that_is_held_and_tied_is_refused() {
    let tied = tie("x_min'", "x_max", 1e-9);
    assert!(matches!(refused(&tied, Some("x_min'")), FemError::HeldAndTied { .. }));
}

#[test]
fn an_impossible_inertia_is_refused() {
    let impossible = LumpedMass {
        inertia: Matrix3::from_diagonal(&Vector3::new(1.0, 0.1, 0.1)),
        ..lumped(Coupling::Rigid)
    };
    let attachments = Attachments {
        masses: vec![impossible],
        ..Attachments::default()
    };
    assert!(matches!(refused(&attachments, None), FemError::Inertia { .. }));
}

#[test]
fn a_negative_spring_stiffness_is_refused() {
    let attachments = Attachments {
        springs: vec![GroundSpring {
            place: Place::Group("top".to_owned()),
            stiffness: Matrix3::from_diagonal_element(-1.0),
        }],
        ..Attachments::default()
    };
    assert!(matches!(refused(&attachments, None), FemError::Spring { .. }));
}
