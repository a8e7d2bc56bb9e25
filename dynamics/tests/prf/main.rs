//! Tests of the penetration resistance laws.
#![allow(clippy::unwrap_used)]

#[path = "../common/mod.rs"]
mod common;
mod envelope;
mod extension;
mod fit;
mod law;
mod resistance;
mod table;
