//! One mode under step, ramp and half-sine against Duhamel's integral, in every damping regime.

use std::f64::consts::PI;

use nailnoise_fem::vibration::{Loads, ModalBody, Motion, Settings, Start, respond};
use nalgebra::DMatrix;

const STEP: f64 = 4e-6;

fn oscillator(omega: f64, zeta: f64) -> ModalBody {
    ModalBody {
        name: "oscillator".into(),
        omega: vec![omega],
        zeta: vec![zeta],
        loads: DMatrix::from_element(1, 1, 1.0),
        supports: DMatrix::zeros(1, 0),
    }
}

fn run(omega: f64, zeta: f64, step: f64, history: Vec<f64>, motion: Motion) -> Vec<f64> {
    let samples = history.len();
    let last = history[samples - 1];
    let loads = Loads {
        interval: step,
        history: DMatrix::from_vec(1, samples, history),
        final_values: vec![last],
    };
    let settings = Settings {
        step,
        duration: step * (samples - 1) as f64,
        decay: f64::INFINITY,
        start: Start::Rest,
        ..Settings::default()
    };
    let response = respond(&[oscillator(omega, zeta)], &[], &loads, &settings).expect("a valid run");
    assert!(response.checks.iter().all(|c| c.ok), "{:?}", response.checks);
    response.modal(0, 0..1, motion).expect("one mode").as_slice().to_vec()
}

/// Impulse response w, its integral I and double integral J at t, from complex exponentials of well-separated roots or
/// the critical closed form.
fn impulse(omega: f64, zeta: f64, t: f64) -> [f64; 3] {
    if omega == 0.0 {
        return [t, t * t / 2.0, t.powi(3) / 6.0];
    }
    let (damping, stiffness) = (2.0 * zeta * omega, omega * omega);
    let (w, slope) = if zeta < 1.0 {
        let wd = omega * (1.0 - zeta * zeta).sqrt();
        let decay = (-zeta * omega * t).exp();
        let (s, c) = (wd * t).sin_cos();
        (decay * s / wd, decay * (c - zeta * omega * s / wd))
    } else if zeta == 1.0 {
        let decay = (-omega * t).exp();
        (t * decay, (1.0 - omega * t) * decay)
    } else {
        let root = (zeta * zeta - 1.0).sqrt();
        let (l1, l2) = (-omega / (zeta + root), -omega * (zeta + root));
        let (e1, e2) = ((l1 * t).exp(), (l2 * t).exp());
        ((e1 - e2) / (l1 - l2), (l1 * e1 - l2 * e2) / (l1 - l2))
    };
    let integral = (1.0 - slope - damping * w) / stiffness;
    [w, integral, (t - w - damping * integral) / stiffness]
}

const REGIMES: [(f64, f64); 8] = [
    (700.0, 0.0),
    (9e3, 0.01),
    (7e4, 0.02),
    (5e5, 0.3),
    (3e3, 1.0),
    (2e5, 1.0),
    (3e3, 2.5),
    (6e5, 4.0),
];

#[test]
fn step_and_ramp_are_exact() {
    let samples = 5001;
    for (omega, zeta) in REGIMES {
        let step = run(omega, zeta, STEP, vec![1.0; samples], Motion::Displacement);
        let ramp: Vec<f64> = (0..samples).map(|n| n as f64 * STEP).collect();
        let ramp = run(omega, zeta, STEP, ramp, Motion::Displacement);
        // The scale of rounding: many small steps of a slow oscillator.
        let [peak_step, peak_ramp] = [&step, &ramp].map(|x| x.iter().fold(0.0f64, |m, x| m.max(x.abs())));
        for n in (0..samples).step_by(7) {
            let [_, integral, double] = impulse(omega, zeta, n as f64 * STEP);
            let (a, b) = (
                (step[n] - integral).abs() / peak_step,
                (ramp[n] - double).abs() / peak_ramp,
            );
            assert!(
                a < 1e-11 && b < 1e-11,
                "omega {omega} zeta {zeta} sample {n}: {a:e} {b:e}"
            );
        }
    }
}

#[test]
fn a_rigid_mode_follows_newton() {
    let samples = 75_001;
    let q = run(0.0, 0.0, STEP, vec![3.0; samples], Motion::Displacement);
    let v = run(0.0, 0.0, STEP, vec![3.0; samples], Motion::Velocity);
    let a = run(0.0, 0.0, STEP, vec![3.0; samples], Motion::Acceleration);
    let t = STEP * (samples - 1) as f64;
    assert!((q[samples - 1] / (1.5 * t * t) - 1.0).abs() < 1e-11);
    assert!((v[samples - 1] / (3.0 * t) - 1.0).abs() < 1e-11);
    assert!(a.iter().all(|a| *a == 3.0));
}

/// The recurrence is exact for loads that are linear between samples, so a half-sine converges with the square of the
/// step.
#[test]
fn a_half_sine_converges_with_order_two() {
    let (omega, zeta, length) = (9e3f64, 0.05, 4e-4);
    let p = PI / length;
    // Particular solution a sin pt + b cos pt, then free vibration.
    let (r, d) = (omega * omega - p * p, 2.0 * zeta * omega * p);
    let (a, b) = (r / (r * r + d * d), -d / (r * r + d * d));
    let exact = |t: f64| {
        let [w, _, _] = impulse(omega, zeta, t);
        let wd = omega * (1.0f64 - zeta * zeta).sqrt();
        let slope = (-zeta * omega * t).exp() * (wd * t).cos() - zeta * omega * w;
        // q(0) = q'(0) = 0 requires -b and -a p of free vibration.
        a * (p * t).sin() + b * (p * t).cos() - b * (slope + 2.0 * zeta * omega * w) - a * p * w
    };
    let mut errors = Vec::new();
    for parts in [20usize, 40, 80] {
        let h = length / parts as f64;
        let history = (0..=parts).map(|n| (p * n as f64 * h).sin()).collect();
        let q = run(omega, zeta, h, history, Motion::Displacement);
        let peak = q.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let error = (0..=parts).fold(0.0f64, |m, n| m.max((q[n] - exact(n as f64 * h)).abs()));
        errors.push(error / peak);
    }
    let orders = [(errors[0] / errors[1]).log2(), (errors[1] / errors[2]).log2()];
    assert!(orders.iter().all(|o| (o - 2.0).abs() < 0.1), "{errors:?} {orders:?}");
    assert!(errors[2] < 2e-4, "{errors:?}");
}

/// Velocity and acceleration belong to the displacement: central differences agree to their own order.
#[test]
fn motions_are_derivatives_of_each_other() {
    let history: Vec<f64> = (0..2001).map(|n| (PI * n as f64 / 2000.0).sin().powi(2)).collect();
    let q = run(5e3, 0.1, STEP, history.clone(), Motion::Displacement);
    let v = run(5e3, 0.1, STEP, history.clone(), Motion::Velocity);
    let a = run(5e3, 0.1, STEP, history, Motion::Acceleration);
    let [peak_v, peak_a] = [&v, &a].map(|x| x.iter().fold(0.0f64, |m, x| m.max(x.abs())));
    for n in 1..2000 {
        let dq = (q[n + 1] - q[n - 1]) / (2.0 * STEP);
        let dv = (v[n + 1] - v[n - 1]) / (2.0 * STEP);
        assert!(
            (dq - v[n]).abs() < 2e-4 * peak_v && (dv - a[n]).abs() < 2e-4 * peak_a,
            "sample {n}"
        );
    }
}
