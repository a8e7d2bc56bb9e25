//! Coarser surfaces: their agreement with the finer one, and their radiation.

use crate::boundary_meshes::{cuboid, octants, sphere};
use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::{Boundary, BoundaryMesh, Exterior, Parity, Patterns};
use nailnoise_acoustics::radiation::boundary_elements::{MeshRange, SurfaceFit};
use nalgebra::{Complex, DMatrix, Vector3};
use std::f64::consts::PI;

/// V = 1/3 closed integral of x . n dS.
fn volume(boundary: &Boundary) -> f64 {
    let mut sum = 0.0;
    for_points(boundary, |_, x, area| sum += x.dot(&area) / 3.0);
    sum
}

/// Calls `each` with panel, position and area vector times weight at the points of a fine rule.
fn for_points(boundary: &Boundary, mut each: impl FnMut(usize, Vector3<f64>, Vector3<f64>)) {
    let mesh = boundary.mesh();
    let rule = nailnoise_meshes::FaceKind::rule;
    for (p, panel) in mesh.panels.iter().enumerate() {
        for (xi, w) in rule(panel.kind(), 4).unwrap() {
            let point = mesh.point_at(p, xi);
            each(p, point.position.coords, point.area_vector() * w);
        }
    }
}

/// Volume flow and its first moments, int v dS and int v x dS, of every pattern.
fn moments(boundary: &Boundary, velocities: &DMatrix<f64>) -> Vec<[f64; 4]> {
    let mut result = vec![[0.0; 4]; velocities.ncols()];
    let mesh = boundary.mesh();
    let mut first = 0;
    for (p, panel) in mesh.panels.iter().enumerate() {
        let corners = panel.corners().len();
        let linear = if corners == 3 {
            nailnoise_meshes::FaceKind::Tri3
        } else {
            nailnoise_meshes::FaceKind::Quad4
        };
        for (xi, w) in panel.kind().rule(4).unwrap() {
            let point = mesh.point_at(p, xi);
            let dw = w * point.area_vector().norm();
            let (mut n, mut dn) = ([0.0; 9], [[0.0; 2]; 9]);
            linear.shape(xi, &mut n, &mut dn);
            for (m, sums) in result.iter_mut().enumerate() {
                let v: f64 = (0..corners).map(|j| n[j] * velocities[(first + j, m)]).sum();
                sums[0] += dw * v;
                (0..3).for_each(|axis| sums[1 + axis] += dw * v * point.position[axis]);
            }
        }
        first += corners;
    }
    result
}

/// Vertices less edges plus faces of a closed surface of triangles.
fn euler(boundary: &Boundary) -> i64 {
    let faces = boundary.mesh().panels.len() as i64;
    boundary.nodes() as i64 - 3 * faces / 2 + faces
}

/// Three patterns: pulsation, oscillation along z, and a wave shorter than the body.
fn patterns(boundary: &Boundary) -> DMatrix<f64> {
    boundary.project(3, |_, _, point, v| {
        let n = point.area_vector().normalize();
        v[0] = 1.0;
        v[1] = n.z;
        v[2] = n.x * (3.0 * point.position.z).sin();
    })
}

/// Power of every pattern at ka.
fn powers(boundary: &Boundary, velocities: &DMatrix<f64>, ka: f64) -> Vec<f64> {
    let problem = Exterior::new(boundary.clone(), &Air::default());
    let problem = problem.with_panels_per_wavelength(1.0).unwrap();
    let two = problem
        .resistance(ka * Air::default().sound_speed / (2.0 * PI), velocities)
        .unwrap();
    two.far_field.diagonal().iter().copied().collect()
}

fn in_db(found: &[f64], exact: &[f64]) -> Vec<f64> {
    found.iter().zip(exact).map(|(a, b)| 10.0 * (a / b).log10()).collect()
}

#[test]
fn a_quarter_of_the_panels_of_a_sphere_radiate_the_same_power() {
    let fine = Boundary::new(sphere(1.0, 9, true), None).unwrap();
    let coarse = fine.coarsened(0.42).unwrap();
    let count = coarse.mesh().panels.len();
    println!("{count} panels, volume {:e}", volume(&coarse) / volume(&fine) - 1.0);
    assert!((200..450).contains(&count), "{count}");
    assert_eq!(euler(&coarse), 2);
    assert_eq!(coarse.repairs().flipped, 0);
    assert!(coarse.mesh().longest_edge() <= 0.42);
    assert!((volume(&coarse) / volume(&fine) - 1.0).abs() < 2e-4);
    let (v, u) = (patterns(&fine), coarse.project_from(&fine, &patterns(&fine)).unwrap());
    let (before, after) = (moments(&fine, &v), moments(&coarse, &u));
    for (m, (a, b)) in before.iter().zip(&after).enumerate() {
        println!("pattern {m}: {a:?} -> {b:?}");
        assert!((a[0] - b[0]).abs() < 1e-8, "flow of pattern {m}: {} {}", a[0], b[0]);
        for axis in 1..4 {
            assert!((a[axis] - b[axis]).abs() < 2e-3, "moment of pattern {m}: {a:?} {b:?}");
        }
    }
    // As many flat triangles with their corners on the sphere lose volume and power.
    let flat = Boundary::new(sphere(1.0, 4, false), None).unwrap();
    let flat_v = patterns(&flat);
    for ka in [0.1, 0.5, 1.0, 2.0] {
        let exact = powers(&fine, &v, ka);
        let errors = in_db(&powers(&coarse, &u, ka), &exact);
        let of_flat = in_db(&powers(&flat, &flat_v, ka), &exact);
        println!(
            "ka {ka}: {errors:.4?} dB, {} flat triangles {of_flat:.4?} dB",
            flat.mesh().panels.len()
        );
        for (own, flat) in errors.iter().zip(&of_flat) {
            assert!(
                own.abs() < 0.02 && own.abs() < 0.2 * flat.abs(),
                "ka {ka}: {errors:?} {of_flat:?}"
            );
        }
    }
}

/// Root mean square over a sphere of what interpolation between two of its meshes changes of every pattern \[-\].
fn changed(from: usize, to: usize) -> Vec<f64> {
    let [other, own] = [from, to].map(|n| Boundary::new(sphere(1.0, n, true), None).unwrap());
    let (expected, found) = (patterns(&own), own.interpolate_from(&other, &patterns(&other)).unwrap());
    let norms =
        (0..expected.ncols()).map(|m| (found.column(m) - expected.column(m)).norm() / expected.column(m).norm());
    norms.collect()
}

#[test]
fn velocities_on_another_mesh_of_a_sphere_have_an_error_of_second_order() {
    let (coarse, fine) = (changed(5, 7), changed(10, 14));
    println!("{coarse:?} {fine:?}");
    assert!(coarse[0] < 1e-12 && fine[0] < 1e-12, "a constant stays");
    for m in [1, 2] {
        let order = (coarse[m] / fine[m]).log2();
        assert!(order > 1.8, "pattern {m}: {order}");
    }
}

/// A sphere in the motion of [`patterns`].
fn moving_sphere(n: usize) -> MeshRange {
    let boundary = Boundary::new(sphere(1.0, n, true), None).unwrap();
    let patterns = Patterns {
        parity: Parity::default(),
        velocities: patterns(&boundary),
    };
    MeshRange {
        problem: Exterior::new(boundary, &Air::default()),
        top_hz: 100.0,
        patterns: vec![patterns],
    }
}

#[test]
fn what_a_fit_lacks_between_two_meshes_of_a_surface_is_of_second_order() {
    let lacking = |known, body| {
        SurfaceFit::new(&moving_sphere(known), &moving_sphere(body))
            .unwrap()
            .residuals()
    };
    let (coarse, fine) = (lacking(5, 7), lacking(10, 14));
    println!("{coarse:?} {fine:?}");
    for m in [1, 2] {
        let order = (coarse[m] / fine[m]).log2();
        assert!(order > 1.8 && fine[m] < 0.02, "pattern {m}: {order}, {}", fine[m]);
    }
}

#[test]
fn velocities_stay_on_panels_that_two_meshes_share_and_are_not_taken_to_another_surface() {
    let sphere_of = |radius| Boundary::new(sphere(radius, 6, true), None).unwrap();
    let own = sphere_of(1.0);
    let v = patterns(&own);
    assert!((own.interpolate_from(&own, &v).unwrap() - &v).amax() < 1e-12);
    assert!(own.interpolate_from(&sphere_of(1.2), &v).is_none());
}

#[test]
fn a_box_keeps_its_sharp_edges_and_patches() {
    for quads in [false, true] {
        let fine = Boundary::new(cuboid([0.0; 3], [0.4, 0.3, 0.2], 0.025, quads), None).unwrap();
        let coarse = fine.coarsened(0.1).unwrap();
        let (few, many) = (coarse.mesh().panels.len(), fine.mesh().panels.len());
        println!("{many} -> {few} panels");
        assert!(few < many / 3);
        assert_eq!(euler(&coarse), 2);
        assert!((volume(&coarse) - 0.024).abs() < 1e-12);
        let mut areas = [0.0; 6];
        for_points(&coarse, |p, _, area| {
            areas[coarse.mesh().panels[p].patch] += area.norm()
        });
        for (found, exact) in areas.iter().zip([0.06, 0.06, 0.08, 0.08, 0.12, 0.12]) {
            assert!((found - exact).abs() < 1e-12, "{areas:?}");
        }
        let velocities = fine.project(2, |panel, _, point, v| {
            let top = fine.mesh().panels[panel].patch == 5;
            v[0] = point.area_vector().normalize().z;
            v[1] = f64::from(u8::from(top)) * (2.0 * PI * point.position.x / 0.4).cos();
        });
        let carried = coarse.project_from(&fine, &velocities).unwrap();
        for (a, b) in moments(&fine, &velocities).iter().zip(moments(&coarse, &carried)) {
            assert!((a[0] - b[0]).abs() < 1e-12);
            assert!((1..4).all(|axis| (a[axis] - b[axis]).abs() < 1e-4), "{a:?} {b:?}");
        }
        // Patterns that move only the top move nothing else.
        let mut row = 0;
        for panel in &coarse.mesh().panels {
            let still = (0..3).all(|k| carried[(row + k, 1)] == 0.0);
            assert!(still || panel.patch == 5);
            row += 3;
        }
    }
}

/// z_0 of the pulsating sphere, see `bem_sphere.rs`.
fn pulsating(x: f64) -> f64 {
    (Complex::i() * x / (1.0 + Complex::<f64>::i() * x)).re
}

#[test]
fn a_coarsened_body_keeps_its_contact_with_the_floor() {
    let half = octants(&[[1, 1, 1], [-1, 1, 1], [1, -1, 1], [-1, -1, 1]], 12, false);
    let fine = Boundary::new(half, Some(0.0)).unwrap();
    let coarse = fine.coarsened(0.42).unwrap();
    let (few, many) = (coarse.mesh().panels.len(), fine.mesh().panels.len());
    println!("{many} -> {few} panels");
    assert!(few < many / 2 && coarse.stands_on_floor());
    let v = fine.project(1, |_, _, _, v| v[0] = 1.0);
    let u = coarse.project_from(&fine, &v).unwrap();
    for ka in [0.2, 1.0, 2.0] {
        let exact = Air::default().impedance() * 2.0 * PI * pulsating(ka);
        let error = in_db(&powers(&coarse, &u, ka), &[exact])[0];
        println!("ka {ka}: {error:.4} dB");
        assert!(error.abs() < 0.01, "{error}");
    }
}

/// The surface depends only on its mesh, and so do its numbers.
#[test]
fn coarsening_is_reproducible() {
    let coarse = || {
        let fine = Boundary::new(sphere(1.0, 6, true), None).unwrap();
        let coarse = fine.coarsened(0.5).unwrap();
        let carried = coarse.project_from(&fine, &patterns(&fine)).unwrap();
        let mesh: BoundaryMesh = coarse.mesh().clone();
        (mesh.points, carried)
    };
    let (first, second) = (coarse(), coarse());
    assert_eq!(first.0, second.0);
    assert_eq!(first.1, second.1);
}
