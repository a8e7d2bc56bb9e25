//! Boundary elements.
#![allow(clippy::unwrap_used)]

#[path = "../common/boundary_meshes.rs"]
mod boundary_meshes;

mod coarse;
mod compressed;
mod cover;
mod gaps;
mod laws;
mod monopole;
mod sphere;
mod subdivision;
mod symmetry;
