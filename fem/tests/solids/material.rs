//! Elastic constants: refused values, rotation of the axes.

use nailnoise_fem::{FemError, Material, Orthotropic};
use nalgebra::{Matrix3, Matrix6, Rotation3, Vector3};

#[test]
fn isotropic_stiffness_is_that_of_lame() {
    let (e, nu) = (210e9, 0.3);
    let material = Material::isotropic(e, nu, 7850.0).unwrap();
    let (lambda, mu) = (e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu)));
    let mut c = Matrix6::from_diagonal(&[2.0 * mu, 2.0 * mu, 2.0 * mu, mu, mu, mu].into());
    c.fixed_view_mut::<3, 3>(0, 0).add_scalar_mut(lambda);
    assert!((material.stiffness() - c).amax() < 1e-12 * e);
    assert!((material.slowest_speed() - (mu / 7850.0).sqrt()).abs() < 1e-9);
}

#[test]
fn isotropic_stiffness_does_not_depend_on_the_axes() {
    let constants = Orthotropic {
        e1: 1e9,
        e2: 1e9,
        e3: 1e9,
        g12: 1e9 / 2.5,
        g13: 1e9 / 2.5,
        g23: 1e9 / 2.5,
        nu12: 0.25,
        nu13: 0.25,
        nu23: 0.25,
    };
    let turned = Rotation3::from_euler_angles(0.3, -0.8, 1.1).into_inner();
    let a = Material::orthotropic(&constants, &turned, 1.0).unwrap();
    let b = Material::isotropic(1e9, 0.25, 1.0).unwrap();
    assert!((a.stiffness() - b.stiffness()).amax() < 1e-6);
}

#[test]
fn compliance_along_a_material_axis_is_one_over_its_modulus() {
    // The block's x = L, y = T, z = R.
    let s = crate::bodies::pine_block().stiffness().try_inverse().unwrap();
    let pine = crate::bodies::PINE;
    let expected = [
        ((0, 0), 1.0 / pine.e1),
        ((1, 1), 1.0 / pine.e3),
        ((2, 2), 1.0 / pine.e2),
        ((3, 3), 1.0 / pine.g23),
        ((4, 4), 1.0 / pine.g12),
        ((5, 5), 1.0 / pine.g13),
        ((0, 1), -pine.nu13 / pine.e1),
        ((0, 2), -pine.nu12 / pine.e1),
        ((1, 2), -pine.nu23 / pine.e2),
    ];
    for ((i, j), value) in expected {
        assert!(
            (s[(i, j)] - value).abs() < 1e-9 * value.abs(),
            "{i} {j}: {} against {value}",
            s[(i, j)]
        );
    }
    // A quarter turn about L swaps R and T.
    let axes = Matrix3::from_columns(&[Vector3::x(), Vector3::y(), Vector3::z()]);
    let swapped = Material::orthotropic(&pine, &axes, 429.46)
        .unwrap()
        .stiffness()
        .try_inverse()
        .unwrap();
    assert!((swapped[(1, 1)] - 1.0 / pine.e2).abs() < 1e-9 / pine.e2);
}

#[test]
fn a_modulus_or_density_that_is_not_positive_is_refused() {
    for (modulus, density) in [(-1.0, 1.0), (1e9, f64::NAN)] {
        let found = Material::isotropic(modulus, 0.3, density);
        assert!(matches!(found, Err(FemError::NotPositive { .. })), "{found:?}");
    }
}

#[test]
fn a_poisson_ratio_without_positive_energy_is_refused() {
    for nu in [0.5, -1.5] {
        let found = Material::isotropic(1e9, nu, 1.0);
        assert!(matches!(found, Err(FemError::NotPositiveDefinite { .. })), "{found:?}");
    }
    // With nu_12 = sqrt(E_1 / E_2) some strain stores no energy.
    let wood = crate::bodies::PINE;
    let soft = Orthotropic {
        nu12: (wood.e1 / wood.e2).sqrt(),
        ..wood
    };
    let found = Material::orthotropic(&soft, &Matrix3::identity(), 1.0);
    assert!(matches!(found, Err(FemError::NotPositiveDefinite { .. })), "{found:?}");
}

#[test]
fn axes_that_are_not_orthonormal_are_refused() {
    let skew = Matrix3::from_columns(&[Vector3::x(), Vector3::y(), Vector3::new(0.0, 0.6, 0.9)]);
    let found = Material::orthotropic(&crate::bodies::PINE, &skew, 1.0);
    assert!(matches!(found, Err(FemError::Axes { .. })), "{found:?}");
}
