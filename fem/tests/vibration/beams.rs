//! Beams under a blow: modal sums against closed forms, and against the full matrices marched by Newmark's method.

use std::f64::consts::PI;

use nailnoise_fem::vibration::{Loads, ModalBody, ModalResponse, Motion, Settings, Start, respond};
use nailnoise_fem::{Constraints, Material, ModalSettings, assemble, modes};
use nailnoise_meshes::{Block, block};
use nalgebra::{Cholesky, DMatrix, DVector};

/// Length of the blow \[s\].
const PULSE: f64 = 5e-4;

fn pulse(t: f64) -> f64 {
    if t < PULSE { (PI * t / PULSE).sin() } else { 0.0 }
}

/// q of q'' + 2 zeta omega q' + omega^2 q = sin(pi t/T) for t < T, then 0 (Duhamel).
fn duhamel(omega: f64, zeta: f64, t: f64) -> f64 {
    let p = PI / PULSE;
    // The pulse is a sine, and the same sine again half a period later.
    let sine = |t: f64| {
        if t <= 0.0 {
            return 0.0;
        }
        if omega == 0.0 {
            return (p * t - (p * t).sin()) / (p * p);
        }
        let (r, d) = (omega * omega - p * p, 2.0 * zeta * omega * p);
        let (a, b) = (r / (r * r + d * d), -d / (r * r + d * d));
        let wd = omega * (1.0 - zeta * zeta).sqrt();
        let decay = (-zeta * omega * t).exp();
        // q(0) = q'(0) = 0.
        let (c, s) = (-b, (-b * zeta * omega - a * p) / wd);
        a * (p * t).sin() + b * (p * t).cos() + decay * (c * (wd * t).cos() + s * (wd * t).sin())
    };
    sine(t) + sine(t - PULSE)
}

/// A bending beam by its closed-form modes: stiffness EI = 1, mass per length m, length 1.
struct Beam {
    omega: Vec<f64>,
    /// Mode shapes at the load and at the point that is read.
    at: Vec<[f64; 2]>,
}

const PLACES: [f64; 2] = [0.3, 0.85];
/// Speed sqrt(EI/m) pi^2 of the first mode of the supported beam [rad/s].
const FIRST: f64 = 2.0 * PI * 400.0;

impl Beam {
    /// Both ends hinged: sqrt(2) sin(k pi x), omega = k^2 omega_1.
    fn supported(count: usize) -> Self {
        let shape = |k: f64| PLACES.map(|x| 2f64.sqrt() * (k * PI * x).sin());
        Self {
            omega: (1..=count).map(|k| (k * k) as f64 * FIRST).collect(),
            at: (1..=count).map(|k| shape(k as f64)).collect(),
        }
    }

    /// Both ends free: two rigid modes, then cosh b x + cos b x - s (sinh b x + sin b x) with cosh b cos b = 1.
    fn free(count: usize) -> Self {
        let mut beam = Self {
            omega: vec![0.0; 2],
            at: vec![[1.0; 2], PLACES.map(|x| 12f64.sqrt() * (x - 0.5))],
        };
        for k in 1..=count {
            let mut b = (k as f64 + 0.5) * PI;
            for _ in 0..20 {
                // cos b = 1/cosh b
                b -= (b.cos() - 1.0 / b.cosh()) / (-b.sin() + b.sinh() / b.cosh().powi(2));
            }
            let s = (b.cosh() - b.cos()) / (b.sinh() - b.sin());
            beam.omega.push(b * b / (PI * PI) * FIRST);
            // cosh - s sinh = e^-bx + (1 - s) sinh, without the cancellation of large numbers.
            let excess = (b.sinh() - b.sin() - b.cosh() + b.cos()) / (b.sinh() - b.sin());
            let shape = |x: f64| {
                let y = b * x;
                (-y).exp() + excess * y.sinh() + y.cos() - s * y.sin()
            };
            beam.at.push(PLACES.map(shape));
        }
        beam
    }

    fn respond(&self, zeta: f64, step: f64, duration: f64) -> (ModalResponse, Vec<f64>) {
        let count = self.omega.len();
        let body = ModalBody {
            name: "beam".into(),
            omega: self.omega.clone(),
            zeta: vec![zeta; count],
            loads: DMatrix::from_fn(count, 1, |j, _| self.at[j][0]),
            supports: DMatrix::zeros(count, 0),
        };
        let samples = (duration / step).round() as usize + 1;
        let loads = Loads {
            interval: step,
            history: DMatrix::from_fn(1, samples, |_, n| pulse(n as f64 * step)),
            final_values: vec![0.0],
        };
        let settings = Settings {
            step,
            duration,
            decay: f64::INFINITY,
            start: Start::Rest,
            ..Settings::default()
        };
        let response = respond(&[body], &[], &loads, &settings).unwrap();
        let shapes = DMatrix::from_fn(count, 1, |j, _| self.at[j][1]);
        let read = response.points(0, &shapes, Motion::Displacement).unwrap();
        (response, read.as_slice().to_vec())
    }

    /// Largest error of the point's motion relative to its peak.
    fn error(&self, zeta: f64, step: f64) -> f64 {
        let (response, read) = self.respond(zeta, step, 4e-3);
        assert!(response.checks.iter().all(|check| check.ok), "{:?}", response.checks);
        let (mut worst, mut peak): (f64, f64) = (0.0, 0.0);
        for (n, found) in read.iter().enumerate() {
            let t = n as f64 * step;
            let sum = |(omega, at): (&f64, &[f64; 2])| at[0] * at[1] * duhamel(*omega, zeta, t);
            let exact: f64 = self.omega.iter().zip(&self.at).map(sum).sum();
            worst = worst.max((found - exact).abs());
            peak = peak.max(exact.abs());
        }
        worst / peak
    }
}

#[test]
fn beams_under_a_blow_follow_duhamel_with_order_two() {
    for (name, beam) in [("supported", Beam::supported(6)), ("free", Beam::free(5))] {
        let errors = [20e-6, 10e-6, 5e-6].map(|step| beam.error(0.01, step));
        let orders = [(errors[0] / errors[1]).log2(), (errors[1] / errors[2]).log2()];
        assert!(
            orders.iter().all(|order| (order - 2.0).abs() < 0.1),
            "{name}: {errors:?} {orders:?}"
        );
        assert!(errors[2] < 1e-4, "{name}: {errors:?}");
    }
}

#[test]
fn a_free_beam_receives_the_whole_impulse() {
    let (response, _) = Beam::free(5).respond(0.0, 5e-6, 4e-3);
    // The blow's impulse is 2 T/pi, all of it in the translation of mass 1.
    let velocity = response.end[0].velocity[0];
    assert!((velocity / (2.0 * PULSE / PI) - 1.0).abs() < 1e-4, "{velocity}");
}

#[test]
fn a_modal_sum_converges_to_the_full_matrices_marched_by_newmark() {
    let mesh = block(&Block {
        size: [0.30, 0.03, 0.02],
        divisions: [6, 1, 1],
        origin: [0.0; 3],
    })
    .unwrap();
    let held = Constraints::clamped(&mesh, "x_min").unwrap();
    let steel = Material::isotropic(2.07e11, 0.29, 7850.0).unwrap();
    let system = assemble(&mesh, &[steel], &held).unwrap();
    // A force across the free end.
    let place = mesh.locate(nalgebra::Point3::new(0.30, 0.01, 0.02)).unwrap();
    let mut load = DMatrix::zeros(3 * mesh.nodes.len(), 1);
    for (node, weight) in place.nodes.iter().zip(&place.weights) {
        load[3 * node + 2] += weight;
    }
    let basis = modes(
        &system,
        &ModalSettings::below(12e3).with_loads(load.clone()),
        &|_, _| (),
    )
    .unwrap();
    let shapes = basis.shapes.clone();
    let at = shapes.tr_mul(&load);
    let (duration, fine) = (3e-3f64, 1e-6f64);
    let body = ModalBody {
        name: "beam".into(),
        omega: basis.all_hz().iter().map(|hz| 2.0 * PI * hz).collect(),
        zeta: vec![0.0; shapes.ncols()],
        loads: at.clone(),
        supports: DMatrix::zeros(shapes.ncols(), 0),
    };
    let samples = (duration / fine).round() as usize + 1;
    let loads = Loads {
        interval: fine,
        history: DMatrix::from_fn(1, samples, |_, n| pulse(n as f64 * fine).powi(2)),
        final_values: vec![0.0],
    };
    let settings = Settings {
        step: fine,
        duration,
        decay: f64::INFINITY,
        start: Start::Rest,
        ..Settings::default()
    };
    let modal = respond(&[body], &[], &loads, &settings).unwrap();
    let modal = modal.points(0, &at, Motion::Displacement).unwrap();
    let peak = modal.amax();

    let dense = |lower: &nalgebra_sparse::CscMatrix<f64>| {
        let mut full = DMatrix::zeros(lower.nrows(), lower.ncols());
        for (i, j, value) in lower.triplet_iter() {
            full[(i, j)] = *value;
            full[(j, i)] = *value;
        }
        full
    };
    let (k, m) = (dense(&system.stiffness), dense(&system.mass));
    let force: DVector<f64> = system.equations.select(&load).unwrap().column(0).into_owned();
    // Newmark's average acceleration: (M + h^2/4 K) a1 = F1 - K (u + h v + h^2/4 a0).
    let newmark = |every: usize| {
        let h = fine * every as f64;
        let factor = Cholesky::new(&m + &k * (0.25 * h * h)).unwrap();
        let zero = || DVector::<f64>::zeros(force.len());
        let (mut u, mut v, mut a) = (zero(), zero(), zero());
        let mut worst: f64 = 0.0;
        for n in (every..samples).step_by(every) {
            u += &v * h + &a * (0.25 * h * h);
            v += &a * (0.5 * h);
            let f = pulse(n as f64 * fine).powi(2);
            a = factor.solve(&(&force * f - &k * &u));
            u += &a * (0.25 * h * h);
            v += &a * (0.5 * h);
            worst = worst.max((force.dot(&u) - modal[n]).abs());
        }
        worst / peak
    };
    let errors = [24, 12, 6].map(newmark);
    let orders = [(errors[0] / errors[1]).log2(), (errors[1] / errors[2]).log2()];
    assert!(
        orders.iter().all(|order| (order - 2.0).abs() < 0.1),
        "{errors:?} {orders:?}"
    );
    assert!(errors[2] < 5e-3, "{errors:?}");
}
