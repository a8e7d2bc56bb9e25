//! Speed of sound at 20 degC compared with ISO 9613-1:1993, 343.2 m/s: `cargo run --release --example
//! 06_speed_of_sound`.

use nailnoise_acoustics::{Air, InputError};

fn main() -> Result<(), InputError> {
    let speed = Air::at(293.15, 101_325.0)?.sound_speed;
    println!("{speed:.2} m/s, ISO 9613-1 has 343.2 m/s");
    assert!((speed - 343.2).abs() < 0.05);
    Ok(())
}
