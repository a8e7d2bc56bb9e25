//! Modes against closed forms and published figures, and the laws every basis obeys.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::f64::consts::TAU;

use crate::bodies::{clamped_table, free_workpiece, workpiece};
use nailnoise_fem::{Constraints, FemError, Material, ModalBasis, ModalSettings, System, assemble, modes};
use nailnoise_meshes::{Block, block};
use nalgebra::{DMatrix, Point3};

fn assert_complete(basis: &ModalBasis) {
    assert_eq!(basis.sturm.count, basis.hz.len());
    assert!(basis.residuals.iter().all(|&r| r < 1e-8), "{:?}", basis.residuals);
    assert!(basis.orthonormality < 1e-8, "{}", basis.orthonormality);
    assert!(basis.hz.windows(2).all(|w| w[0] <= w[1]));
    assert!(basis.hz.iter().all(|&f| f < basis.sturm.upper_hz));
}

fn assert_hz(found: &[f64], expected: &[f64], relative: f64) {
    for (f, e) in found.iter().zip(expected) {
        assert!((f - e).abs() <= relative * e, "{f} Hz against {e} Hz in {found:?}");
    }
    assert!(found.len() >= expected.len());
}

fn elastic(basis: &ModalBasis) -> &[f64] {
    &basis.hz[basis.rigid.iter().filter(|r| **r).count()..]
}

#[test]
fn free_workpiece_has_six_rigid_and_the_known_elastic_modes() {
    let basis = modes(&free_workpiece([20, 8, 5]), &ModalSettings::below(5e3), &|_, _| ()).unwrap();
    assert_complete(&basis);
    assert_eq!(basis.rigid.iter().filter(|r| **r).count(), 6);
    assert!(basis.hz[..6].iter().all(|&f| f == 0.0));
    // 27-node hexahedra, 20 x 8 x 5 against 14 x 6 x 4 within 0.2 %.
    let known = [1483.0, 2261.0, 2700.0, 2707.0, 2991.0, 3027.0, 3139.0, 3185.0, 4035.0];
    assert_hz(elastic(&basis), &known, 0.005);
}

#[test]
fn clamped_worktable_has_the_known_modes() {
    let basis = modes(&clamped_table(0.045), &ModalSettings::below(650.0), &|_, _| ()).unwrap();
    assert_complete(&basis);
    assert!(basis.rigid.iter().all(|r| !r));
    assert_hz(&basis.hz, &[115.0, 115.0, 155.0, 480.0, 583.0, 604.0], 0.01);
}

#[test]
fn a_basis_of_two_decades_keeps_its_residuals_and_the_low_modes() {
    let (wide, narrow) = (
        modes(&clamped_table(0.06), &ModalSettings::below(6e3), &|_, _| ()).unwrap(),
        modes(&clamped_table(0.06), &ModalSettings::below(650.0), &|_, _| ()).unwrap(),
    );
    assert_complete(&wide);
    assert!(wide.hz.len() > 150 && narrow.hz.len() < 10);
    assert_hz(&wide.hz, &narrow.hz, 1e-10);
}

fn isotropic(size: [f64; 3], divisions: [usize; 3], e: f64, nu: f64, rho: f64) -> System {
    let mesh = block(&Block {
        size,
        divisions,
        origin: [0.0; 3],
    })
    .unwrap();
    assemble(&mesh, &[Material::isotropic(e, nu, rho).unwrap()], &Constraints::free()).unwrap()
}

/// A free square plate of thickness h and side L: omega L^2 sqrt(rho h / D) = 13.49 (twice skew to its sides), 19.79,
/// 24.43 for nu = 0.3 (A. W. Leissa, *Vibration of Plates*, NASA SP-160, 1969, table 4.67).
#[test]
fn rigid_modes_of_thin_sheets_are_never_nan() {
    let (e, nu, rho, side) = (210e9_f64, 0.3, 7850.0, 1.0_f64);
    // The thinner a sheet, the larger its stiffness across the thickness, and the rounding of its rigid modes.
    for (thickness, mirrors) in [
        (1e-3_f64, true),
        (1e-3, false),
        (0.5e-3, true),
        (0.5e-3, false),
        (2e-3, true),
    ] {
        let system = isotropic([side, side, thickness], [16, 16, 1], e, nu, rho);
        let scale = (e * thickness * thickness / (12.0 * (1.0 - nu * nu) * rho)).sqrt() / (TAU * side * side);
        let settings = ModalSettings {
            mirrors,
            ..ModalSettings::below(30.0 * scale)
        };
        let basis = modes(&system, &settings, &|_, _| ()).unwrap();
        assert_eq!(basis.sturm.count, basis.hz.len());
        assert!(
            basis.hz.iter().all(|hz| hz.is_finite()),
            "{thickness} m: {:?}",
            basis.hz
        );
        assert!(
            basis
                .rigid
                .iter()
                .zip(&basis.hz)
                .all(|(rigid, hz)| *rigid == (*hz == 0.0))
        );
        assert_eq!(
            basis.rigid.iter().filter(|r| **r).count(),
            6,
            "{thickness} m: {:?}",
            basis.hz
        );
        assert_hz(elastic(&basis), &[13.49, 19.79, 24.43].map(|k| k * scale), 0.02);
    }
}

#[test]
fn free_beam_lies_just_below_euler() {
    // Euler-Bernoulli (beta L)^2 / (2 pi L^2) sqrt(EI / rho A); shear and rotary inertia lower it by 0.03 % at first.
    let basis = modes(
        &isotropic([1.0, 0.02, 0.01], [40, 2, 1], 200e9, 0.0, 8000.0),
        &ModalSettings::below(300.0),
        &|_, _| (),
    );
    let basis = basis.unwrap();
    assert_complete(&basis);
    let (e, rho, l) = (200e9_f64, 8000.0, 1.0);
    for (i, beta_l) in [4.730_040_744_862_704_f64, 7.853_204_624_095_838, 10.995_607_838_001_671]
        .into_iter()
        .enumerate()
    {
        let euler = |h: f64| (beta_l / l).powi(2) / TAU * (e * h * h / (12.0 * rho)).sqrt();
        let expected = euler(0.01);
        let nearest = elastic(&basis)
            .iter()
            .copied()
            .min_by(|a, b| (a - expected).abs().total_cmp(&(b - expected).abs()));
        let ratio = nearest.unwrap() / expected;
        assert!(
            ratio < 1.0 && ratio > 1.0 - 0.0005 * (i as f64 + 1.0).powi(2),
            "mode {i}: {ratio}"
        );
    }
}

#[test]
fn rod_without_poisson_has_the_exact_longitudinal_mode() {
    let basis = modes(
        &isotropic([1.0, 0.05, 0.04], [12, 1, 1], 200e9, 0.0, 8000.0),
        &ModalSettings::below(6e3),
        &|_, _| (),
    )
    .unwrap();
    assert_complete(&basis);
    let expected = (200e9_f64 / 8000.0).sqrt() / 2.0;
    assert!(
        elastic(&basis).iter().any(|f| (f / expected - 1.0).abs() < 1e-5),
        "{:?}",
        basis.hz
    );
}

#[test]
fn cube_has_the_lame_mode_as_a_pair() {
    // f = c_s / (sqrt(2) L) whatever nu; one in each of the three planes; two of them are independent.
    let (l, e, nu, rho) = (0.1, 200e9, 0.3, 8000.0);
    let basis = modes(
        &isotropic([l; 3], [4; 3], e, nu, rho),
        &ModalSettings::below(23e3),
        &|_, _| (),
    )
    .unwrap();
    assert_complete(&basis);
    let c_s = (e / (2.0 * (1.0 + nu)) / rho).sqrt();
    let lame = c_s / (2.0_f64.sqrt() * l);
    assert!((lame - 21_926.450_482_675_73).abs() < 1e-6);
    let near: Vec<f64> = basis
        .hz
        .iter()
        .copied()
        .filter(|f| (f / lame - 1.0).abs() < 1e-3)
        .collect();
    assert_eq!(near.len(), 2, "{:?}", basis.hz);
    assert!(near.windows(2).all(|w| (w[1] / w[0] - 1.0).abs() < 1e-10), "{near:?}");
}

#[test]
fn a_square_prism_returns_its_bending_pairs_as_pairs() {
    let basis = modes(
        &isotropic([0.02, 0.02, 0.2], [2, 2, 8], 200e9, 0.3, 8000.0),
        &ModalSettings::below(20e3),
        &|_, _| (),
    )
    .unwrap();
    assert_complete(&basis);
    let first = &elastic(&basis)[..2];
    assert!((first[1] / first[0] - 1.0).abs() < 1e-10, "{first:?}");
}

#[test]
fn simply_supported_thick_plate_meets_nafems_fv52_on_its_mesh() {
    let (size, divisions) = ([10.0, 10.0, 1.0], [4, 4, 1]);
    let mesh = block(&Block {
        size,
        divisions,
        origin: [-5.0, -5.0, -0.5],
    })
    .unwrap();
    let mut constraints = Constraints::free();
    for (node, p) in mesh.nodes.iter().enumerate() {
        let on_edge = |c: f64| (c.abs() - 5.0).abs() < 1e-9;
        if (p.z + 0.5).abs() < 1e-9 && (on_edge(p.x) || on_edge(p.y)) {
            constraints.hold(node, 2);
        }
    }
    let material = Material::isotropic(200e9, 0.3, 8000.0).unwrap();
    let basis = modes(
        &assemble(&mesh, &[material], &constraints).unwrap(),
        &ModalSettings::below(210.0),
        &|_, _| (),
    )
    .unwrap();
    assert_complete(&basis);
    assert_eq!(basis.rigid.iter().filter(|r| **r).count(), 3);
    // Target for hex20 on this mesh; CalculiX's fully integrated element gives 44.796 first.
    assert_hz(
        elastic(&basis),
        &[44.762, 110.52, 110.52, 169.08, 193.93, 206.64, 206.64],
        0.01,
    );
    assert!((elastic(&basis)[0] - 44.796).abs() < 0.001, "{:?}", basis.hz);
}

#[test]
fn basis_does_not_depend_on_the_threads() {
    // Large enough for a factor of several subtrees.
    let system = free_workpiece([17, 6, 4]);
    let mut loads = DMatrix::zeros(system.equations.dofs(), 1);
    loads[(2, 0)] = 1.0;
    let mut settings = ModalSettings::below(5e3).with_loads(loads);
    settings.mirrors = false;
    let solve = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| modes(&system, &settings, &|_, _| ()).unwrap())
    };
    let one = solve(1);
    assert_eq!(one, solve(2));
    assert_eq!(one, solve(3));
}

#[test]
fn work_is_as_frozen() {
    // At 5 kHz no error is so close to the tolerance that rounding decides on a step.
    let basis = modes(&free_workpiece([10, 4, 3]), &ModalSettings::below(5e3), &|_, _| ()).unwrap();
    insta::assert_json_snapshot!(basis.work);
}

#[test]
fn a_small_basis_restarts_and_finds_the_same_modes() {
    let system = free_workpiece([10, 4, 3]);
    let settings = ModalSettings::below(6e3);
    let (long, short) = (
        modes(&system, &settings, &|_, _| ()).unwrap(),
        modes(
            &system,
            &ModalSettings {
                max_vectors: 100,
                ..settings
            },
            &|_, _| (),
        )
        .unwrap(),
    );
    assert!(short.work.restarts > 0 && long.work.restarts == 0);
    assert_complete(&short);
    assert_hz(elastic(&short), elastic(&long), 1e-11);
}

#[test]
fn blocks_narrower_than_a_multiplicity_still_find_it_all() {
    let system = isotropic([0.02, 0.02, 0.2], [2, 2, 8], 200e9, 0.3, 8000.0);
    let settings = ModalSettings {
        block: 1,
        ..ModalSettings::below(10e3)
    };
    let basis = modes(&system, &settings, &|_, _| ()).unwrap();
    assert_complete(&basis);
    assert_hz(
        &basis.hz[6..],
        &modes(&system, &ModalSettings::below(10e3), &|_, _| ()).unwrap().hz[6..],
        1e-10,
    );
}

#[test]
fn a_body_smaller_than_the_blocks_is_solved_exactly() {
    // 60 degrees of freedom, all modes wanted: the basis fills the space.
    let system = isotropic([0.1; 3], [1; 3], 200e9, 0.3, 8000.0);
    let basis = modes(&system, &ModalSettings::below(1e6), &|_, _| ()).unwrap();
    assert_eq!(basis.hz.len(), 60);
    assert_complete(&basis);
}

#[test]
fn no_mode_below_the_edge_is_an_empty_basis() {
    let basis = modes(&clamped_table(0.09), &ModalSettings::below(10.0), &|_, _| ()).unwrap();
    assert!(basis.hz.is_empty() && basis.sturm.count == 0);
}

#[test]
fn an_edge_on_a_mode_moves_up_and_takes_it_in() {
    let system = free_workpiece([8, 3, 2]);
    let first = modes(&system, &ModalSettings::below(2e3), &|_, _| ()).unwrap();
    assert_eq!(first.hz.len(), 7);
    let on_it = modes(&system, &ModalSettings::below(first.hz[6]), &|_, _| ()).unwrap();
    assert!(on_it.sturm.upper_hz > first.hz[6] && on_it.sturm.upper_hz < 1.01 * first.hz[6]);
    assert_eq!(on_it.hz.len(), 7);
}

#[test]
fn a_mode_just_above_the_edge_leaves_the_lower_ones_their_residuals() {
    let system = free_workpiece([10, 4, 3]);
    let settings = ModalSettings::below(6e3);
    let all = modes(&system, &settings, &|_, _| ()).unwrap();
    for above in [12, 20, 30] {
        let below = ModalSettings {
            top_hz: all.hz[above] * (1.0 - 5e-4),
            ..settings.clone()
        };
        let basis = modes(&system, &below, &|_, _| ()).unwrap();
        assert_complete(&basis);
        assert_eq!((above, basis.sturm.upper_hz), (above, below.top_hz));
        let expected: Vec<f64> = all
            .hz
            .iter()
            .copied()
            .filter(|&hz| 0.0 < hz && hz < below.top_hz)
            .collect();
        assert_hz(elastic(&basis), &expected, 1e-11);
    }
}

#[test]
fn modes_and_corrections_give_the_static_deflection() {
    // u = K^-1 f at the loaded point of a clamped body is the sum over modes and corrections of (phi^T f)^2 / lambda.
    let mesh = workpiece([8, 3, 2]);
    let constraints = Constraints::clamped(&mesh, "x_min").unwrap();
    let system = assemble(&mesh, &[crate::bodies::pine_block()], &constraints).unwrap();
    let at = mesh.locate_on("top", Point3::new(0.31, 0.05, 0.09525), 1e-9).unwrap();
    let mut load = DMatrix::zeros(3 * mesh.nodes.len(), 1);
    at.nodes
        .iter()
        .zip(&at.weights)
        .for_each(|(n, w)| load[(3 * n + 2, 0)] = *w);
    let flexibility = |basis: &ModalBasis| -> f64 {
        basis
            .all_hz()
            .iter()
            .zip(basis.shapes.column_iter())
            .map(|(f, phi)| (phi.dot(&load.column(0)) / (TAU * f)).powi(2))
            .sum()
    };
    let f = system.equations.restrict(&load).unwrap();
    let mut k = DMatrix::zeros(f.nrows(), f.nrows());
    system
        .stiffness
        .triplet_iter()
        .for_each(|(i, j, value)| k[(i, j)] = *value);
    k.fill_upper_triangle_with_lower_triangle();
    let exact = k.cholesky().unwrap().solve(&f).dot(&f);
    let truncated = modes(&system, &ModalSettings::below(4e3), &|_, _| ()).unwrap();
    let corrected = modes(&system, &ModalSettings::below(4e3).with_loads(load.clone()), &|_, _| ()).unwrap();
    let (without, with) = (flexibility(&truncated) / exact, flexibility(&corrected) / exact);
    assert!(without < 0.9, "the modes alone carry {without}");
    assert!((with - 1.0).abs() < 1e-6, "with the correction {with}");
    assert!(corrected.corrections[0] > 4e3);
}

#[test]
fn corrections_are_orthogonal_to_the_modes_and_to_each_other() {
    let system = free_workpiece([8, 3, 2]);
    let n = system.equations.dofs();
    let mut loads = DMatrix::zeros(n, 4);
    loads[(2, 0)] = 1.0;
    loads[(30, 1)] = 1.0;
    loads[(301, 2)] = 1.0;
    // A load that depends on the others adds no shape.
    let sum = loads.column(0) + loads.column(1) * 2.0;
    loads.set_column(3, &sum);
    let basis = modes(&system, &ModalSettings::below(4e3).with_loads(loads), &|_, _| ()).unwrap();
    assert_eq!(basis.corrections.len(), 3);
    let phi = system.equations.restrict(&basis.shapes).unwrap();
    let product = |a: &nalgebra_sparse::CscMatrix<f64>| {
        let mut y = DMatrix::zeros(phi.nrows(), phi.ncols());
        for (i, j, value) in a.triplet_iter() {
            for c in 0..phi.ncols() {
                y[(i, c)] += value * phi[(j, c)];
                if i != j {
                    y[(j, c)] += value * phi[(i, c)];
                }
            }
        }
        phi.transpose() * y
    };
    let mass = product(&system.mass);
    let stiffness = product(&system.stiffness);
    let lambda = DMatrix::from_diagonal(
        &basis
            .all_hz()
            .iter()
            .map(|f| (TAU * f).powi(2))
            .collect::<Vec<_>>()
            .into(),
    );
    assert!((mass - DMatrix::identity(phi.ncols(), phi.ncols())).amax() < 1e-8);
    assert!((stiffness - &lambda).amax() < 1e-8 * lambda.amax());
}

#[test]
fn unusable_requests_are_refused() {
    let system = free_workpiece([1, 1, 1]);
    assert!(matches!(
        modes(&system, &ModalSettings::below(0.0), &|_, _| ()),
        Err(FemError::NotPositive { .. })
    ));
    assert!(matches!(
        modes(&system, &ModalSettings::below(f64::NAN), &|_, _| ()),
        Err(FemError::NotPositive { .. })
    ));
    let loads = DMatrix::zeros(5, 1);
    assert!(matches!(
        modes(&system, &ModalSettings::below(1e3).with_loads(loads), &|_, _| ()),
        Err(FemError::LoadRows { .. })
    ));
}
