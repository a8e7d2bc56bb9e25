//! Assemblies as text: the N80CB, inheritance, errors with places.

#[path = "../common/mod.rs"]
mod common;

mod errors;
mod inheritance;
mod keys;
mod n80cb;
mod shipped;
