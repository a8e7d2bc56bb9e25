//! Masses on unilateral or bonded springs and dashpots, compared with closed forms.

use std::f64::consts::PI;

use nailnoise_fem::vibration::{
    Loads, ModalBody, ModalResponse, ModalState, Motion, Settings, Start, Support, SupportLaw, TransientError, respond,
};
use nalgebra::DMatrix;

/// A rigid mass that moves along its outward normal; one load and any number of supports in parallel.
fn mass(m: f64, supports: usize) -> ModalBody {
    ModalBody {
        name: "mass".into(),
        omega: vec![0.0],
        zeta: vec![0.0],
        loads: DMatrix::from_element(1, 1, 1.0 / m.sqrt()),
        supports: DMatrix::from_element(1, supports, 1.0 / m.sqrt()),
    }
}

fn support(stiffness: f64, damping: f64, law: SupportLaw) -> Support {
    Support {
        stiffness,
        damping,
        gap: 0.0,
        law,
    }
}

fn settings(step: f64, duration: f64, start: Start) -> Settings {
    Settings {
        step,
        duration,
        decay: f64::INFINITY,
        energy_interval: 10.0 * step,
        start,
        ..Settings::default()
    }
}

fn flying(m: f64, height: f64, speed: f64) -> Start {
    let state = ModalState {
        displacement: vec![-height * m.sqrt()],
        velocity: vec![speed * m.sqrt()],
    };
    Start::State(vec![state])
}

fn motion(r: &ModalResponse, m: f64, motion: Motion) -> Vec<f64> {
    let shape = DMatrix::from_element(1, 1, 1.0 / m.sqrt());
    r.points(0, &shape, motion).expect("one mode").as_slice().to_vec()
}

fn order(errors: &[f64]) -> f64 {
    (errors[0] / errors[errors.len() - 1]).log2() / (errors.len() - 1) as f64
}

/// A dashpot half-space: m v' + c v = F.
#[test]
fn a_mass_on_a_dashpot_approaches_its_final_speed_exponentially() {
    let (m, c, force, duration) = (2.5, 17_000.0, 40.0, 1e-3);
    let mut errors = Vec::new();
    for step in [8e-6, 4e-6, 2e-6] {
        let supports = [
            support(0.0, 0.4 * c, SupportLaw::Bonded),
            support(0.0, 0.6 * c, SupportLaw::Bonded),
        ];
        let r = respond(
            &[mass(m, 2)],
            &supports,
            &Loads::constant(&[force]),
            &settings(step, duration, Start::Rest),
        );
        let r = r.unwrap();
        crate::passes_its_checks(&r);
        let v = motion(&r, m, Motion::Velocity);
        let exact = |t: f64| force / c * (1.0 - (-c / m * t).exp());
        let error = (0..v.len()).fold(0.0f64, |e, n| e.max((v[n] - exact(n as f64 * step)).abs()));
        errors.push(error * c / force);
        let lost = r.energy.contact_lost.last().unwrap();
        let t = duration;
        let tau = m / c;
        let paid =
            force * force / c * (t - 2.0 * tau * (1.0 - (-t / tau).exp()) + 0.5 * tau * (1.0 - (-2.0 * t / tau).exp()));
        assert!((lost / paid - 1.0).abs() < 1e-3, "{lost} {paid}");
    }
    assert!((order(&errors) - 2.0).abs() < 0.1 && errors[2] < 2e-5, "{errors:?}");
}

#[test]
fn a_mass_on_a_bonded_spring_and_dashpot_is_a_damped_oscillator() {
    let (m, k, zeta, force) = (2.5f64, 1.76e7f64, 0.4f64, 60.0);
    let omega = (k / m).sqrt();
    let c = 2.0 * zeta * omega * m;
    let wd = omega * (1.0 - zeta * zeta).sqrt();
    let exact = |t: f64| {
        let (s, cos) = (wd * t).sin_cos();
        force / k * (1.0 - (-zeta * omega * t).exp() * (cos + zeta * omega / wd * s))
    };
    let mut errors = Vec::new();
    for step in [8e-6, 4e-6, 2e-6] {
        let r = respond(
            &[mass(m, 1)],
            &[support(k, c, SupportLaw::Bonded)],
            &Loads::constant(&[force]),
            &settings(step, 5e-3, Start::Rest),
        )
        .unwrap();
        crate::passes_its_checks(&r);
        let u = motion(&r, m, Motion::Displacement);
        errors.push((0..u.len()).fold(0.0f64, |e, n| e.max((u[n] - exact(n as f64 * step)).abs())) * k / force);
    }
    assert!((order(&errors) - 2.0).abs() < 0.1 && errors[1] < 1e-4, "{errors:?}");
}

#[test]
fn an_elastic_impact_lasts_half_a_period_and_returns_all_energy() {
    let (m, k, speed) = (2.534f64, 4.95e8f64, 0.3);
    let contact_time = PI * (m / k).sqrt();
    let mut errors = Vec::new();
    for step in [2e-6, 1e-6, 0.5e-6] {
        let supports = [
            support(0.3 * k, 0.0, SupportLaw::Unilateral),
            support(0.7 * k, 0.0, SupportLaw::Unilateral),
        ];
        let start = flying(m, 0.37e-6, speed);
        let r = respond(
            &[mass(m, 2)],
            &supports,
            &Loads::constant(&[0.0]),
            &settings(step, 6e-4, start),
        )
        .unwrap();
        crate::passes_its_checks(&r);
        let touching = (0..r.samples())
            .filter(|&n| r.contact_forces.column(n).sum() > 0.0)
            .count() as f64
            * step;
        assert!(
            (touching - contact_time).abs() < 2.0 * step,
            "{touching} {contact_time}"
        );
        let peak = (0..r.samples())
            .map(|n| r.contact_forces.column(n).sum())
            .fold(0.0, f64::max);
        assert!((peak / (speed * (k * m).sqrt()) - 1.0).abs() < 2e-3, "{peak}");
        let v = motion(&r, m, Motion::Velocity);
        errors.push((v[v.len() - 1] / -speed - 1.0).abs());
        assert!(r.contact_forces.iter().all(|f| *f >= 0.0));
    }
    // The moment of touching falls anywhere within a step: order two as an envelope, not from run to run.
    assert!(errors[0] < 4e-3 && errors[1] < 1e-3 && errors[2] < 2.5e-4, "{errors:?}");
}

/// With f = k d + c d' until f = 0: e = exp(-zeta omega t*) with t* the first zero of the acceleration.
#[test]
fn a_damped_impact_has_the_closed_form_restitution() {
    let (m, k, speed) = (2.534f64, 4.95e8f64, 0.3);
    let omega = (k / m).sqrt();
    for zeta in [0.05f64, 0.2, 0.6] {
        let c = 2.0 * zeta * omega * m;
        let wd = omega * (1.0 - zeta * zeta).sqrt();
        let turn = (wd / omega * 2.0 * zeta).atan2(2.0 * zeta * zeta - 1.0);
        let t = turn / wd;
        let d = (-zeta * omega * t).exp() * (wd * t).sin() / wd;
        let restitution = omega / (2.0 * zeta) * d;
        let mut errors = Vec::new();
        for step in [2e-6, 1e-6, 0.5e-6, 0.25e-6] {
            let supports = [support(k, c, SupportLaw::Unilateral)];
            // The mean over the phases of touching, which fall within a step.
            let mut mean = 0.0;
            for phase in 0..8 {
                let start = flying(m, speed * step * (f64::from(phase) + 0.5) / 8.0, speed);
                let settings = settings(step, 8e-4, start);
                let r = respond(&[mass(m, 1)], &supports, &Loads::constant(&[0.0]), &settings).unwrap();
                crate::passes_its_checks(&r);
                let v = motion(&r, m, Motion::Velocity);
                let lost = r.energy.contact_lost.last().unwrap() / (0.5 * m * speed * speed);
                let e = -v[v.len() - 1] / speed;
                assert!((lost - (1.0 - e * e)).abs() < 1e-4, "{lost} {e}");
                mean += (e - restitution).abs() / 8.0;
            }
            errors.push(mean);
        }
        // The dashpot's force jumps at first touch: order one.
        let order = order(&errors);
        assert!(
            order > 0.9 && errors[3] < 3e-3,
            "zeta {zeta}: {errors:?} order {order} e {restitution}"
        );
    }
}

/// Without damping the total energy is constant, and a flight takes 2 v/g.
#[test]
fn a_block_bouncing_under_gravity_conserves_its_energy() {
    let (m, k, g, height) = (2.534f64, 1e7f64, 9.81, 1e-3);
    let start = flying(m, height, 0.0);
    let r = respond(
        &[mass(m, 1)],
        &[support(k, 0.0, SupportLaw::Unilateral)],
        &Loads::constant(&[m * g]),
        &settings(4e-6, 0.3, start),
    )
    .unwrap();
    crate::passes_its_checks(&r);
    let u = motion(&r, m, Motion::Displacement);
    let highest = u[60_000..].iter().fold(f64::INFINITY, |a, b| a.min(*b));
    assert!((highest / -height - 1.0).abs() < 2e-3, "{highest}");
    assert!(r.open_fraction > 0.9 && r.open_fraction < 0.99, "{}", r.open_fraction);
    let flight = 2.0 * (2.0 * height / g).sqrt();
    let touchdowns: Vec<usize> = (1..r.samples())
        .filter(|&n| r.contact_forces[(0, n)] > 0.0 && r.contact_forces[(0, n - 1)] == 0.0)
        .collect();
    let period = (touchdowns[touchdowns.len() - 1] - touchdowns[0]) as f64 * r.step / (touchdowns.len() - 1) as f64;
    assert!(
        period > flight && (period - flight - PI * (m / k).sqrt()).abs() < 0.03 * flight,
        "{period} {flight}"
    );
    assert!(r.energy.contact_lost.iter().all(|e| e.abs() < 1e-3 * m * g * height));
}

fn refused(supports: &[Support], settings: &Settings) -> TransientError {
    let bodies = [mass(2.5, supports.len())];
    respond(&bodies, supports, &Loads::constant(&[1.0]), settings).unwrap_err()
}

fn accepted(supports: &[Support], settings: &Settings) {
    let bodies = [mass(2.5, supports.len())];
    respond(&bodies, supports, &Loads::constant(&[1.0]), settings).unwrap();
}

#[test]
fn a_contact_too_stiff_for_the_step_is_refused_with_a_step_that_works() {
    let stiff = [support(1e13, 0.0, SupportLaw::Unilateral)];
    let error = refused(&stiff, &settings(4e-6, 1e-3, Start::Rest));
    let TransientError::ContactBeyondStep { remedy, .. } = error else {
        panic!("{error}")
    };
    accepted(&stiff, &settings(0.99 * remedy, 1e-4, Start::Equilibrium));
}

/// A support 10 mm away, which 1 N on 2.5 kg does not reach within 1 ms.
fn far() -> [Support; 1] {
    [Support {
        gap: 1e-2,
        ..support(1e7, 0.0, SupportLaw::Unilateral)
    }]
}

#[test]
fn a_support_that_is_never_touched_is_refused_with_its_distance() {
    let error = refused(&far(), &settings(4e-6, 1e-3, Start::Rest));
    let TransientError::SupportNeverTouches { gap, .. } = error else {
        panic!("{error}")
    };
    assert!((gap - (1e-2 - 0.5 / 2.5 * 1e-6)).abs() < 1e-12, "{gap}");
}

#[test]
fn a_support_may_stay_open_if_no_contact_is_required() {
    let settings = Settings {
        require_contact: false,
        ..settings(4e-6, 1e-3, Start::Rest)
    };
    accepted(&far(), &settings);
}

#[test]
fn a_stiffness_that_is_not_finite_is_refused() {
    let error = refused(
        &[support(f64::NAN, 0.0, SupportLaw::Bonded)],
        &settings(4e-6, 1e-3, Start::Rest),
    );
    assert!(matches!(error, TransientError::Value { .. }), "{error}");
}

#[test]
fn a_body_with_another_number_of_supports_is_refused() {
    let two = [support(1e7, 0.0, SupportLaw::Bonded); 2];
    let settings = settings(4e-6, 1e-3, Start::Rest);
    let error = respond(&[mass(2.5, 1)], &two, &Loads::constant(&[1.0]), &settings);
    assert!(matches!(
        error.unwrap_err(),
        TransientError::Size {
            expected: 2,
            found: 1,
            ..
        }
    ));
}
