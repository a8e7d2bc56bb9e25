//! Assemblies as text: the N80CB, inheritance, errors with places.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/random_assembly.rs"]
mod random_assembly;

mod branches;
mod edge_cases;
mod errors;
mod inheritance;
mod keys;
mod n80cb;
mod places;
mod random;
mod runs;
mod shipped;
mod triggers;
mod unused;
