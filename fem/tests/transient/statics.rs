//! Static equilibrium on unilateral supports.

mod transient_case;

use nailnoise_fem::transient::{Loads, ModalBody, Motion, Settings, Support, SupportLaw, TransientError, respond};
use nalgebra::DMatrix;

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

#[test]
fn reactions_carry_weight_and_moment_and_the_body_stays_at_rest() {
    for (push, at) in [(0.0, 0.0), (30.0, 0.1), (60.0, 0.3), (500.0, 0.45)] {
        let (body, supports) = bar(at);
        let r = respond(&[body], &supports, &Loads::constant(&[9.81, push]), &short()).unwrap();
        let f = r.contact_forces.column(0);
        let x = [-0.5, -0.25, 0.0, 0.25, 0.5];
        let (sum, moment) = (f.sum(), f.iter().zip(x).map(|(f, x)| f * x).sum::<f64>());
        assert!((sum / (2.5 * 9.81 + push) - 1.0).abs() < 1e-12, "{push}: {sum}");
        assert!((moment - push * at).abs() < 1e-11 * sum, "{push}: {moment}");
        assert!(f.iter().all(|f| *f >= 0.0));
        // The far end lifts off once N/5 < M (1/2)/(5/8).
        assert_eq!(
            f[0] == 0.0,
            push * at > 0.25 * (2.5 * 9.81 + push),
            "{push} at {at}: {f}"
        );
        let a = r.modal(0, 0..3, Motion::Acceleration).unwrap();
        assert!(a.amax() < 1e-10 * sum, "{push}: {:e}", a.amax());
        assert!(r.energy.kinetic[0].iter().all(|t| *t < 1e-24));
    }
}

#[test]
fn a_block_on_a_flexible_table_starts_at_rest_and_stays() {
    let mut case = transient_case::block_on_table(40, 60, SupportLaw::Unilateral);
    let first = case.loads.history.column(0).into_owned();
    case.loads = Loads::constant(first.as_slice());
    let r = respond(&case.bodies, &case.supports, &case.loads, &short()).unwrap();
    let sum = r.contact_forces.column(0).sum();
    // The push is load 2; it sits beside the centre, so a few points may be open.
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

#[test]
fn loads_that_nothing_holds_are_named() {
    let (body, supports) = bar(0.8);
    let run = |body: &ModalBody, loads: [f64; 2]| {
        respond(
            std::slice::from_ref(body),
            &supports,
            &Loads::constant(&loads),
            &short(),
        )
        .map(|_| ())
        .unwrap_err()
    };
    // Beyond the last point: the bar tips.
    assert!(matches!(
        run(&body, [9.81, 500.0]),
        TransientError::NoEquilibrium { .. }
    ));
    // Lifted off.
    assert!(matches!(run(&body, [-9.81, 0.0]), TransientError::NoEquilibrium { .. }));
    // Along a motion that no support feels.
    let mut sideways = body;
    sideways.loads[(2, 1)] = 0.5;
    let error = run(&sideways, [9.81, 5.0]);
    let TransientError::NotSupported { share, body } = error else {
        panic!("{error}")
    };
    assert!(share > 0.01 && body == "bar");
    // Rounding of a rigid mode is let through and reported.
    sideways.loads[(2, 1)] = 1e-9;
    let r = respond(&[sideways], &supports, &Loads::constant(&[9.81, 1.0]), &short()).unwrap();
    assert!(r.unsupported_load > 0.0 && r.unsupported_load < 1e-8);
}
