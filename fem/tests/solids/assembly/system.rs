//! Laws of the assembled matrices.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use crate::bodies::{free_workpiece, pine_block, workpiece};
use nailnoise_fem::{Constraints, FemError, Material, System, assemble};
use nailnoise_meshes::{Block, Mesh, block};
use nalgebra::{DMatrix, Matrix3, Point3, Vector3};
use nalgebra_sparse::CscMatrix;

/// A X of a symmetric matrix stored as its lower triangle.
fn times(a: &CscMatrix<f64>, x: &DMatrix<f64>) -> DMatrix<f64> {
    let mut y = DMatrix::zeros(x.nrows(), x.ncols());
    for (i, j, value) in a.triplet_iter() {
        for c in 0..x.ncols() {
            y[(i, c)] += value * x[(j, c)];
            if i != j {
                y[(j, c)] += value * x[(i, c)];
            }
        }
    }
    y
}

/// Nodal values of a displacement field.
fn field(mesh: &Mesh, u: impl Fn(Point3<f64>) -> Vector3<f64>) -> DMatrix<f64> {
    DMatrix::from_iterator(
        3 * mesh.nodes.len(),
        1,
        mesh.nodes.iter().flat_map(|&p| <[f64; 3]>::from(u(p))),
    )
}

/// A block whose inner nodes are moved, so that no element is a parallelepiped; mid-sides stay in the middle.
fn distorted() -> Mesh {
    let mut mesh = block(&Block {
        size: [1.0, 0.8, 0.6],
        divisions: [3, 3, 3],
        origin: [0.0; 3],
    })
    .unwrap();
    let move_corner = |p: Point3<f64>| {
        let inside = p.x * (1.0 - p.x) * p.y * (0.8 - p.y) * p.z * (0.6 - p.z);
        p + Vector3::new(1.0, -0.7, 0.5) * 8.0 * inside * (7.0 * p.x + 3.0 * p.y).sin()
    };
    let moved: Vec<Point3<f64>> = mesh.nodes.iter().map(|&p| move_corner(p)).collect();
    let edges = [
        [0, 1],
        [1, 2],
        [2, 3],
        [3, 0],
        [4, 5],
        [5, 6],
        [6, 7],
        [7, 4],
        [0, 4],
        [1, 5],
        [2, 6],
        [3, 7],
    ];
    for e in 0..mesh.element_count() {
        let nodes = mesh.element(e).nodes.to_vec();
        nodes[..8].iter().for_each(|&n| mesh.nodes[n] = moved[n]);
    }
    for e in 0..mesh.element_count() {
        let nodes = mesh.element(e).nodes.to_vec();
        for (k, [a, b]) in edges.into_iter().enumerate() {
            mesh.nodes[nodes[8 + k]] = nalgebra::center(&mesh.nodes[nodes[a]], &mesh.nodes[nodes[b]]);
        }
    }
    mesh
}

#[test]
fn constant_strain_is_in_equilibrium_inside_a_distorted_mesh() {
    let mesh = distorted();
    let material = pine_block();
    let system = assemble(&mesh, std::slice::from_ref(&material), &Constraints::free()).unwrap();
    let gradient = Matrix3::new(1.0, 0.3, -0.2, 0.5, -0.4, 0.1, 0.7, 0.2, 0.6) * 1e-3;
    let u = field(&mesh, |p| gradient * p.coords);
    let reduced = system.equations.restrict(&u).unwrap();
    let force = times(&system.stiffness, &reduced);
    let full = system.equations.expand(&force);
    let largest = full.amax();
    for (node, p) in mesh.nodes.iter().enumerate() {
        let inner = p.x > 1e-9 && p.x < 1.0 - 1e-9 && p.y > 1e-9 && p.y < 0.8 - 1e-9 && p.z > 1e-9 && p.z < 0.6 - 1e-9;
        for axis in 0..3 {
            if inner {
                assert!(full[3 * node + axis].abs() < 1e-11 * largest);
            }
        }
    }
    // Its energy is that of the homogeneous strain.
    let e = (gradient + gradient.transpose()) / 2.0;
    let strain = nalgebra::Vector6::new(
        e[(0, 0)],
        e[(1, 1)],
        e[(2, 2)],
        2.0 * e[(1, 2)],
        2.0 * e[(0, 2)],
        2.0 * e[(0, 1)],
    );
    let density = strain.dot(&(material.stiffness() * strain));
    let energy = (reduced.transpose() * force)[0];
    let volume = 1.0 * 0.8 * 0.6;
    assert!(
        (energy - density * volume).abs() < 1e-11 * energy,
        "{energy} against {}",
        density * volume
    );
}

fn rigid_motions(mesh: &Mesh) -> Vec<DMatrix<f64>> {
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    let mut motions: Vec<DMatrix<f64>> = axes.iter().map(|a| field(mesh, |_| *a)).collect();
    motions.extend(axes.iter().map(|a| field(mesh, |p| a.cross(&p.coords))));
    motions
}

#[test]
fn rigid_motions_store_no_energy() {
    for mesh in [workpiece([4, 3, 2]), distorted()] {
        let system = assemble(&mesh, &[pine_block()], &Constraints::free()).unwrap();
        let largest = system.stiffness.values().iter().fold(0.0, |a: f64, v| a.max(v.abs()));
        for motion in rigid_motions(&mesh) {
            let force = times(&system.stiffness, &system.equations.restrict(&motion).unwrap());
            assert!(force.amax() < 1e-13 * largest * motion.amax());
        }
    }
}

#[test]
fn a_single_element_has_six_zero_energy_modes_and_no_more() {
    let mesh = block(&Block {
        size: [1.0; 3],
        divisions: [1; 3],
        origin: [0.0; 3],
    })
    .unwrap();
    let system = assemble(
        &mesh,
        &[Material::isotropic(1.0, 0.3, 1.0).unwrap()],
        &Constraints::free(),
    )
    .unwrap();
    let dense = times(&system.stiffness, &DMatrix::identity(60, 60));
    let mut values: Vec<f64> = dense.symmetric_eigenvalues().iter().copied().collect();
    values.sort_by(f64::total_cmp);
    assert!(values[5].abs() < 1e-13 && values[6] > 1e-3, "{:?}", &values[..8]);
}

#[test]
fn mass_and_inertia_are_those_of_the_body() {
    let mesh = workpiece([5, 3, 2]);
    let system = assemble(&mesh, &[pine_block()], &Constraints::free()).unwrap();
    let mass = 429.46 * 0.4064 * 0.1524 * 0.09525;
    let kinetic = |u: &DMatrix<f64>| {
        let u = system.equations.restrict(u).unwrap();
        (u.transpose() * times(&system.mass, &u))[0]
    };
    let motions = rigid_motions(&mesh);
    for translation in &motions[..3] {
        assert!((kinetic(translation) - mass).abs() < 1e-12 * mass);
    }
    // About z through the corner at the origin: m (a^2 + b^2) / 3, which is quadratic and so exact.
    let inertia = mass * (0.4064_f64.powi(2) + 0.1524_f64.powi(2)) / 3.0;
    assert!((kinetic(&motions[5]) - inertia).abs() < 1e-12 * inertia);
    // The distorted block has the same outline.
    let mesh = distorted();
    let system = assemble(&mesh, &[pine_block()], &Constraints::free()).unwrap();
    let u = system.equations.restrict(&field(&mesh, |_| Vector3::x())).unwrap();
    let total = (u.transpose() * times(&system.mass, &u))[0];
    assert!((total - 429.46 * 0.48).abs() < 1e-11 * total);
}

#[test]
fn only_sorted_lower_triangles_are_stored() {
    let system = free_workpiece([3, 2, 2]);
    for a in [&system.stiffness, &system.mass] {
        for (j, column) in a.col_iter().enumerate() {
            assert_eq!(column.row_indices()[0], j);
            assert!(column.row_indices().windows(2).all(|w| w[0] < w[1]));
        }
    }
}

#[test]
fn held_degrees_of_freedom_are_eliminated() {
    let mesh = workpiece([3, 2, 2]);
    let free = assemble(&mesh, &[pine_block()], &Constraints::free()).unwrap();
    let mut constraints = Constraints::clamped(&mesh, "x_min").unwrap();
    let clamped = mesh.group_nodes("x_min").unwrap().len();
    let other = mesh.group_nodes("x_max").unwrap()[0];
    constraints.hold(other, 1);
    let held = assemble(&mesh, &[pine_block()], &constraints).unwrap();
    assert_eq!(held.equations.len(), free.equations.len() - 3 * clamped - 1);
    assert_eq!(held.equations.equation(other, 1), None);
    // On fields that vanish where the body is fixed, both models agree.
    let u = field(&mesh, |p| Vector3::new(p.x.sin(), 0.0, p.x * p.y));
    let energy = |s: &System, a: &CscMatrix<f64>| {
        let u = s.equations.restrict(&u).unwrap();
        (u.transpose() * times(a, &u))[0]
    };
    for (a, b) in [
        (energy(&free, &free.stiffness), energy(&held, &held.stiffness)),
        (energy(&free, &free.mass), energy(&held, &held.mass)),
    ] {
        assert!((a - b).abs() < 1e-12 * a);
    }
    let back = held.equations.expand(&held.equations.restrict(&u).unwrap());
    assert_eq!(back, u);
}

#[test]
fn inconsistent_models_are_refused() {
    let mesh = workpiece([1, 1, 1]);
    let materials = [pine_block(), pine_block()];
    assert!(matches!(
        assemble(&mesh, &materials, &Constraints::free()),
        Err(FemError::Materials { .. })
    ));
    let mut all = Constraints::free();
    (0..mesh.nodes.len()).for_each(|n| (0..3).for_each(|axis| all.hold(n, axis)));
    assert!(matches!(
        assemble(&mesh, &materials[..1], &all),
        Err(FemError::NothingFree { .. })
    ));
    let mut beyond = Constraints::free();
    beyond.hold(20, 0);
    assert!(matches!(
        assemble(&mesh, &materials[..1], &beyond),
        Err(FemError::Node { .. })
    ));
    let mut inverted = mesh.clone();
    inverted.nodes.swap(0, 1);
    inverted.nodes.iter_mut().for_each(|p| p.z = -p.z);
    assert!(matches!(
        assemble(&inverted, &materials[..1], &Constraints::free()),
        Err(FemError::Inverted { .. })
    ));
}

#[test]
fn assembly_does_not_depend_on_the_threads() {
    let assemble_with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| free_workpiece([6, 3, 2]))
    };
    let (one, three) = (assemble_with(1), assemble_with(3));
    assert_eq!(one.stiffness.values(), three.stiffness.values());
    assert_eq!(one.mass.values(), three.mass.values());
    assert_eq!(one.equations, three.equations);
}
