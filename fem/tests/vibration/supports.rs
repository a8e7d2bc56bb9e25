//! Sand and contact grids.
#![allow(clippy::unwrap_used)] // a test may panic, in its helpers too

use nailnoise_fem::vibration::supports::{
    ContactGrid, GridRule, RectangularBase, Sand, contact_dashpot, sand_shear_modulus_angular, sand_shear_modulus_round,
};
use proptest::prelude::*;

fn close(value: f64, expected: f64, relative: f64) {
    assert!(
        (value / expected - 1.0).abs() < relative,
        "{value:e} instead of {expected:e}"
    );
}

/// The block of 406.4 x 152.4 mm in sand of 20 MPa, 1600 kg/m3, nu 0.3.
fn buried() -> (Sand, RectangularBase) {
    (
        Sand::new(20e6, 1600.0, 0.3).unwrap(),
        RectangularBase::new(0.4064, 0.1524).unwrap(),
    )
}

#[test]
fn the_buried_block_has_its_published_stiffness() {
    let (sand, base) = buried();
    let k = base.stiffness(&sand);
    close(k.z, 1.76e7, 5e-3);
    close(k.x, 1.37e7, 5e-3);
    close(k.y, 1.49e7, 5e-3);
    close(base.normal_bedding(&sand), 2.8e8, 2e-2);
    close(base.equivalent_radius(), 0.140, 5e-3);
}

#[test]
fn the_dashpots_of_sand_are_density_times_wave_speed() {
    let (sand, _) = buried();
    close(sand.shear_speed(), 112.0, 5e-3);
    close(sand.normal_dashpot(), 2.8e5, 2e-2);
    close(sand.shear_dashpot(), 1600.0 * 111.8, 1e-3);
}

#[test]
fn shear_bedding_times_area_is_the_shear_stiffness() {
    let (sand, base) = buried();
    let k = base.stiffness(&sand);
    let (x, y) = base.shear_bedding(&sand);
    close(x * base.area(), k.x, 1e-12);
    close(y * base.area(), k.y, 1e-12);
}

#[test]
fn a_half_space_is_stiffer_in_rocking_than_a_uniform_bedding() {
    // A half-space is stiffer towards the edges.
    let (sand, base) = buried();
    let (k, bedding) = (base.stiffness(&sand), base.normal_bedding(&sand));
    assert!(k.rocking_x > bedding * 0.4064 * 0.1524f64.powi(3) / 12.0);
    assert!(k.rocking_y > bedding * 0.1524 * 0.4064f64.powi(3) / 12.0);
}

/// A base of 0.2 x 0.2 m on the same sand.
fn square() -> RectangularBase {
    RectangularBase::new(0.2, 0.2).unwrap()
}

#[test]
fn a_square_base_has_the_same_stiffness_in_both_directions() {
    let k = square().stiffness(&buried().0);
    close(k.x, k.y, 1e-12);
    close(k.rocking_x, k.rocking_y, 1e-12);
}

/// K_z = 4 G a/(1 - nu), K_x = 8 G a/(2 - nu), K_t = 16/3 G a^3.
#[test]
fn a_square_base_is_about_as_stiff_as_a_disc_of_its_area() {
    let k = square().stiffness(&buried().0);
    let a = square().equivalent_radius();
    close(k.z, 4.0 * 20e6 * a / 0.7, 0.1);
    close(k.x, 8.0 * 20e6 * a / 1.7, 0.1);
    close(k.torsion, 16.0 / 3.0 * 20e6 * a.powi(3), 0.2);
}

/// e = 0.6, p' = 4 kPa: 6900 (1.57)^2/1.6 2 and 3230 (2.37)^2/1.6 2 kPa.
#[test]
fn the_shear_modulus_of_sand_follows_its_published_formulas() {
    close(sand_shear_modulus_round(0.6, 4e3).unwrap(), 21.26e6, 1e-3);
    close(sand_shear_modulus_angular(0.6, 4e3).unwrap(), 22.68e6, 1e-3);
}

#[test]
fn the_shear_modulus_grows_with_the_root_of_the_pressure_and_with_density() {
    let modulus = |void_ratio, pressure| sand_shear_modulus_round(void_ratio, pressure).unwrap();
    close(modulus(0.6, 16e3), 2.0 * modulus(0.6, 4e3), 1e-12);
    assert!(modulus(0.5, 4e3) > modulus(0.7, 4e3));
}

#[test]
fn a_sand_or_base_outside_the_range_of_its_formula_is_refused() {
    for error in [
        sand_shear_modulus_round(0.9, 4e3).unwrap_err(),
        sand_shear_modulus_round(f64::NAN, 4e3).unwrap_err(),
        sand_shear_modulus_angular(0.5, 4e3).unwrap_err(),
        sand_shear_modulus_angular(0.8, 0.0).unwrap_err(),
        Sand::new(20e6, 1600.0, 0.5).unwrap_err(),
        Sand::new(-1.0, 1600.0, 0.3).unwrap_err(),
        RectangularBase::new(0.1, 0.2).unwrap_err(),
    ] {
        assert!(error.to_string().contains("holds for"), "{error}");
    }
}

#[test]
fn the_dashpot_of_a_contact_layer_gives_its_loss_factor_at_its_frequency() {
    let c = contact_dashpot(8e9, 0.1, 500.0);
    close(c * std::f64::consts::TAU * 500.0 / 8e9, 0.1, 1e-14);
}

proptest! {
    /// Gauss points carry area, both second moments and higher ones exactly; cells carry area, and lose 1/n^2 of the
    /// second moments.
    #[test]
    fn grids_carry_area_and_moments(lx in 0.01..2.0f64, ly in 0.01..2.0f64, nx in 1usize..20, ny in 1usize..20) {
        let moment = |grid: &ContactGrid, a: i32, b: i32| -> f64 {
            grid.points.iter().zip(&grid.areas).map(|(p, w)| w * p[0].powi(a) * p[1].powi(b)).sum()
        };
        for rule in [GridRule::GaussLegendre, GridRule::CellCentred] {
            let grid = ContactGrid::new(lx, ly, nx, ny, rule);
            prop_assert_eq!(grid.points.len(), nx * ny);
            prop_assert!((moment(&grid, 0, 0) / (lx * ly) - 1.0).abs() < 1e-13);
            prop_assert!(moment(&grid, 1, 0).abs() < 1e-14 * lx * ly * lx);
            prop_assert!(grid.areas.iter().all(|a| *a > 0.0));
            prop_assert!(grid.points.iter().all(|p| p[0].abs() < 0.5 * lx && p[1].abs() < 0.5 * ly));
            let (exact, n) = (lx.powi(3) * ly / 12.0, nx as f64);
            let expected = match rule {
                GridRule::GaussLegendre if nx >= 2 => exact,
                GridRule::GaussLegendre => 0.0,
                GridRule::CellCentred => exact * (1.0 - 1.0 / (n * n)),
            };
            prop_assert!((moment(&grid, 2, 0) - expected).abs() < 1e-12 * exact);
            if rule == GridRule::GaussLegendre && nx >= 3 && ny >= 3 {
                let fourth = (lx.powi(5) / 80.0) * (ly.powi(5) / 80.0);
                prop_assert!((moment(&grid, 4, 4) / fourth - 1.0).abs() < 1e-12);
            }
        }
    }
}
