//! Nodes that depend on others: constraints, attachments, and the reduction that eliminates them.

mod attachments;
mod constraints;
mod dependent_nodes;

pub use attachments::{Attachments, Coupling, GroundSpring, LumpedMass, Place, Tie};
pub use constraints::Constraints;
pub(crate) use dependent_nodes::{Reduction, Term};
