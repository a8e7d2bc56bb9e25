//! The quietest designs under constraints.
//!
//! The crate `nailnoise-optimisation` proposes points of a space; this module adds the keys of a design as its
//! dimensions, the constraints on its shot and levels, and the trials. A shot that violates a constraint costs only a
//! cycle: levels are computed only for designs whose shot meets the constraints.

mod constraint;
mod error;
mod search;
mod shot;
mod trial;
mod variable;
mod written;

pub(crate) use constraint::is_level;
pub use constraint::{Constraint, Objective};
pub use error::OptimisationError;
pub use search::{Optimisation, Request, optimise};
pub use shot::Shot;
pub use trial::Trial;
pub use variable::{Domain, Variable, Varied};
pub use written::design_over;
