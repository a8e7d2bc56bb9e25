//! Flexible bodies in contact: an independent integration, conservation laws, linearity, replay of modes.

use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

use nailnoise_fem::vibration::{
    Ending, Loads, ModalBody, ModalResponse, ModalState, Motion, Settings, Start, Support, SupportLaw, respond,
};
use nalgebra::{DMatrix, DVector};

/// A free beam on a clamped one, three contact points: rigid translation and rotation, bending modes of cosines. Modes
/// count downwards in both, so that the outward normals are +1 (upper) and -1 (lower).
fn beams(law: SupportLaw, stiffness: f64, damping: f64) -> (Vec<ModalBody>, Vec<Support>) {
    let at = [-0.5f64, 0.1, 0.5];
    let (m1, m2) = (2.5f64, 6.0f64);
    let shape = |k: usize, x: f64| match k {
        0 => 1.0,
        1 => 12f64.sqrt() * x,
        _ => 2f64.sqrt() * (k as f64 * PI * (x + 0.5)).cos(),
    };
    let free = ModalBody {
        name: "upper".into(),
        omega: vec![0.0, 0.0, TAU * 900.0, TAU * 2100.0],
        zeta: vec![0.0, 0.0, 0.01, 0.02],
        loads: DMatrix::from_fn(4, 2, |j, l| {
            if l == 1 {
                if j == 0 { m1.sqrt() } else { 0.0 }
            } else {
                shape(j, 0.2) / m1.sqrt()
            }
        }),
        supports: DMatrix::from_fn(4, 3, |j, i| shape(j, at[i]) / m1.sqrt()),
    };
    let clamped = ModalBody {
        name: "lower".into(),
        omega: vec![TAU * 120.0, TAU * 310.0, TAU * 1400.0],
        zeta: vec![0.015, 0.03, 0.0],
        loads: DMatrix::from_fn(3, 2, |j, l| if l == 1 && j == 0 { m2.sqrt() } else { 0.0 }),
        supports: DMatrix::from_fn(3, 3, |j, i| -shape(j, at[i]) / m2.sqrt()),
    };
    let supports = (0..3)
        .map(|i| Support {
            stiffness,
            damping,
            gap: 2e-6 * i as f64,
            law,
        })
        .collect();
    (vec![free, clamped], supports)
}

/// A push that fades and a blow; gravity as the second load.
fn blow(t: f64) -> f64 {
    let burst = if (5e-4..2.5e-3).contains(&t) {
        900.0 * (PI * (t - 5e-4) / 2e-3).sin().powi(2)
    } else {
        0.0
    };
    40.0 + burst
}

fn loads(step: f64, duration: f64) -> Loads {
    let samples = (duration / step).round() as usize + 1;
    let history = DMatrix::from_fn(2, samples, |l, n| if l == 0 { blow(n as f64 * step) } else { 9.81 });
    Loads {
        interval: step,
        history,
        final_values: vec![40.0, 9.81],
    }
}

fn settings(step: f64, duration: f64, start: Start) -> Settings {
    Settings {
        step,
        duration,
        start,
        decay: f64::INFINITY,
        ..Settings::default()
    }
}

/// Classical Runge-Kutta of the second-order system with the law written out afresh; returns all q at the end.
fn runge_kutta(
    bodies: &[ModalBody],
    supports: &[Support],
    start: &[ModalState],
    step: f64,
    steps: usize,
) -> DVector<f64> {
    let modes: usize = bodies.iter().map(ModalBody::modes).sum();
    let (mut p, mut phi) = (DMatrix::zeros(modes, supports.len()), DMatrix::zeros(modes, 2));
    let (mut stiffness, mut damping) = (DVector::zeros(modes), DVector::zeros(modes));
    let (mut q, mut v) = (DVector::zeros(modes), DVector::zeros(modes));
    let mut offset = 0;
    for (body, state) in bodies.iter().zip(start) {
        p.rows_mut(offset, body.modes()).copy_from(&body.supports);
        phi.rows_mut(offset, body.modes()).copy_from(&body.loads);
        for j in 0..body.modes() {
            stiffness[offset + j] = body.omega[j].powi(2);
            damping[offset + j] = 2.0 * body.zeta[j] * body.omega[j];
            q[offset + j] = state.displacement[j];
            v[offset + j] = state.velocity[j];
        }
        offset += body.modes();
    }
    let acceleration = |t: f64, q: &DVector<f64>, v: &DVector<f64>| {
        let (d, rate) = (p.tr_mul(q), p.tr_mul(v));
        let force = DVector::from_fn(supports.len(), |i, _| {
            let s = &supports[i];
            let d = d[i] - s.gap;
            let linear = s.stiffness * d + s.damping * rate[i];
            match s.law {
                SupportLaw::Bonded => linear,
                SupportLaw::Unilateral => {
                    if d > 0.0 {
                        linear.max(0.0)
                    } else {
                        0.0
                    }
                }
            }
        });
        let applied = &phi * DVector::from_vec(vec![blow(t), 9.81]);
        applied - &p * force - stiffness.component_mul(q) - damping.component_mul(v)
    };
    for n in 0..steps {
        let t = n as f64 * step;
        let a1 = acceleration(t, &q, &v);
        let (q2, v2) = (&q + &v * (step / 2.0), &v + &a1 * (step / 2.0));
        let a2 = acceleration(t + step / 2.0, &q2, &v2);
        let (q3, v3) = (&q + &v2 * (step / 2.0), &v + &a2 * (step / 2.0));
        let a3 = acceleration(t + step / 2.0, &q3, &v3);
        let (q4, v4) = (&q + &v3 * step, &v + &a3 * step);
        let a4 = acceleration(t + step, &q4, &v4);
        q += (&v + &v2 * 2.0 + &v3 * 2.0 + &v4) * (step / 6.0);
        v += (a1 + a2 * 2.0 + a3 * 2.0 + a4) * (step / 6.0);
    }
    q
}

/// Errors of all modes at the end against Runge-Kutta, relative to the largest, for three steps.
fn errors(law: SupportLaw, damping: f64) -> (Vec<f64>, f64) {
    let (bodies, supports) = beams(law, 3e7, damping);
    let duration = 8e-3;
    let at_rest = respond(
        &bodies,
        &supports,
        &loads(8e-6, duration),
        &settings(8e-6, duration, Start::Equilibrium),
    );
    let start = at_rest.expect("an equilibrium").start;
    let reference = runge_kutta(&bodies, &supports, &start, 1e-7, 80_000);
    let mut open = 0.0;
    let mut found = Vec::new();
    for step in [8e-6, 4e-6, 2e-6] {
        let r = respond(
            &bodies,
            &supports,
            &loads(step, duration),
            &settings(step, duration, Start::Equilibrium),
        );
        let r = r.expect("a valid run");
        crate::passes_its_checks(&r);
        let end: Vec<f64> = r.end.iter().flat_map(|s| s.displacement.clone()).collect();
        found.push((DVector::from_vec(end) - &reference).amax() / reference.amax());
        open = r.open_fraction;
    }
    (found, open)
}

#[test]
fn elastic_contact_converges_to_runge_kutta_with_order_two() {
    let (errors, open) = errors(SupportLaw::Unilateral, 0.0);
    assert!(open > 0.02, "the bodies must part: {open}");
    let order = (errors[0] / errors[2]).log2() / 2.0;
    assert!(order > 1.7 && order < 2.6 && errors[2] < 1e-4, "{errors:?} {order}");
}

#[test]
fn bonded_contact_converges_to_runge_kutta_with_order_two() {
    let (errors, _) = errors(SupportLaw::Bonded, 900.0);
    let order = (errors[0] / errors[2]).log2() / 2.0;
    assert!((order - 2.0).abs() < 0.1 && errors[2] < 1e-4, "{errors:?} {order}");
}

#[test]
fn damped_contact_converges_to_runge_kutta() {
    let (errors, open) = errors(SupportLaw::Unilateral, 900.0);
    assert!(open > 0.02, "the bodies must part: {open}");
    let order = (errors[0] / errors[2]).log2() / 2.0;
    assert!(order > 0.7 && errors[2] < 2e-3, "{errors:?} {order}");
}

#[test]
fn two_free_bodies_conserve_their_momentum() {
    let (mut bodies, supports) = beams(SupportLaw::Unilateral, 3e7, 500.0);
    bodies[1].omega[0] = 0.0;
    let start = vec![
        ModalState {
            displacement: vec![0.0; 4],
            velocity: vec![0.5 * 2.5f64.sqrt(), 0.01, 0.0, 0.0],
        },
        ModalState::rest(3),
    ];
    let quiet = Loads::constant(&[0.0, 0.0]);
    let r = respond(&bodies, &supports, &quiet, &settings(2e-6, 0.02, Start::State(start))).unwrap();
    crate::passes_its_checks(&r);
    assert!(r.contact_forces.max() > 100.0);
    let momentum = 2.5f64.sqrt() * r.end[0].velocity[0] + 6f64.sqrt() * r.end[1].velocity[0];
    assert!((momentum / (2.5 * 0.5) - 1.0).abs() < 1e-12, "{momentum}");
    assert!(*r.energy.contact_lost.last().unwrap() > 0.0);
}

/// With a wrong sign of the normal of one body, the forces push both bodies the same way.
#[test]
fn a_wrong_normal_violates_the_conservation_of_momentum() {
    let (mut bodies, supports) = beams(SupportLaw::Unilateral, 3e7, 500.0);
    bodies[1].omega[0] = 0.0;
    let start = vec![
        ModalState {
            displacement: vec![0.0; 4],
            velocity: vec![0.5 * 2.5f64.sqrt(), 0.0, 0.0, 0.0],
        },
        ModalState::rest(3),
    ];
    bodies[1].supports.row_mut(0).fill(1.0 / 6f64.sqrt());
    let quiet = Loads::constant(&[0.0, 0.0]);
    let r = respond(&bodies, &supports, &quiet, &settings(2e-6, 0.02, Start::State(start))).unwrap();
    let momentum = 2.5f64.sqrt() * r.end[0].velocity[0] + 6f64.sqrt() * r.end[1].velocity[0];
    assert!((momentum / (2.5 * 0.5) - 1.0).abs() > 0.1);
}

#[test]
fn twice_the_forces_on_bonded_supports_give_exactly_twice_the_response() {
    let (bodies, mut supports) = beams(SupportLaw::Bonded, 3e7, 900.0);
    supports.iter_mut().for_each(|s| s.gap = 0.0);
    let single = loads(4e-6, 8e-3);
    let mut double = single.clone();
    double.history *= 2.0;
    double.final_values.iter_mut().for_each(|x| *x *= 2.0);
    let settings = settings(4e-6, 0.02, Start::Equilibrium);
    let a = respond(&bodies, &supports, &single, &settings).unwrap();
    let b = respond(&bodies, &supports, &double, &settings).unwrap();
    assert_eq!(&a.contact_forces * 2.0, b.contact_forces);
    for (body, of) in bodies.iter().enumerate() {
        let modes = 0..of.modes();
        let [x, y] = [&a, &b].map(|r| r.modal(body, modes.clone(), Motion::Acceleration).unwrap());
        assert_eq!(x * 2.0, y);
    }
}

/// A bouncing run, with its supports and the shapes of its contact points.
struct Bouncing {
    bodies: Vec<ModalBody>,
    supports: Vec<Support>,
    response: ModalResponse,
}

static BOUNCING: LazyLock<Bouncing> = LazyLock::new(|| {
    let (bodies, supports) = beams(SupportLaw::Unilateral, 3e7, 900.0);
    let settings = settings(4e-6, 0.05, Start::Equilibrium);
    let response = respond(&bodies, &supports, &loads(4e-6, 8e-3), &settings).unwrap();
    Bouncing {
        bodies,
        supports,
        response,
    }
});

#[test]
fn replayed_modes_end_in_the_final_state_of_the_run() {
    let r = &BOUNCING.response;
    for (body, end) in r.end.iter().enumerate() {
        let (q, v) = (
            r.modal(body, 0..end.displacement.len(), Motion::Displacement).unwrap(),
            r.modal(body, 0..end.displacement.len(), Motion::Velocity).unwrap(),
        );
        let (last, top) = (r.samples() - 1, (q.amax(), v.amax()));
        for j in 0..end.displacement.len() {
            assert!((q[(last, j)] - end.displacement[j]).abs() < 1e-11 * top.0);
            assert!((v[(last, j)] - end.velocity[j]).abs() < 1e-11 * top.1);
        }
    }
}

#[test]
fn dissipated_energy_never_falls() {
    for history in &BOUNCING.response.energy.dissipated {
        let total = history[history.len() - 1];
        assert!(history.windows(2).all(|w| w[1] >= w[0] - 1e-14 * total) && total > 0.0);
    }
}

#[test]
fn replayed_penetrations_obey_the_contact_law_at_every_sample() {
    let Bouncing {
        bodies,
        supports,
        response: r,
    } = &*BOUNCING;
    let motion = |body: usize, motion| r.points(body, &bodies[body].supports, motion).unwrap();
    let d = motion(0, Motion::Displacement) + motion(1, Motion::Displacement);
    let rate = motion(0, Motion::Velocity) + motion(1, Motion::Velocity);
    let peak = r.contact_forces.max();
    for n in 1..r.samples() {
        for (i, s) in supports.iter().enumerate() {
            let (f, d) = (r.contact_forces[(i, n)], d[(n, i)] - s.gap);
            let law = s.stiffness * d + s.damping * rate[(n, i)];
            assert!(f >= 0.0);
            if f > 0.0 {
                assert!((f - law).abs() < 1e-8 * peak, "sample {n} support {i}: {f} {law}");
            } else {
                assert!(
                    d < 1e-9 || law < 1e-8 * peak,
                    "sample {n} support {i}: open at {d:e}, law {law}"
                );
            }
        }
    }
}

#[test]
fn the_motion_at_single_samples_equals_that_of_the_whole_run() {
    let r = &BOUNCING.response;
    let some = [0, 1, 127, 128, 129, 5000, r.samples() - 1];
    for (body, end) in r.end.iter().enumerate() {
        for motion in [Motion::Displacement, Motion::Velocity, Motion::Acceleration] {
            let all = r.modal(body, 0..end.displacement.len(), motion).unwrap();
            let found = r.at(body, &some, motion).unwrap();
            let error = (found.transpose() - all.select_rows(&some)).amax();
            assert!(error < 1e-10 * all.amax(), "{motion:?} of body {body}: {error:e}");
        }
    }
}

#[test]
fn an_unknown_body_mode_or_sample_is_refused() {
    let r = &BOUNCING.response;
    assert!(r.modal(2, 0..1, Motion::Velocity).is_err() && r.modal(0, 0..5, Motion::Velocity).is_err());
    assert!(r.at(2, &[0], Motion::Velocity).is_err() && r.at(0, &[r.samples()], Motion::Velocity).is_err());
}

/// Strongly damped beams, and settings that end the run 40 dB below its peak energy.
fn decaying() -> (Vec<ModalBody>, Vec<Support>, Settings) {
    let (mut bodies, supports) = beams(SupportLaw::Unilateral, 3e7, 3e4);
    bodies.iter_mut().for_each(|b| b.zeta.fill(0.2));
    let settings = Settings {
        decay: 40.0,
        ..settings(4e-6, 0.5, Start::Equilibrium)
    };
    (bodies, supports, settings)
}

#[test]
fn a_run_ends_when_its_energy_has_decayed() {
    let (bodies, supports, settings) = decaying();
    let r = respond(&bodies, &supports, &loads(4e-6, 8e-3), &settings).unwrap();
    let Ending::Decayed {
        level,
        over_equilibrium: true,
    } = r.ending
    else {
        panic!("{:?}", r.ending)
    };
    assert!(
        level <= -40.0 && r.duration() < 0.5 && r.duration() > 8e-3 + settings.taper,
        "{level} {}",
        r.duration()
    );
}

#[test]
fn a_run_ends_at_its_duration_if_its_energy_has_not_decayed() {
    let (bodies, supports, settings) = decaying();
    let settings = Settings {
        duration: 0.01,
        ..settings
    };
    let r = respond(&bodies, &supports, &loads(4e-6, 8e-3), &settings).unwrap();
    assert!(matches!(r.ending, Ending::Duration { .. }) && (r.duration() - 0.01).abs() < 1e-12);
}

/// A mode far above the sampling rate contributes only its static compliance.
#[test]
fn a_mode_beyond_the_step_follows_statically() {
    let body = ModalBody {
        name: "residual".into(),
        omega: vec![4e6],
        zeta: vec![0.01],
        loads: DMatrix::from_element(1, 1, 1.0),
        supports: DMatrix::zeros(1, 0),
    };
    let history = DMatrix::from_fn(1, 1001, |_, n| (PI * n as f64 / 1000.0).sin().powi(2));
    let loads = Loads {
        interval: 4e-6,
        history: history.clone(),
        final_values: vec![0.0],
    };
    let r = respond(&[body], &[], &loads, &settings(4e-6, 4e-3, Start::Equilibrium)).unwrap();
    assert_eq!(r.work.modes_beyond_step, 1);
    let q = r.modal(0, 0..1, Motion::Displacement).unwrap();
    assert!((0..1001).all(|n| (q[(n, 0)] * 1.6e13 - history[(0, n)]).abs() < 2e-3));
}
