//! The ambient air.

use nailnoise_acoustics::{Air, InputError};

#[test]
fn air_of_20_degrees_has_the_usual_values() {
    let air = Air::default();
    assert!((air.density - 1.204).abs() < 5e-4, "{}", air.density);
    assert!((air.sound_speed - 343.2).abs() < 0.05, "{}", air.sound_speed);
    assert_eq!(Air::at(293.15, 101_325.0).unwrap(), air);
}

#[test]
fn air_follows_the_perfect_gas() {
    let (cold, base) = (Air::at(263.15, 80_000.0).unwrap(), Air::default());
    assert!((cold.sound_speed / base.sound_speed - (263.15f64 / 293.15).sqrt()).abs() < 1e-14);
    assert!((cold.density / base.density - 80_000.0 / 101_325.0 * 293.15 / 263.15).abs() < 1e-14);
    assert!(matches!(Air::at(0.0, 1e5), Err(InputError::NotPositive { .. })));
    assert!(matches!(Air::at(293.0, f64::NAN), Err(InputError::NotPositive { .. })));
}
