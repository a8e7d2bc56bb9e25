//! Time of a fit with 100 000 points and 10 terms, and of a shot of the test machine, on one core.

use std::path::Path;

use divan::Bencher;
use nailnoise::penetration::machine::machine;
use nailnoise_dynamics::machine::{Drive as Driven, Shot, drive, launch};
use nailnoise_penetration::fit::{Conditions, Drive, Driving, Fitted, Form, Method, Point, fit};
use nailnoise_penetration::{NAILS, Specimen, WOODS};

const DRIVES: usize = 1000;
const POINTS: usize = 100;

fn main() {
    divan::main();
}

/// Drives of six nails into three woods at speeds of a testing machine.
fn drives() -> Vec<Drive> {
    let one = |k: usize| {
        let (nail, wood) = (&NAILS[k % 6], &WOODS[k % 3]);
        let speed = [0.333e-3, 1.66e-3, 8.33e-3][k % 7 % 3];
        let point = |i: usize| {
            let x = (i as f64 + 0.5) / POINTS as f64;
            // A law that is not a polynomial, with scatter, so that no fit is exact.
            let scatter = 1e-3 * ((k * POINTS + i) as f64 * 12.9898).sin();
            Point {
                depth: x * nail.length,
                speed,
                root: 0.05 + 0.12 * x.sqrt() + scatter,
            }
        };
        Drive {
            id: k.to_string(),
            group: (k % 18).to_string(),
            nail: nail.name.to_owned(),
            wood: wood.name.to_owned(),
            conditions: Conditions {
                specimen: Specimen {
                    length: nail.length,
                    diameter: nail.diameter,
                    hardness_modulus: wood.hardness_modulus,
                    density: wood.density,
                },
                driving: Driving::Constant { speed },
            },
            points: (0..POINTS).map(point).collect(),
        }
    };
    (0..DRIVES).map(one).collect()
}

#[divan::bench(sample_count = 10)]
fn fit_of_100_000_points_and_10_terms(bencher: Bencher<'_, '_>) {
    let form: Form = "poly(x,7) + rate + slender".parse().expect("a form");
    let drives = drives();
    let one = || -> Fitted { fit(&form, &drives, Method::LeastSquares).expect("the drives determine the law") };
    bencher.bench_local(one);
}

#[divan::bench]
fn shot_of_the_machine(bencher: Bencher<'_, '_>) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/penetration/machine.toml");
    let (machine, fitted) = machine(&file).expect("a machine");
    let one = || -> Driven {
        let speed = launch(&machine).expect("a launch").speed;
        let shot = Shot { speed, deviation: 0.0 };
        drive(&machine, fitted.as_ref(), shot, 1.0 / machine.sensors.rate).expect("a drive")
    };
    bencher.bench_local(one);
}
