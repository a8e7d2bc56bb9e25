//! Drives at any speed, divided by the law of the speed.

use nailnoise_penetration::fit::{
    Conditions, Drive, Driving, FitError, Form, Method, Point, RateChoice, fit, without_rate,
};
use nailnoise_penetration::{
    Driven, NAILS, NailedWood, REFERENCE_SPEED, RateLaw, Resistance, ResistanceLaw, Shanks, Specimen, SpeedTerms,
    WOODS, Wood,
};

const BETA: f64 = 0.07;
const WIDTH: f64 = 1.6;
const SHARE: f64 = 0.6;

/// s of the quasi-static curve from which drives are made.
fn root(x: f64) -> f64 {
    0.02 + 0.35 * x - 0.2 * x * x + 0.05 * x.powi(3)
}

fn specimen() -> Specimen {
    Specimen {
        length: NAILS[5].length,
        diameter: NAILS[5].diameter,
        hardness_modulus: WOODS[0].hardness_modulus,
        density: WOODS[0].density,
    }
}

/// A drive whose nail slows down from `speed` to a tenth of it, or not at all, by the law of the speed.
fn drive(number: usize, speed: f64, slows: bool, noise: f64) -> Drive {
    let terms = SpeedTerms {
        crushing: BETA,
        width: WIDTH,
        ..SpeedTerms::default()
    };
    let specimen = specimen();
    let point = |k: usize| {
        let x = 0.01 * k as f64;
        let v = if slows { speed * (1.0 - 0.9 * x) } else { speed };
        let force = root(x).powi(2);
        let friction = (SHARE * root(1.0).powi(2) * x).min(force);
        let [crushing, sliding] = terms.factors(v);
        let swing = noise * (17.0 * k as f64 + 5.0 * number as f64).sin();
        Point {
            depth: x * specimen.length,
            speed: v,
            root: ((force - friction) * crushing + friction * sliding).sqrt() + swing,
        }
    };
    Drive {
        id: format!("d{number}"),
        group: format!("{speed}"),
        nail: "12d".to_owned(),
        wood: "pine".to_owned(),
        conditions: Conditions {
            specimen,
            driving: if slows {
                Driving::Impact { mass: 0.3, speed }
            } else {
                Driving::Constant { speed }
            },
        },
        points: (1..=100).map(point).collect(),
    }
}

fn choice(estimate: bool, speed: SpeedTerms) -> RateChoice {
    RateChoice {
        friction_share: SHARE,
        speed,
        estimate,
    }
}

fn form() -> Form {
    "poly(x,3)".parse().unwrap()
}

fn fast(noise: f64) -> Vec<Drive> {
    let speeds = [25.0, 12.0, 6.0, 3.0, 1.0];
    speeds
        .iter()
        .enumerate()
        .map(|(k, v)| drive(k, *v, true, noise))
        .collect()
}

#[test]
fn known_coefficients_give_the_quasi_static_curve_from_fast_drives() {
    let known = SpeedTerms {
        crushing: BETA,
        width: WIDTH,
        ..SpeedTerms::default()
    };
    let found = without_rate(&form(), &fast(0.0), Method::LeastSquares, &choice(false, known)).unwrap();
    let law = fit(&form(), &found.drives, Method::LeastSquares).unwrap().law;
    for (found, expected) in law.coefficients().iter().zip([0.02, 0.35, -0.2, 0.05]) {
        assert!((found - expected).abs() < 1e-8, "{found} {expected}");
    }
    assert_eq!(found.rate.crushing_interval, None);
    assert!(!law.dynamic() && law.reference_speed() == REFERENCE_SPEED);
}

#[test]
fn beta_and_v_m_of_fast_drives_are_recovered() {
    let start = choice(true, SpeedTerms::default());
    let found = without_rate(&form(), &fast(0.0), Method::LeastSquares, &start)
        .unwrap()
        .rate;
    assert!((found.speed.crushing - BETA).abs() < 1e-5, "{}", found.speed.crushing);
    assert!((found.speed.width / WIDTH - 1.0).abs() < 1e-4, "{}", found.speed.width);
}

#[test]
fn the_intervals_of_noisy_drives_contain_beta_and_v_m() {
    let start = choice(true, SpeedTerms::default());
    let found = without_rate(&form(), &fast(1e-3), Method::LeastSquares, &start)
        .unwrap()
        .rate;
    let [[low, high], [narrow, wide]] = [found.crushing_interval.unwrap(), found.width_interval_m_s.unwrap()];
    assert!(low < BETA && BETA < high && high - low < 0.05, "{low} {high}");
    assert!(narrow < WIDTH && WIDTH < wide && wide < 4.0 * narrow, "{narrow} {wide}");
}

#[test]
fn drives_at_one_speed_do_not_determine_the_law_of_the_speed() {
    let one: Vec<Drive> = (0..4).map(|k| drive(k, 5.0, false, 1e-3)).collect();
    let start = choice(true, SpeedTerms::default());
    let error = without_rate(&form(), &one, Method::LeastSquares, &start).unwrap_err();
    assert!(matches!(error, FitError::OneSpeed { .. }), "{error}");
    assert!(error.remedy().contains("--rate speed"));
    // With given coefficients they are as good as any.
    assert!(
        without_rate(
            &form(),
            &one,
            Method::LeastSquares,
            &choice(false, SpeedTerms::default())
        )
        .is_ok()
    );
}

#[test]
fn slow_drives_do_not_determine_the_fall_of_friction() {
    let slow: Vec<Drive> = [0.3e-3, 1e-3, 3e-3, 8e-3]
        .iter()
        .enumerate()
        .map(|(k, v)| drive(k, *v, false, 1e-3))
        .collect();
    let start = choice(true, SpeedTerms::default());
    let error = without_rate(&form(), &slow, Method::LeastSquares, &start).unwrap_err();
    assert!(matches!(error, FitError::OneSpeed { .. }), "{error}");
}

#[test]
fn a_form_with_a_term_of_speed_is_refused() {
    let form: Form = "poly(x,3) + rate".parse().unwrap();
    let error = without_rate(
        &form,
        &fast(0.0),
        Method::LeastSquares,
        &choice(false, SpeedTerms::default()),
    )
    .unwrap_err();
    assert!(
        matches!(&error, FitError::TermOfSpeed { term } if term == "rate"),
        "{error}"
    );
}

/// The force of a cycle with the fitted law is that of the drives from which it comes, at their speeds.
#[test]
fn a_design_uses_the_fitted_law_with_the_speed_of_its_tests() {
    let start = choice(true, SpeedTerms::default());
    let drives = fast(0.0);
    let found = without_rate(&form(), &drives, Method::LeastSquares, &start).unwrap();
    let law = fit(&form(), &found.drives, Method::LeastSquares)
        .unwrap()
        .law
        .with_rate(found.rate);
    let wood = NailedWood {
        rate: RateLaw::None,
        ..NailedWood::quasi_static(Wood {
            density: 431.0,
            hardness_modulus: specimen().hardness_modulus,
            penetration_law: ResistanceLaw::Fitted,
            speed_term: 0.0,
            slenderness_term: 0.0,
            penetration_force: 0.0,
            resistance_scale: 1.0,
            head_stiffness_scale: 1.0,
            unloading_stiffness: 1e6,
        })
    };
    let specimen = specimen();
    let resistance = Resistance::new(&Driven {
        wood: &wood,
        table: None,
        fit: Some(&law),
        specimen: &specimen,
        mass: 0.3,
        shanks: Shanks {
            legs: 1,
            friction_share: 0.3,
            coating: 1.0,
        },
    });
    for drive in &drives {
        for point in &drive.points {
            let expected = drive.conditions.force_scale() * point.root * point.root;
            let force = resistance.evaluate(point.depth, point.speed, 0.0);
            assert!((force / expected - 1.0).abs() < 1e-4, "{force} {expected}");
        }
    }
}
