//! Penetration resistance from a table.

use nailnoise_dynamics::{CycleError, CycleRecord, Parameters, Settings, simulate};
use nailnoise_penetration::{ForceTable, PenetrationLaw, REFERENCE_SPEED, Specimen, TableError};

use crate::common::n80cb;

fn run(table: Option<ForceTable>) -> CycleRecord {
    let p = Parameters {
        penetration_table: table,
        ..n80cb()
    };
    simulate(&p, &Settings::default()).unwrap()
}

/// The solid-wood law of the base design at `n` equal steps.
fn sampled(n: usize) -> ForceTable {
    let p = n80cb();
    let specimen = Specimen {
        length: p.nail.length,
        diameter: p.nail.diameter,
        hardness_modulus: p.wood.hardness_modulus,
        density: p.wood.density,
    };
    let depths: Vec<f64> = (0..=n).map(|i| p.nail.length * i as f64 / n as f64).collect();
    let force = |depth: &f64| {
        PenetrationLaw::SolidWood
            .force(&specimen, depth.max(1e-15), REFERENCE_SPEED)
            .unwrap()
    };
    let forces = depths.iter().map(force).collect();
    ForceTable::new(depths, forces).unwrap()
}

#[test]
fn a_fine_table_of_a_law_gives_the_same_cycle_as_the_law() {
    let law = run(None);
    let table = run(Some(sampled(400)));
    assert!(table.is_certified(), "{:?}", table.figures.checks);
    for (i, (a, b)) in law
        .figures
        .events
        .to_array()
        .iter()
        .zip(table.figures.events.to_array())
        .enumerate()
    {
        let apart = (a.unwrap() - b.unwrap()).abs();
        assert!(apart < if i == 11 || i == 18 { 2e-5 } else { 1e-6 }, "t{i}: {apart} s");
    }
}

#[test]
fn the_interpolation_passes_all_points_and_never_overshoots() {
    let depths = vec![0.0, 0.01, 0.02, 0.025, 0.05, 0.09];
    let forces = vec![0.0, 500.0, 500.0, 900.0, 700.0, 1800.0];
    let table = ForceTable::new(depths.clone(), forces.clone()).unwrap();
    for (depth, force) in depths.iter().zip(&forces) {
        assert!((table.force(*depth) - force).abs() < 1e-12);
    }
    for (x, f) in depths.windows(2).zip(forces.windows(2)) {
        let mut before = f[0];
        for i in 1..=50 {
            let force = table.force(x[0] + (x[1] - x[0]) * f64::from(i) / 50.0);
            assert!((force - before) * (f[1] - f[0]) >= -1e-12, "{force} {before}");
            before = force;
        }
    }
    assert_eq!((table.force(-1.0), table.force(0.0)), (0.0, 0.0));
}

#[test]
fn the_interpolation_converges_with_the_fineness_of_the_table() {
    let p = n80cb();
    // Away from the turns of the law, where the slope of a monotone cubic is of first order only.
    let error = |n: usize| {
        let table = sampled(n);
        (0..1000)
            .map(|i| p.nail.length * (0.55 + 0.35 * f64::from(i) / 1000.0))
            .map(|depth| (table.force(depth) - p.penetration_resistance(depth)).abs())
            .fold(0.0, f64::max)
    };
    let errors = [error(50), error(100), error(200)];
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!(order > 2.7, "order {order} of {errors:?} N");
    }
}

#[test]
fn parameters_with_a_table_are_read_back_from_json() {
    let mut p = n80cb();
    p.penetration_table = Some(sampled(4));
    let back: Parameters = serde_json::from_value(serde_json::to_value(&p).unwrap()).unwrap();
    assert_eq!(back, p);
}

#[test]
fn a_wrong_point_is_an_error_with_its_number() {
    use TableError as E;
    let refused = |depths: &[f64], forces: &[f64]| ForceTable::new(depths.to_vec(), forces.to_vec()).unwrap_err();
    assert_eq!(refused(&[0.0], &[0.0]), E::TooFew { count: 1 });
    assert_eq!(refused(&[0.01, 0.02], &[0.0, 5.0]), E::Start { depth: 0.01 });
    let order = E::Order {
        point: 3,
        depth: 0.05,
        before: 0.05,
    };
    assert_eq!(refused(&[0.0, 0.05, 0.05], &[0.0, 5.0, 6.0]), order);
    assert!(matches!(refused(&[0.0, 0.05], &[0.0, -5.0]), E::Value { point: 2, .. }));
    assert!(matches!(
        refused(&[0.0, 0.05], &[0.0, f64::INFINITY]),
        E::Value { point: 2, .. }
    ));
    // No nail is that long, no force that large.
    for (depth, force) in [(0.05, 1e308), (1e300, 5.0), (11.0, 5.0), (0.05, 1.1e7), (f64::NAN, 5.0)] {
        let error = refused(&[0.0, depth], &[0.0, force]);
        assert!(matches!(error, E::Value { point: 2, .. }), "{depth} {force}");
        assert!(error.to_string().contains("at most 10 m"), "{error}");
    }
    assert_eq!(
        ForceTable::new(vec![0.0], vec![]).unwrap_err(),
        E::Lengths { depths: 1, forces: 0 }
    );
}

#[test]
fn a_wrong_table_in_json_is_refused() {
    assert!(serde_json::from_str::<ForceTable>(r#"{"depths": [0, 1, 1], "forces": [0, 1, 2]}"#).is_err());
}

#[test]
fn a_table_shorter_than_the_nail_is_refused() {
    let mut p = n80cb();
    p.penetration_table = Some(ForceTable::new(vec![0.0, 0.05], vec![0.0, 1000.0]).unwrap());
    let error = simulate(&p, &Settings::default()).unwrap_err();
    assert!(matches!(error, CycleError::TableTooShort { .. }), "{error}");
}
