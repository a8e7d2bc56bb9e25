//! The design file: reading, refusals, derived values and documentation.
#![allow(clippy::unwrap_used)] // a test may panic, in its helpers too

#[path = "../common/mod.rs"]
mod common;

mod assignment;
mod base_design;
mod corpora;
mod cycle_keys;
mod files;
mod migration;
mod names;
mod report;
mod scaling;
mod schema;
mod set;
