//! One nailing cycle of the design `designs/n80cb.toml`: outcome, events and peak forces.
//!
//! ```text
//! cargo run -p nailnoise-dynamics --example one_cycle
//! ```

#[path = "../tests/common/mod.rs"]
mod common;

use nailnoise_dynamics::{CycleError, Outcome, Settings, simulate};

fn main() -> Result<(), CycleError> {
    let record = simulate(&common::n80cb(), &Settings::default())?;
    println!("outcome: {:?}", record.figures.outcome);

    println!("events:");
    for (index, time) in record.figures.events.to_array().into_iter().enumerate() {
        match time {
            Some(time) => println!("  t{index:<2} {:8.3} ms", 1e3 * time),
            None => println!("  t{index:<2} does not occur"),
        }
    }

    let summary = &record.figures.summary;
    println!("peak forces:");
    for (name, newtons) in [
        ("penetration", summary.peak_penetration_force),
        ("cap", summary.peak_cap_force),
        ("seat", summary.peak_seat_force),
        ("bumper", summary.peak_bumper_force),
        ("stopper", summary.peak_stopper_force),
        ("support", summary.peak_support_force),
        ("nose", summary.peak_nose_force),
    ] {
        println!("  {name:11} {newtons:7.0} N");
    }
    assert_eq!(record.figures.outcome, Outcome::Drives);
    Ok(())
}
