//! Tests of networks of blocks, by the closed forms, the kinds of blocks and the built-in tools.
#![allow(clippy::unwrap_used)]

#[path = "../common/assembly.rs"]
mod assembly;
mod closed_forms;
#[path = "../common/mod.rs"]
mod common;
mod conditions;
mod coupled;
mod errors;
mod expansion;
mod laws;
#[path = "../common/mass.rs"]
mod mass;
#[path = "../common/n80cb_assembly.rs"]
mod n80cb_assembly;
mod published;
mod random;
#[path = "../common/random_assembly.rs"]
mod random_assembly;
mod tools;

use nailnoise_dynamics::network::{Assembly, Numerics, Record, simulate};

/// Runs an assembly at a tolerance without samples, and asserts that everything is conserved.
fn run(assembly: &Assembly, tolerance: f64) -> Record {
    let numerics = Numerics {
        relative_tolerance: tolerance,
        sample_interval: None,
        ..Numerics::default()
    };
    let record = simulate(assembly, &numerics).unwrap();
    assert!(record.is_certified(), "{}: {:#?}", assembly.name, record.checks);
    record
}

/// Asserts that a value is near another, as a part of it.
fn close(what: &str, found: f64, expected: f64, part: f64) {
    assert!(
        (found / expected - 1.0).abs() <= part,
        "{what}: {found} instead of {expected}"
    );
}
