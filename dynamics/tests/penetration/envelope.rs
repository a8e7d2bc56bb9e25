//! The envelope of the penetration resistance of a design.

use nailnoise_dynamics::Form;
use nailnoise_penetration::{NAILS, PenetrationLaw, REFERENCE_SPEED, Shank, Specimen, WOODS};

use crate::common::n80cb;

#[test]
fn within_the_nail_the_envelope_is_the_scaled_law() {
    let pine = WOODS.iter().find(|wood| wood.name == "pine").unwrap();
    let nail = NAILS.iter().find(|nail| nail.name == "12d").unwrap();
    let s = Specimen {
        length: nail.length,
        diameter: nail.shank_diameter(Shank::Smooth).unwrap(),
        hardness_modulus: pine.hardness_modulus,
        density: pine.density,
    };
    let mut p = n80cb();
    p.wood.resistance_scale = 0.7;
    for law in PenetrationLaw::ALL {
        p.wood.penetration_law = (*law).into();
        for x in [1e-3, 0.2, 0.5, 1.0] {
            let expected = 0.7 * law.force(&s, x * s.length, REFERENCE_SPEED).unwrap();
            let force = p.penetration_resistance(x * s.length);
            assert!((force - expected).abs() < 1e-9, "{law:?} {x}: {force} {expected}");
        }
    }
}

#[test]
fn beyond_the_nail_the_envelope_grows_with_the_hardness_modulus() {
    let p = n80cb();
    let length = p.nail.length;
    let seated = p.penetration_resistance(length);
    let beyond = p.penetration_resistance(length + 1e-3);
    assert!((beyond - seated - 1e-3 * p.wood.hardness_modulus).abs() < 1e-6);
}

#[test]
fn beyond_the_nail_the_published_form_keeps_the_head_alone() {
    let mut p = n80cb();
    p.model.nail = Form::Published;
    let length = p.nail.length;
    let lost = p.penetration_resistance(length + 1e-3);
    assert!((lost - 1e-3 * p.wood.hardness_modulus).abs() < 1e-9);
}

#[test]
fn the_envelope_is_zero_at_and_above_the_surface() {
    let p = n80cb();
    assert_eq!(p.penetration_resistance(0.0), 0.0);
    assert_eq!(p.penetration_resistance(-1e-3), 0.0);
}
