//! Tests of the transient response of modal bodies.
#![allow(clippy::unwrap_used)] // a test may panic, in its helpers too

mod beams;
#[path = "../common/block_on_table.rs"]
mod block_on_table;
mod bodies;
mod contact;
mod driven;
mod duhamel;
mod full_size;
mod statics;
mod supports;

use nailnoise_fem::vibration::ModalResponse;

/// Asserts that a run passes its own checks.
fn passes_its_checks(response: &ModalResponse) {
    assert!(response.checks.iter().all(|check| check.ok), "{:?}", response.checks);
}
