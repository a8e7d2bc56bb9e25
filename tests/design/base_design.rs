//! The shipped designs against the references they were taken from.

use crate::common::body;
use nailnoise::design::Value;
use nailnoise::stages::bodies::BodyKind;
use nailnoise::store::Store;
use nailnoise::{Design, chain};
use nailnoise_acoustics::random::uniform;

fn design(name: &str) -> Design {
    Design::load(format!("{}/designs/{name}.toml", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

/// Event times of two independent implementations of the model, in ms (t1 to t18).
const EVENTS: [f64; 18] = [
    11.526, 11.740, 14.369, 15.073, 17.188, 17.401, 18.308, 19.430, 21.831, 24.174, 26.033, 28.826, 42.972, 44.774,
    65.067, 75.648, 76.495, 80.658,
];

#[test]
fn events_of_the_base_design_are_those_of_the_reference() {
    let record = chain::cycle(&design("n80cb")).unwrap();
    assert!(record.is_certified());
    for (k, (time, expected)) in record.figures.events.to_array().iter().skip(1).zip(EVENTS).enumerate() {
        let limit = if [2, 10, 11, 18].contains(&(k + 1)) {
            60e-6
        } else {
            10e-6
        };
        let error = time.unwrap() - 1e-3 * expected;
        assert!(error.abs() <= limit, "t{}: {error:e} s off", k + 1);
    }
}

#[test]
fn the_free_block_has_the_reference_modes() {
    let block = body(&design("n80cb"), BodyKind::Workpiece, true, Store::none())
        .body
        .get()
        .unwrap();
    let basis = &block.basis;
    assert_eq!(basis.rigid.iter().filter(|&&rigid| rigid).count(), 6);
    assert_eq!(basis.sturm.count, basis.hz.len());
    assert!(basis.residuals.iter().all(|&residual| residual < 1e-8));
    let elastic = [1483.0, 2261.0, 2700.0, 2707.0, 2991.0, 3027.0, 3139.0, 3185.0, 4035.0];
    for (hz, expected) in basis.hz[6..].iter().zip(elastic) {
        assert!((hz / expected - 1.0).abs() < 0.005, "{hz} Hz instead of {expected}");
    }
}

/// The dimensions of the body and the bore within it can be drawn independently of each other.
#[test]
fn no_draw_from_the_ranges_of_bore_and_body_is_refused() {
    let base = design("n80cb");
    let ranges: Vec<(String, [f64; 2])> = base
        .entries()
        .into_iter()
        .filter(|entry| entry.key == "piston.bore" || entry.key.starts_with("body."))
        .filter_map(|entry| Some((entry.key, entry.range?)))
        .collect();
    assert!(ranges.len() > 30, "{} ranges", ranges.len());
    for draw in 0..1000 {
        let values: Vec<(&str, Value)> = ranges
            .iter()
            .enumerate()
            .map(|(k, (key, [low, high]))| {
                let value = low + (high - low) * uniform(5, draw, k as u64);
                (key.as_str(), Value::Number(value))
            })
            .collect();
        let mut drawn = base.clone();
        drawn.set(&values).unwrap();
        assert_eq!(drawn.conflict(), None, "{values:?}");
        let sleeve = 0.5 * drawn.piston.bore + drawn.body.sleeve_wall;
        let barrel = drawn.body.barrel_radius(0.5 * drawn.piston.bore) - drawn.body.barrel_wall;
        assert!(sleeve < barrel, "a sleeve of {sleeve} m in a barrel of {barrel} m");
    }
}
