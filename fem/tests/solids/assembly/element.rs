//! Every element kind: patch tests on distorted meshes, and manufactured solutions with the orders of theory.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::f64::consts::PI;

use crate::kinds::{conjugate_gradients, fine_rule, structured, times};
use nailnoise_fem::{Constraints, Material, assemble};
use nailnoise_meshes::{ElementKind, Mesh};
use nalgebra::{DMatrix, Matrix3, Point3, Vector3};

/// Moves the inside of the unit cube, so that no element is a parallelepiped and no edge straight.
fn distort(x: [f64; 3], by: f64) -> Point3<f64> {
    let inside = (PI * x[0]).sin() * (PI * x[1]).sin() * (PI * x[2]).sin();
    Point3::from(x) + Vector3::new(1.0, -0.7, 0.5) * by * inside * (2.0 * x[0] + 3.0 * x[1] - x[2]).cos()
}

fn on_boundary(p: Point3<f64>) -> bool {
    p.coords.iter().any(|&x| x.min(1.0 - x).abs() < 1e-9)
}

/// A field of constant strain that is given only on the boundary is found exactly inside.
#[test]
fn every_kind_passes_the_patch_test() {
    let material = crate::bodies::pine_block();
    let gradient = Matrix3::new(1.0, 0.3, -0.2, 0.5, -0.4, 0.1, 0.7, 0.2, 0.6) * 1e-3;
    for kind in ElementKind::ALL {
        let mesh = structured(kind, [3; 3], |x| distort(x, 0.08));
        let system = assemble(&mesh, std::slice::from_ref(&material), &Constraints::free()).unwrap();
        let exact = DMatrix::from_iterator(
            3 * mesh.nodes.len(),
            1,
            mesh.nodes.iter().flat_map(|p| <[f64; 3]>::from(gradient * p.coords)),
        );
        // With u = g on the boundary and v inside: K_ii v = -K_ib g; the right side comes from the free model.
        let mut boundary = exact.clone();
        let mut constraints = Constraints::free();
        for (node, &p) in mesh.nodes.iter().enumerate() {
            for axis in 0..3 {
                if on_boundary(p) {
                    constraints.hold(node, axis);
                } else {
                    boundary[3 * node + axis] = 0.0;
                }
            }
        }
        let force = times(&system.stiffness, &system.equations.select(&boundary).unwrap());
        let held = assemble(&mesh, std::slice::from_ref(&material), &constraints).unwrap();
        let load = held.equations.select(&system.equations.expand(&force)).unwrap();
        let inside = held.equations.expand(&conjugate_gradients(&held.stiffness, &-load));
        let error = (inside + boundary - &exact).amax() / exact.amax();
        assert!(error < 1e-9, "{kind:?}: {error:e}");
        // Its energy is that of the homogeneous strain: no kind is too stiff or too soft for it.
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
        let q = system.equations.select(&exact).unwrap();
        let energy = q.dot(&times(&system.stiffness, &q));
        assert!(
            (energy / density - 1.0).abs() < 1e-9,
            "{kind:?}: {energy} against {density}"
        );
    }
}

/// One element has the six rigid motions and no other motion without energy.
#[test]
fn a_single_element_of_every_kind_has_six_zero_energy_modes() {
    let material = Material::isotropic(1.0, 0.3, 1.0).unwrap();
    for kind in ElementKind::ALL {
        let mesh = Mesh {
            nodes: kind.natural_nodes().iter().map(|&x| Point3::from(x)).collect(),
            kinds: vec![kind],
            offsets: vec![0, kind.nodes()],
            connectivity: (0..kind.nodes()).collect(),
            parts: vec![0],
            part_names: vec!["body".to_owned()],
            groups: Vec::new(),
        };
        let system = assemble(&mesh, std::slice::from_ref(&material), &Constraints::free()).unwrap();
        let n = system.equations.len();
        let dense = times(&system.stiffness, &DMatrix::identity(n, n));
        let mut values: Vec<f64> = dense.symmetric_eigenvalues().iter().copied().collect();
        values.sort_by(f64::total_cmp);
        assert!(
            values[5].abs() < 1e-13 && values[6] > 1e-4,
            "{kind:?}: {:?}",
            &values[..8]
        );
        let mass = times(&system.mass, &DMatrix::identity(n, n))
            .symmetric_eigenvalues()
            .min();
        assert!(mass > 0.0, "{kind:?}: {mass}");
    }
}

const AMPLITUDE: [f64; 3] = [1.0, -0.6, 0.8];

/// u = a sin(pi x) sin(pi y) sin(pi z), zero on the boundary, its gradient du_i/dx_j, and the force that balances it, f
/// = -(mu lap u + (lambda + mu) grad div u).
fn manufactured(p: Point3<f64>, lame: [f64; 2]) -> (Vector3<f64>, Matrix3<f64>, Vector3<f64>) {
    let s = p.coords.map(|x| (PI * x).sin());
    let c = p.coords.map(|x| (PI * x).cos());
    let g = s[0] * s[1] * s[2];
    let slope = Vector3::new(
        PI * c[0] * s[1] * s[2],
        PI * s[0] * c[1] * s[2],
        PI * s[0] * s[1] * c[2],
    );
    let second = |i: usize, j: usize| {
        if i == j {
            -PI * PI * g
        } else {
            let k = 3 - i - j;
            PI * PI * c[i] * c[j] * s[k]
        }
    };
    let a = Vector3::from(AMPLITUDE);
    let [lambda, mu] = lame;
    let f = Vector3::from_fn(|i, _| {
        let divergence: f64 = (0..3).map(|j| a[j] * second(j, i)).sum();
        3.0 * PI * PI * mu * a[i] * g - (lambda + mu) * divergence
    });
    (a * g, a * slope.transpose(), f)
}

/// Errors in L2 and in the H1 seminorm on n^3 cells.
fn errors(kind: ElementKind, n: usize) -> [f64; 2] {
    let (e, nu) = (1.0, 0.3);
    let lame = [e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu))];
    let mesh = structured(kind, [n; 3], |x| distort(x, 0.03));
    let mut constraints = Constraints::free();
    for (node, &p) in mesh.nodes.iter().enumerate() {
        if on_boundary(p) {
            (0..3).for_each(|axis| constraints.hold(node, axis));
        }
    }
    let system = assemble(&mesh, &[Material::isotropic(e, nu, 1.0).unwrap()], &constraints).unwrap();
    let rule: Vec<_> = fine_rule(kind)
        .into_iter()
        .map(|(xi, w)| {
            let (mut n, mut dn) = (vec![0.0; kind.nodes()], vec![[0.0; 3]; kind.nodes()]);
            kind.shape(xi, &mut n, &mut dn);
            (w, n, dn)
        })
        .collect();
    let at = |nodes: &[usize], n: &[f64], dn: &[[f64; 3]]| {
        let (mut x, mut j) = (Vector3::zeros(), Matrix3::zeros());
        for (a, &node) in nodes.iter().enumerate() {
            x += n[a] * mesh.nodes[node].coords;
            j += mesh.nodes[node].coords * Vector3::from(dn[a]).transpose();
        }
        (Point3::from(x), j)
    };
    let mut load = DMatrix::zeros(3 * mesh.nodes.len(), 1);
    for element in mesh.elements() {
        for (w, n, dn) in &rule {
            let (x, j) = at(element.nodes, n, dn);
            let f = manufactured(x, lame).2 * (w * j.determinant());
            for (a, &node) in element.nodes.iter().enumerate() {
                (0..3).for_each(|axis| load[3 * node + axis] += n[a] * f[axis]);
            }
        }
    }
    let q = conjugate_gradients(&system.stiffness, &system.equations.restrict(&load).unwrap());
    let u = system.equations.expand(&q);
    let mut squares = [0.0; 2];
    for element in mesh.elements() {
        for (w, n, dn) in &rule {
            let (x, j) = at(element.nodes, n, dn);
            let inverse = j.try_inverse().unwrap();
            let (mut value, mut gradient) = (Vector3::zeros(), Matrix3::zeros());
            for (a, &node) in element.nodes.iter().enumerate() {
                let u_a = Vector3::new(u[3 * node], u[3 * node + 1], u[3 * node + 2]);
                value += n[a] * u_a;
                gradient += u_a * (inverse.transpose() * Vector3::from(dn[a])).transpose();
            }
            let (exact, slope, _) = manufactured(x, lame);
            let dv = w * j.determinant();
            squares[0] += dv * (value - exact).norm_squared();
            squares[1] += dv * (gradient - slope).norm_squared();
        }
    }
    squares.map(f64::sqrt)
}

#[test]
fn manufactured_solutions_converge_with_the_orders_of_theory() {
    for kind in ElementKind::ALL {
        let cells = match kind {
            ElementKind::Hex8 | ElementKind::Tet4 => [12, 18],
            _ => [6, 9],
        };
        let (coarse, fine) = (errors(kind, cells[0]), errors(kind, cells[1]));
        let ratio = (cells[1] as f64 / cells[0] as f64).ln();
        let order = [0, 1].map(|k| (coarse[k] / fine[k]).ln() / ratio);
        let p = kind.order() as f64;
        println!("{kind:?}: orders {order:?}, errors {fine:?}");
        assert!((order[0] - (p + 1.0)).abs() < 0.1, "{kind:?} in L2: {order:?}");
        assert!((order[1] - p).abs() < 0.1, "{kind:?} in H1: {order:?}");
    }
}
