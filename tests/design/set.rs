//! Setting keys of a design by name.

use nailnoise::Design;
use nailnoise::design::{SetError, Value};

fn design() -> Design {
    Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb.toml")).unwrap()
}

#[test]
fn a_set_key_is_the_field_of_that_name() {
    let mut design = design();
    let before = design.digest();
    design
        .set(&[("piston.mass", Value::Number(0.2)), ("exhaust.holes", Value::Count(7))])
        .unwrap();
    assert_eq!((design.piston.mass, design.exhaust.holes), (0.2, 7));
    assert_ne!(design.digest(), before);
    design
        .set(&[
            ("piston.mass", Value::Number(0.131)),
            ("exhaust.holes", Value::Count(5)),
        ])
        .unwrap();
    assert_eq!(design.digest(), before);
}

#[test]
fn every_key_takes_its_own_value_back_and_nothing_else_moves() {
    let mut design = design();
    let before = design.digest();
    for entry in design.entries() {
        design.set(&[(entry.key.as_str(), entry.value)]).unwrap();
    }
    assert_eq!(design.digest(), before);
}

#[test]
fn what_cannot_be_set_is_named_and_changes_nothing() {
    let mut design = design();
    let before = design.digest();
    let set = |design: &mut Design, key, value| {
        design
            .set(&[("tool.mass", Value::Number(5.0)), (key, value)])
            .unwrap_err()
    };
    let nearest = Some("piston.mass".to_owned());
    assert_eq!(
        set(&mut design, "piston.mas", Value::Number(1.0)),
        SetError::UnknownKey {
            key: "piston.mas".to_owned(),
            nearest
        }
    );
    let outside = |error| matches!(error, SetError::OutsideLimits { .. });
    assert!(outside(set(&mut design, "piston.mass", Value::Number(-1.0))));
    assert!(outside(set(&mut design, "piston.mass", Value::Number(f64::NAN))));
    assert!(outside(set(&mut design, "exhaust.holes", Value::Count(0))));
    let kind = |error| matches!(error, SetError::WrongKind { .. });
    assert!(kind(set(&mut design, "exhaust.holes", Value::Number(3.0))));
    assert!(kind(set(&mut design, "model.gas", Value::Choice("ideal"))));
    assert_eq!(design.digest(), before);
}
