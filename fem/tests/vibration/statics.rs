//! Static equilibrium on unilateral supports.

use nailnoise_fem::vibration::{
    Loads, ModalBody, ModalResponse, Motion, Settings, Support, SupportLaw, TransientError, respond,
};
use nalgebra::DMatrix;

use crate::block_on_table::block_on_table;

fn short() -> Settings {
    Settings {
        duration: 2e-3,
        decay: f64::INFINITY,
        ..Settings::default()
    }
}

/// A rigid bar of 2.5 kg and length 1 on five points; loads: weight, and a push at x = `at`.
fn bar(at: f64) -> (ModalBody, Vec<Support>) {
    let m = 2.5f64;
    let x = [-0.5, -0.25, 0.0, 0.25, 0.5];
    let root = m.sqrt();
    let tilt = |x: f64| 12f64.sqrt() * x / root;
    let body = ModalBody {
        name: "bar".into(),
        omega: vec![0.0; 3],
        zeta: vec![0.0; 3],
        loads: DMatrix::from_row_slice(3, 2, &[root, 1.0 / root, 0.0, tilt(at), 0.0, 0.0]),
        supports: DMatrix::from_fn(3, 5, |j, i| [1.0 / root, tilt(x[i]), 0.0][j]),
    };
    let support = Support {
        stiffness: 1e6,
        damping: 50.0,
        gap: 0.0,
        law: SupportLaw::Unilateral,
    };
    (body, vec![support; 5])
}

/// Pushes \[N\] and their places, with the response of the bar.
fn pushed() -> impl Iterator<Item = (f64, f64, ModalResponse)> {
    [(0.0, 0.0), (30.0, 0.1), (60.0, 0.3), (500.0, 0.45)]
        .into_iter()
        .map(|(push, at)| {
            let (body, supports) = bar(at);
            let r = respond(&[body], &supports, &Loads::constant(&[9.81, push]), &short()).unwrap();
            (push, at, r)
        })
}

#[test]
fn reactions_carry_weight_and_moment() {
    for (push, at, r) in pushed() {
        let f = r.contact_forces.column(0);
        let x = [-0.5, -0.25, 0.0, 0.25, 0.5];
        let (sum, moment) = (f.sum(), f.iter().zip(x).map(|(f, x)| f * x).sum::<f64>());
        assert!((sum / (2.5 * 9.81 + push) - 1.0).abs() < 1e-12, "{push}: {sum}");
        assert!((moment - push * at).abs() < 1e-11 * sum, "{push}: {moment}");
    }
}

#[test]
fn reactions_push_and_the_far_end_lifts_off_under_a_large_moment() {
    for (push, at, r) in pushed() {
        let f = r.contact_forces.column(0);
        assert!(f.iter().all(|f| *f >= 0.0));
        // The far end lifts off once N/5 < M (1/2)/(5/8).
        assert_eq!(
            f[0] == 0.0,
            push * at > 0.25 * (2.5 * 9.81 + push),
            "{push} at {at}: {f}"
        );
    }
}

#[test]
fn a_body_in_equilibrium_stays_at_rest() {
    for (push, _, r) in pushed() {
        let a = r.modal(0, 0..3, Motion::Acceleration).unwrap();
        assert!(
            a.amax() < 1e-10 * r.contact_forces.column(0).sum(),
            "{push}: {:e}",
            a.amax()
        );
        assert!(r.energy.kinetic[0].iter().all(|t| *t < 1e-24));
    }
}

#[test]
fn a_block_on_a_flexible_table_starts_at_rest_and_stays() {
    let mut case = block_on_table(40, 60, SupportLaw::Unilateral);
    let first = case.loads.history.column(0).into_owned();
    case.loads = Loads::constant(first.as_slice());
    let r = respond(&case.bodies, &case.supports, &case.loads, &short()).unwrap();
    let sum = r.contact_forces.column(0).sum();
    // The push is load 2; it acts off the centre, so a few points may be open.
    assert!((sum / (2.534 * 9.81 + first[2]) - 1.0).abs() < 1e-11, "{sum}");
    let drift = (0..r.samples()).map(|n| (r.contact_forces.column(n) - r.contact_forces.column(0)).amax());
    assert!(drift.fold(0.0, f64::max) < 1e-9 * sum);
    assert!(
        r.energy.kinetic.iter().flatten().all(|t| *t < 1e-20),
        "{:?}",
        r.energy.kinetic
    );
    assert!(r.energy.strain[1][0] > 1e-8, "the table bends under the block");
}

fn refused(body: &ModalBody, loads: [f64; 2]) -> TransientError {
    let supports = bar(0.8).1;
    let body = std::slice::from_ref(body);
    respond(body, &supports, &Loads::constant(&loads), &short()).unwrap_err()
}

#[test]
fn a_bar_that_tips_or_is_lifted_off_has_no_equilibrium() {
    let (body, _) = bar(0.8);
    for loads in [[9.81, 500.0], [-9.81, 0.0]] {
        let error = refused(&body, loads);
        assert!(matches!(error, TransientError::NoEquilibrium { .. }), "{error}");
    }
}

#[test]
fn a_load_along_an_unsupported_motion_is_refused_by_body_and_share() {
    let (mut sideways, _) = bar(0.8);
    sideways.loads[(2, 1)] = 0.5;
    let error = refused(&sideways, [9.81, 5.0]);
    let TransientError::NotSupported { share, body } = error else {
        panic!("{error}")
    };
    assert!(share > 0.01 && body == "bar");
}

#[test]
fn an_unsupported_load_within_rounding_is_accepted_and_reported() {
    let (mut sideways, supports) = bar(0.8);
    sideways.loads[(2, 1)] = 1e-9;
    let r = respond(&[sideways], &supports, &Loads::constant(&[9.81, 1.0]), &short()).unwrap();
    assert!(r.unsupported_load > 0.0 && r.unsupported_load < 1e-8);
}
