//! The penetration resistance in the nailing cycle.
#![allow(clippy::unwrap_used)]

#[path = "../common/mod.rs"]
mod common;
mod envelope;
mod extension;
mod resistance;
mod table;
