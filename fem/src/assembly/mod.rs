//! From a mesh to stiffness, mass and load vectors: element matrices, assembly into K and M, mirror planes.

mod element;
mod layout;
mod load_vector;
mod mirror;
mod stress;
mod system;

pub use load_vector::{LoadVector, Rectangle};
pub(crate) use mirror::Mirror;
pub use mirror::mirror_planes;
pub use stress::stress_at;
pub use system::{Equations, System, assemble, assemble_in_order, assemble_with, elimination_order};
