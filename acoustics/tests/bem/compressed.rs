//! The compressed matrix against closed forms and against the dense matrix.

use crate::boundary_meshes::{cuboid, octants, sphere};
use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::{Boundary, BoundaryMesh, EquationSolver, Exterior, Parity, Patterns};
use nalgebra::DMatrix;
use std::f64::consts::PI;

fn with(solver: EquationSolver, boundary: &Boundary) -> Exterior {
    Exterior::new(boundary.clone(), &Air::default())
        .with_panels_per_wavelength(4.0)
        .unwrap()
        .with_equation_solver(solver)
}

/// Waves of various directions and wavelengths along the surface.
fn waves(boundary: &Boundary, patterns: usize, k: f64) -> DMatrix<f64> {
    boundary.project(patterns, |_, _, point, v| {
        let [x, y, z] = point.position.into();
        for (m, v) in v.iter_mut().enumerate() {
            let (sine, cosine) = (m as f64).sin_cos();
            let k = 2.0 * k * (m + 1) as f64 / patterns as f64;
            *v = (k * (x * cosine + y * sine + 0.3 * z)).cos();
        }
    })
}

/// Largest difference between the powers of the patterns by the two matrices \[dB\], and that of the pressures relative
/// to their norm.
fn differences(boundary: &Boundary, hz: f64, patterns: &[Patterns]) -> [f64; 2] {
    let [dense, compressed] = [EquationSolver::Dense, EquationSolver::Compressed].map(|s| with(s, boundary));
    let [exact, found] = [&dense, &compressed].map(|p| p.solve_parities(hz, patterns).unwrap());
    let [r_exact, r_found] = [&dense, &compressed].map(|p| p.resistance_parities(hz, patterns).unwrap());
    let mut worst = [0.0f64; 2];
    for parity in 0..patterns.len() {
        let [a, b] = [&r_exact[parity].far_field, &r_found[parity].far_field];
        for m in 0..a.nrows() {
            worst[0] = worst[0].max((10.0 * (b[(m, m)] / a[(m, m)]).log10()).abs());
        }
        let [a, b] = [&exact[parity].pressure, &found[parity].pressure];
        worst[1] = worst[1].max((a - b).norm() / a.norm());
    }
    worst
}

fn even(boundary: &Boundary, hz: f64) -> [Patterns; 1] {
    let k = 2.0 * PI * hz / Air::default().sound_speed;
    [Patterns {
        parity: Parity::default(),
        velocities: waves(boundary, 8, k),
    }]
}

#[test]
fn a_box_above_the_floor_radiates_as_with_the_dense_matrix() {
    for (quads, low) in [(false, 0.1), (true, 0.0)] {
        let mesh = cuboid([0.0, 0.0, low], [0.5, 0.4, low + 0.3], 0.03, quads);
        let boundary = Boundary::new(mesh, Some(0.0)).unwrap();
        let top = boundary.highest_hz(Air::default().sound_speed, 5.0);
        for hz in [80.0, 0.4 * top, top] {
            let [power, pressure] = differences(&boundary, hz, &even(&boundary, hz));
            println!("quads {quads}, {low} m, {hz:.0} Hz: {power:.1e} dB, pressure {pressure:.1e}");
            assert!(power < 0.01 && pressure < 1e-3);
        }
    }
}

/// Cavities take more steps than convex bodies.
#[test]
fn a_cats_eye_radiates_as_with_the_dense_matrix() {
    let all = [1, -1].map(|x| [1, -1].map(|y| [1, -1].map(|z| [x, y, z])));
    let seven: Vec<[i32; 3]> = all
        .into_iter()
        .flatten()
        .flatten()
        .filter(|&s| s != [1, 1, 1])
        .collect();
    let boundary = Boundary::new(octants(&seven, 14, true), None).unwrap();
    let hz = boundary.highest_hz(Air::default().sound_speed, 5.0);
    let [power, pressure] = differences(&boundary, hz, &even(&boundary, hz));
    println!(
        "{} unknowns, {hz:.0} Hz: {power:.1e} dB, pressure {pressure:.1e}",
        boundary.nodes()
    );
    assert!(power < 0.01 && pressure < 1e-3);
}

/// Slots half a panel wide between three slabs, above the floor: distant clusters on either side of a slot.
#[test]
fn slabs_with_narrow_slots_radiate_as_with_the_dense_matrix() {
    let mut mesh = BoundaryMesh::default();
    for layer in 0..3 {
        let low = 0.1 + 0.035 * f64::from(layer);
        let slab = cuboid([0.0, 0.0, low], [0.5, 0.4, low + 0.02], 0.03, false);
        let first = mesh.points.len();
        mesh.points.extend(slab.points);
        mesh.patches = slab.patches;
        mesh.panels.extend(slab.panels.iter().map(|p| {
            let nodes: Vec<usize> = p.nodes().iter().map(|n| n + first).collect();
            nailnoise_acoustics::bem::Panel::new(p.kind(), &nodes, p.patch).unwrap()
        }));
    }
    let boundary = Boundary::new(mesh, Some(0.0)).unwrap();
    let hz = boundary.highest_hz(Air::default().sound_speed, 6.0);
    let [power, pressure] = differences(&boundary, hz, &even(&boundary, hz));
    println!(
        "{} unknowns, {hz:.0} Hz: {power:.1e} dB, pressure {pressure:.1e}",
        boundary.nodes()
    );
    assert!(power < 0.01 && pressure < 1e-3);
}

#[test]
fn all_parities_of_a_quarter_radiate_as_with_the_dense_matrix() {
    let mesh = cuboid([0.0, 0.0, 0.0], [0.4, 0.3, 0.5], 0.03, true);
    let boundary = Boundary::symmetric(mesh, [Some(0.0); 2], Some(0.0)).unwrap();
    let hz = boundary.highest_hz(Air::default().sound_speed, 6.0);
    let k = 2.0 * PI * hz / Air::default().sound_speed;
    let of_parity = |parity: Parity| {
        let mut velocities = waves(&boundary, 4, k);
        let odd = boundary.project(1, |_, _, point, v| {
            let x = if parity.odd_x { point.position.x } else { 1.0 };
            v[0] = if parity.odd_y { point.position.y * x } else { x };
        });
        velocities
            .column_iter_mut()
            .for_each(|mut v| v.component_mul_assign(&odd));
        Patterns { parity, velocities }
    };
    let patterns: Vec<Patterns> = Parity::all([true; 2]).into_iter().map(of_parity).collect();
    let [power, pressure] = differences(&boundary, hz, &patterns);
    println!("{} unknowns: {power:.1e} dB, pressure {pressure:.1e}", boundary.nodes());
    assert!(power < 0.01 && pressure < 1e-3);
}

/// R = rho c S (ka)²/(1 + (ka)²) of a pulsating sphere, rho c S/3 (ka)^4/(4 + (ka)^4) of an oscillating one.
#[test]
fn a_sphere_radiates_its_exact_power() {
    let (air, a) = (Air::default(), 0.3);
    let boundary = Boundary::new(sphere(a, 12, true), None).unwrap();
    let problem = with(EquationSolver::Compressed, &boundary);
    let v = boundary.project(2, |_, _, point, v| {
        (v[0], v[1]) = (1.0, point.area_vector().normalize().z)
    });
    let scale = air.impedance() * 4.0 * PI * a * a;
    for hz in [60.0, 400.0, 1000.0] {
        let ka = 2.0 * PI * hz / air.sound_speed * a;
        let exact = [ka.powi(2) / (1.0 + ka.powi(2)), ka.powi(4) / (4.0 + ka.powi(4)) / 3.0];
        let found = problem.resistance(hz, &v).unwrap().far_field;
        for m in 0..2 {
            let off = found[(m, m)] / (scale * exact[m]) - 1.0;
            println!("ka {ka:.2}, {m}: {off:.1e}");
            assert!(off.abs() < 1e-3);
        }
    }
}

/// Dependent patterns add no directions; a pattern of zeros has zero pressure.
#[test]
fn dependent_patterns_are_solved_as_sums() {
    let boundary = Boundary::new(cuboid([0.0; 3], [0.4, 0.3, 0.3], 0.04, false), None).unwrap();
    let problem = with(EquationSolver::Compressed, &boundary);
    let two = waves(&boundary, 2, 5.0);
    let mut v = DMatrix::zeros(two.nrows(), 4);
    v.columns_mut(0, 2).copy_from(&two);
    v.set_column(2, &(two.column(0) * 3.0 - two.column(1)));
    let p = problem.solve(700.0, &v).unwrap().pressure;
    let three = nalgebra::Complex::from(3.0);
    let off = (p.column(2) - (p.column(0) * three - p.column(1))).norm() / p.column(2).norm();
    println!("{off:.1e}");
    assert!(off < 3e-4);
    assert_eq!(p.column(3).norm(), 0.0);
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let boundary = Boundary::new(cuboid([0.0; 3], [0.4, 0.3, 0.3], 0.04, false), None).unwrap();
    let v = waves(&boundary, 5, 5.0);
    let solve = || {
        with(EquationSolver::Compressed, &boundary)
            .solve(700.0, &v)
            .unwrap()
            .pressure
    };
    let outside = solve();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(outside, pool.install(solve));
}

/// Small surfaces are cheaper with the dense matrix.
#[test]
fn the_way_is_chosen_by_cost() {
    let chosen = |edge: f64| {
        let boundary = Boundary::new(cuboid([0.0; 3], [1.0, 0.8, 0.6], edge, true), None).unwrap();
        let estimate = Exterior::new(boundary, &Air::default()).estimate();
        println!("{estimate}");
        (estimate.unknowns, estimate.compressed)
    };
    let (small, large) = (chosen(0.08), chosen(0.02));
    assert!(small.0 < 1000 && !small.1, "{small:?}");
    assert!(large.0 > 8000 && large.1, "{large:?}");
}
