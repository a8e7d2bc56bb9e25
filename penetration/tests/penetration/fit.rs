//! Regression of penetration laws: recovery, check values of a small set by hand, covariance against Monte Carlo.

use nailnoise_penetration::fit::{
    Conditions, Drive, Driving, FitError, Form, Leave, Method, Point, Regression, Scatter, Variable, fit, reduce,
    roots, validate,
};
use nailnoise_penetration::{NAILS, PenetrationLaw, Specimen, WOODS};
use nalgebra::{DMatrix, DVector};

/// Speeds of the published tests of smooth nails \[m/s\].
const SPEEDS: [f64; 6] = [0.333e-3, 0.833e-3, 1.66e-3, 3.33e-3, 6.66e-3, 8.33e-3];

fn form(text: &str) -> Form {
    text.parse().unwrap()
}

/// Drives of the smooth nails 3d to 12d into the three plywoods at these speeds, with the published law's roots.
fn smooth(speeds: &[f64], repeats: usize, depths: usize) -> Vec<Drive> {
    let c = PenetrationLaw::Smooth.coefficients();
    let terms = form("poly(x,7) + rate + slender");
    let mut drives = Vec::new();
    for nail in &NAILS[..6] {
        for wood in &WOODS[..3] {
            for &speed in speeds {
                let conditions = Conditions {
                    specimen: Specimen {
                        length: nail.length,
                        diameter: nail.diameter,
                        hardness_modulus: wood.hardness_modulus,
                        density: wood.density,
                    },
                    driving: Driving::Constant { speed },
                };
                let point = |k: usize| {
                    let depth = nail.length * k as f64 / (depths - 1) as f64;
                    let values = conditions.values(depth, speed);
                    let root = terms
                        .terms()
                        .iter()
                        .zip(c)
                        .map(|(term, c)| c * term.value(&values))
                        .sum();
                    Point { depth, speed, root }
                };
                let group = format!("{} {} {speed}", nail.name, wood.name);
                for repeat in 0..repeats {
                    drives.push(Drive {
                        id: format!("{group} {repeat}"),
                        group: group.clone(),
                        nail: nail.name.to_owned(),
                        wood: wood.name.to_owned(),
                        conditions,
                        points: (0..depths).map(point).collect(),
                    });
                }
            }
        }
    }
    drives
}

#[test]
fn coefficients_without_noise_are_recovered() {
    let drives = smooth(&SPEEDS, 1, 101);
    assert_eq!(drives.len(), 108);
    let form = form("poly(x,7) + rate + slender");
    let fitted = fit(&form, &drives, Method::LeastSquares).unwrap();
    for (found, expected) in fitted
        .law
        .coefficients()
        .iter()
        .zip(PenetrationLaw::Smooth.coefficients())
    {
        assert!((found / expected - 1.0).abs() < 1e-10, "{found} {expected}");
    }
}

/// Five points of one drive, 6d in poplar plywood.
fn five_points() -> Vec<Drive> {
    let (nail, wood) = (&NAILS[2], &WOODS[2]);
    let conditions = Conditions {
        specimen: Specimen {
            length: nail.length,
            diameter: nail.diameter,
            hardness_modulus: wood.hardness_modulus,
            density: wood.density,
        },
        driving: Driving::Constant { speed: 8.333e-3 },
    };
    let points = [(0.2, 0.08), (0.4, 0.11), (0.6, 0.13), (0.8, 0.16), (1.0, 0.17)];
    vec![Drive {
        id: "1".to_owned(),
        group: "a".to_owned(),
        nail: "6d".to_owned(),
        wood: wood.name.to_owned(),
        conditions,
        points: points
            .map(|(x, root)| Point {
                depth: x * nail.length,
                speed: 8.333e-3,
                root,
            })
            .to_vec(),
    }]
}

#[test]
fn a_line_through_five_points_has_the_statistics_computed_by_hand() {
    let drives = five_points();
    let law = fit(&form("1 + x"), &drives, Method::LeastSquares).unwrap().law;
    let near =
        |found: f64, expected: f64, digit: f64| assert!((found - expected).abs() <= 0.5 * digit, "{found} {expected}");
    near(law.coefficients()[0], 0.061, 1e-12);
    near(law.coefficients()[1], 0.115, 1e-12);
    let q = law.file().quality;
    near(q.r_squared, 0.979_630, 1e-6);
    near(q.standard_error, 0.006_055_30, 1e-8);
    near(q.mean_absolute_error, 0.004, 1e-12);
    near(q.mean_percentage_error, 3.126_34, 1e-5);
    near(q.mean_percentage_error_force, 6.274_43, 1e-5);
    let v = law.covariance();
    near(v[(0, 0)], 4.033_33e-5, 1e-10);
    near(v[(0, 1)], -5.5e-5, 1e-10);
    near(v[(1, 1)], 9.166_67e-5, 1e-10);
    let conditions = drives[0].conditions;
    let at = (0.5 * conditions.specimen.length, 8.333e-3);
    near(law.force(&conditions, at.0, at.1), 341.664, 1e-3);
    let band = law.band(&conditions, at, 0.95, Scatter::Law);
    near(band[0], 290.987, 1e-3);
    near(band[1], 396.408, 1e-3);
    let band = law.band(&conditions, at, 0.95, Scatter::Point);
    near(band[0], 229.741, 1e-3);
    near(band[1], 475.725, 1e-3);
    let [work, error] = law.work(&conditions, 8.333e-3).unwrap();
    near(work, 18.718_75, 1e-5);
    near(error, 0.795_09, 1e-5);
}

/// Independent numbers of N(0, 1), by Box and Muller (1958).
fn normals(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    // SplitMix64 (Steele, Lea and Flood, 2014).
    let mut uniform = move || {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    move || (-2.0 * (1.0 - uniform()).ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos()
}

/// Standard deviations over draws, and root mean squares of clustered and classical standard errors.
fn monte_carlo(sigma_between: f64, sigma_within: f64, draws: usize) -> [DVector<f64>; 3] {
    let drives = smooth(&[8.333e-3], 7, 21);
    let form = form("poly(x,7) + rate + slender");
    let regression = Regression::new(&form, &drives, Method::LeastSquares).unwrap();
    let clean = roots(&drives);
    let mut normal = normals(1);
    let [mut sum, mut square, mut clustered, mut classical] = [0; 4].map(|_| DVector::<f64>::zeros(10));
    let expected = DVector::from_row_slice(&PenetrationLaw::Smooth.coefficients());
    for _ in 0..draws {
        let mut s = clean.clone();
        for range in regression.drives() {
            let common = sigma_between * normal();
            for k in range.clone() {
                s[k] += common + sigma_within * normal();
            }
        }
        let solution = regression.solve(&s);
        let error = &solution.coefficients - &expected;
        square += error.component_mul(&error);
        sum += error;
        clustered += solution.covariance.diagonal();
        classical += solution.classical.diagonal();
    }
    let n = draws as f64;
    let variance = square / n - (&sum / n).component_mul(&(&sum / n));
    [variance, clustered / n, classical / n].map(|v| v.map(f64::sqrt))
}

#[test]
fn the_classical_covariance_is_that_of_independent_points() {
    let [truth, _, classical] = monte_carlo(0.0, 0.01, 4000);
    for (found, truth) in classical.iter().zip(truth.iter()) {
        assert!((found / truth - 1.0).abs() < 0.04, "{found} {truth}");
    }
}

#[test]
fn the_clustered_covariance_is_that_of_specimens_that_differ() {
    let [truth, clustered, classical] = monte_carlo(0.01, 0.005, 4000);
    for place in 0..10 {
        assert!((clustered[place] / truth[place] - 1.0).abs() < 0.05, "{place}");
        let expected = match place {
            0 => 0.250,
            1..=7 => 2.24,
            _ => 0.243,
        };
        let ratio = classical[place] / truth[place];
        assert!((ratio / expected - 1.0).abs() < 0.03, "{place}: {ratio}");
    }
}

#[test]
fn one_nail_does_not_tell_slenderness_from_a_constant() {
    let drives: Vec<Drive> = smooth(&SPEEDS, 1, 21)
        .into_iter()
        .filter(|drive| drive.nail == "6d")
        .collect();
    let error = fit(&form("poly(x,3) + rate + slender"), &drives, Method::LeastSquares).unwrap_err();
    assert_eq!(
        error,
        FitError::NotIdentifiable {
            term: "slender".to_owned(),
            partners: vec!["1".to_owned()]
        }
    );
}

#[test]
fn too_few_depths_and_drives_are_refused() {
    let drives = smooth(&SPEEDS, 1, 8);
    let error = fit(&form("poly(x,8)"), &drives, Method::LeastSquares).unwrap_err();
    assert!(matches!(error, FitError::TooFewDepths { depths: 8, .. }), "{error}");
    let error = fit(&form("x + slender + rate + 1"), &drives[..3], Method::LeastSquares).unwrap_err();
    assert!(
        matches!(error, FitError::TooFewDrives { drives: 3, terms: 3 }),
        "{error}"
    );
    let error = fit(&form("1 + x + decay"), &drives, Method::WithinBetween).unwrap_err();
    assert!(matches!(error, FitError::NoImpact { .. }), "{error}");
}

#[test]
fn a_reduction_never_improves_the_fit_and_validation_predicts_worse_than_it() {
    let mut drives = smooth(&[8.333e-3], 2, 21);
    let mut normal = normals(3);
    for drive in &mut drives {
        let common = 0.01 * normal();
        drive
            .points
            .iter_mut()
            .for_each(|point| point.root += common + 0.003 * normal());
    }
    let form = form("slender + poly(x,7)");
    let (chosen, steps) = reduce(&form, &drives, None).unwrap();
    assert_eq!(steps.len(), 9);
    assert!(steps.windows(2).all(|pair| pair[1].r_squared <= pair[0].r_squared));
    assert!(steps.iter().filter(|step| step.chosen).count() == 1);
    assert!(chosen.terms().len() < 9);
    let whole = fit(&form, &drives, Method::LeastSquares).unwrap();
    let error = validate(&form, &drives, Method::LeastSquares, Leave::Nail).unwrap();
    assert_eq!(error.folds.len(), 6);
    assert!(error.root_mean_square > whole.law.file().quality.standard_error);
}

#[test]
fn a_drawn_law_has_the_covariance_of_the_fit() {
    let mut drives = smooth(&[8.333e-3], 2, 21);
    let mut normal = normals(5);
    for drive in &mut drives {
        let common = 0.01 * normal();
        drive
            .points
            .iter_mut()
            .for_each(|point| point.root += common + 0.003 * normal());
    }
    let law = fit(&form("poly(x,3) + slender"), &drives, Method::LeastSquares)
        .unwrap()
        .law;
    let n = law.coefficients().len();
    let mut found = DMatrix::<f64>::zeros(n, n);
    let mut specimen = 0.0;
    const DRAWS: usize = 20_000;
    for _ in 0..DRAWS {
        let numbers: Vec<f64> = (0..law.draw_size()).map(|_| normal()).collect();
        let drawn = law.drawn(&numbers);
        let error = drawn.coefficients() - law.coefficients();
        found += &error * error.transpose() / DRAWS as f64;
        specimen += drawn.file().specimen_deviation.unwrap().powi(2) / DRAWS as f64;
    }
    let v = law.covariance();
    for i in 0..n {
        for j in 0..n {
            let scale = (v[(i, i)] * v[(j, j)]).sqrt();
            assert!((found[(i, j)] - v[(i, j)]).abs() < 0.04 * scale, "{i} {j}");
        }
    }
    assert!((specimen.sqrt() / law.file().sigma_between - 1.0).abs() < 0.03);
}

#[test]
fn derivatives_of_the_law_are_those_of_its_force() {
    let mut drives = smooth(&[8.333e-3], 2, 21);
    for drive in &mut drives {
        let (mass, v0) = (0.131, if drive.id.ends_with('0') { 20.0 } else { 30.0 });
        drive.conditions.driving = Driving::Impact { mass, speed: v0 };
        for (k, point) in drive.points.iter_mut().enumerate() {
            point.speed = v0 * (1.0 - (0.02 + 1e-3 * v0) * k as f64 - 2e-5 * v0 * (k * k) as f64);
            point.speed = point.speed.max(0.05 * v0);
            point.root += 0.02 * point.speed / v0 + 1e-4 * k as f64;
        }
    }
    let law = fit(
        &form("poly(x,3) + decay + inertia + x*decay + slender"),
        &drives,
        Method::WithinBetween,
    )
    .unwrap()
    .law;
    assert!(law.form().uses(Variable::Decay) && law.needs_impact());
    let conditions = drives[20].conditions;
    let of_drive = law.of(&conditions.specimen, 0.131);
    let Driving::Impact { speed: v0, .. } = conditions.driving else {
        unreachable!()
    };
    let (y, v) = (0.6 * conditions.specimen.length, 0.6 * v0);
    let found = of_drive.evaluate(y, v, v0);
    let (dy, dv) = (1e-6 * y, 1e-6 * v);
    let by_depth = (of_drive.evaluate(y + dy, v, v0).force - of_drive.evaluate(y - dy, v, v0).force) / (2.0 * dy);
    let by_speed = (of_drive.evaluate(y, v + dv, v0).force - of_drive.evaluate(y, v - dv, v0).force) / (2.0 * dv);
    assert!((found.by_depth / by_depth - 1.0).abs() < 1e-7);
    assert!((found.by_speed / by_speed - 1.0).abs() < 1e-7);
    // The general evaluation of the law agrees.
    assert!((found.force / law.force(&conditions, y, v) - 1.0).abs() < 1e-12);
    // Held to the range of the data.
    let [low, _] = law.file().ranges.decay.unwrap();
    assert_eq!(
        of_drive.evaluate(y, 0.0, v0).force,
        of_drive.evaluate(y, low * v0, v0).force
    );
    assert_eq!(of_drive.evaluate(y, 0.0, v0).by_speed, 0.0);
}
