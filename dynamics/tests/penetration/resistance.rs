//! The resistance law of a cycle: a constant force, or a published law with its terms.

use nailnoise_dynamics::{CycleError, Parameters, Settings, simulate};
use nailnoise_penetration::{PenetrationLaw, ResistanceLaw};

use crate::common::n80cb;

/// The base design with the same force at every depth \[N\].
fn constant(force: f64) -> Parameters {
    let mut p = n80cb();
    p.wood.penetration_law = ResistanceLaw::Constant;
    p.wood.penetration_force = force;
    p
}

#[test]
fn a_constant_force_acts_from_the_surface_to_the_full_depth() {
    let mut p = constant(1165.0);
    p.nail.overdrive_limit = 0.01;
    let r = simulate(&p, &Settings::default()).unwrap();
    assert!(r.is_certified(), "{:?}", r.figures.checks);
    let full = (r.figures.summary.full_penetration.unwrap() / r.sample_interval()) as usize;
    let start = (r.figures.events.t6.unwrap() / r.sample_interval()) as usize + 2;
    assert!(
        r.history("nail.force")[start..full]
            .iter()
            .all(|f| (f - 1165.0).abs() < 1e-9)
    );
    assert_eq!(p.penetration_resistance(1e-6), 1165.0);
    assert_eq!(p.penetration_resistance(0.0), 0.0);
}

#[test]
fn a_constant_force_that_is_not_finite_is_refused_by_name() {
    let error = simulate(&constant(f64::NAN), &Settings::default()).unwrap_err();
    assert!(
        matches!(&error, CycleError::Value { name, .. } if name == "wood.penetration_force"),
        "{error}"
    );
}

#[test]
fn the_solid_wood_law_uses_the_speed_and_slenderness_terms() {
    let mut p = n80cb();
    let depth = 0.5 * p.nail.length;
    let root = |p: &Parameters| (p.penetration_resistance(depth) / (p.wood.hardness_modulus * p.nail.length)).sqrt();
    let published = root(&p);
    p.wood.speed_term = -115.0;
    p.wood.slenderness_term = -1.1;
    // Eq. 4.59: both terms are linear in the root.
    let pi3 = p.nail.length * p.wood.density / p.wood.hardness_modulus;
    let expected = published + (122.91 - 115.0) * pi3 + (1.15 - 1.1) * p.nail.diameter / p.nail.length;
    assert!((root(&p) - expected).abs() < 1e-12, "{} {expected}", root(&p));
}

#[test]
fn the_plywood_laws_ignore_the_speed_term() {
    let mut smooth = n80cb();
    smooth.wood.penetration_law = PenetrationLaw::Smooth.into();
    let depth = 0.5 * smooth.nail.length;
    let before = smooth.penetration_resistance(depth);
    smooth.wood.speed_term = -115.0;
    assert_eq!(smooth.penetration_resistance(depth), before);
}
