//! Elements, materials, modes and supports.
#![allow(clippy::unwrap_used)]

#[path = "../common/bodies.rs"]
mod bodies;
#[path = "../common/kinds.rs"]
mod kinds;

mod assembly;
mod assurance;
mod attachments;
mod elements;
mod elimination;
mod material;
mod modes;
mod spheres;
mod stress;
mod supports;
mod symmetry;
