//! Check values of the published penetration laws.

use nailnoise_penetration::{
    HIGHEST_SPEED, LOWEST_SPEED, NAILS, PenetrationLaw, REFERENCE_SPEED, RangeError, Shank, Specimen, WOODS,
};

fn specimen(wood: &str, nail: &str, shank: Shank) -> Specimen {
    let wood = WOODS.iter().find(|w| w.name == wood).unwrap();
    let nail = NAILS.iter().find(|n| n.name == nail).unwrap();
    Specimen {
        length: nail.length,
        diameter: nail.shank_diameter(shank).unwrap(),
        hardness_modulus: wood.hardness_modulus,
        density: wood.density,
    }
}

/// Work over the full length by Simpson's rule.
fn work(law: PenetrationLaw, s: &Specimen) -> f64 {
    let n = 2000;
    let h = s.length / f64::from(n);
    let f = |i: i32| law.force(s, (h * f64::from(i)).max(1e-12), REFERENCE_SPEED).unwrap();
    (0..n)
        .step_by(2)
        .map(|i| h / 3.0 * (f(i) + 4.0 * f(i + 1) + f(i + 2)))
        .sum()
}

#[test]
fn forces_and_work_equal_the_check_values_to_their_digits() {
    use PenetrationLaw as P;
    let poplar = "poplar plywood";
    let rows = [
        (
            P::Smooth,
            poplar,
            "6d",
            Shank::Smooth,
            [344.78, 685.23, 1193.13, 34.548],
        ),
        (
            P::Smooth,
            poplar,
            "12d",
            Shank::Smooth,
            [688.78, 1291.97, 2172.20, 105.564],
        ),
        (
            P::Smooth,
            "Douglas-fir plywood",
            "8d",
            Shank::Smooth,
            [556.32, 1074.90, 1840.32, 67.650],
        ),
        (
            P::Annular,
            poplar,
            "4d",
            Shank::Annular,
            [286.92, 581.66, 811.13, 21.415],
        ),
        (
            P::Annular,
            poplar,
            "10d",
            Shank::Annular,
            [618.25, 1226.18, 1696.36, 90.263],
        ),
        (
            P::Helical,
            poplar,
            "10d",
            Shank::Helical,
            [605.47, 1493.31, 1908.26, 101.966],
        ),
        (
            P::General,
            poplar,
            "10d",
            Shank::Smooth,
            [582.24, 1238.97, 1785.66, 89.410],
        ),
        (
            P::Reduced5,
            poplar,
            "8d",
            Shank::Smooth,
            [397.75, 988.15, 1341.26, 61.012],
        ),
        (
            P::SolidWood,
            "pine",
            "12d",
            Shank::Smooth,
            [559.31, 1240.62, 1802.41, 96.145],
        ),
        (
            P::SolidWood,
            "Douglas-fir",
            "12d",
            Shank::Smooth,
            [869.07, 1897.03, 2740.63, 147.049],
        ),
    ];
    for (law, wood, nail, shank, [f1, f5, f10, joule]) in rows {
        let s = specimen(wood, nail, shank);
        for (x, expected) in [(0.1, f1), (0.5, f5), (1.0, f10)] {
            let force = law.force(&s, x * s.length, REFERENCE_SPEED).unwrap();
            assert!(
                (force - expected).abs() <= 0.0051,
                "{law:?} {wood} {nail} x = {x}: {force} {expected}"
            );
        }
        let done = work(law, &s);
        assert!(
            (done - joule).abs() <= 0.00051,
            "{law:?} {wood} {nail}: {done} J, {joule} J"
        );
    }
}

#[test]
fn reduced_laws_stay_near_the_general_law() {
    let s = specimen("poplar plywood", "8d", Shank::Smooth);
    for law in [
        PenetrationLaw::Reduced1,
        PenetrationLaw::Reduced2,
        PenetrationLaw::Reduced3,
        PenetrationLaw::Reduced4,
    ] {
        for i in 2..=10 {
            let depth = s.length * f64::from(i) / 10.0;
            let general = PenetrationLaw::General.force(&s, depth, REFERENCE_SPEED).unwrap();
            let force = law.force(&s, depth, REFERENCE_SPEED).unwrap();
            assert!((force / general - 1.0).abs() < 0.12, "{law:?} {i}: {force} {general}");
        }
    }
}

#[test]
fn a_speed_outside_the_tests_is_refused() {
    let s = specimen("pine", "12d", Shank::Smooth);
    let law = PenetrationLaw::SolidWood;
    for speed in [25.0, 0.0, -1e-3, f64::NAN, 1.01 * HIGHEST_SPEED, 0.99 * LOWEST_SPEED] {
        assert!(
            matches!(law.force(&s, 0.01, speed), Err(RangeError::PenetrationSpeed { .. })),
            "{speed}"
        );
    }
    assert!(law.force(&s, s.length, LOWEST_SPEED).is_ok() && law.force(&s, s.length, HIGHEST_SPEED).is_ok());
}

#[test]
fn a_depth_beyond_the_nail_is_refused() {
    let s = specimen("pine", "12d", Shank::Smooth);
    for depth in [1.1 * s.length, f64::NAN] {
        let found = PenetrationLaw::SolidWood.force(&s, depth, 1e-3);
        assert!(matches!(found, Err(RangeError::PenetrationDepth { .. })), "{depth}");
    }
}

#[test]
fn the_force_is_zero_at_and_above_the_surface() {
    let s = specimen("pine", "12d", Shank::Smooth);
    for depth in [-0.01, 0.0] {
        assert_eq!(PenetrationLaw::SolidWood.force(&s, depth, 1e-3).unwrap(), 0.0);
    }
}
