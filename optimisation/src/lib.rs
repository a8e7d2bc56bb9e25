//! Bayesian optimisation of costly functions with constraints, integers, choices and a front.
//!
//! The linear algebra is that of `nalgebra`, the initial points are those of `sobol_burley`; the Kriging models, the
//! acquisition function and its search are implemented here. `egobox-ego` 0.42 is the only crate with constraints,
//! integers, choices and a front. It adds 118 further crates, including the unmaintained `bincode` and three more
//! versions of `nalgebra`, and a Ctrl-C handler. Its front is experimental. `optimizer` 1.0 has no constraints in its
//! Gaussian process, `nsga_rs` and `moors` need thousands of evaluations, and `gprx` 0.2 adds 28 crates only for the
//! model.
//!
//! [`Optimiser::propose`] depends only on the seed and the observations: the same observations yield the same proposals
//! on any number of threads, and an interrupted search can be resumed.
#![forbid(unsafe_code)]

mod acquisition;
mod front;
mod kriging;
mod optimiser;
mod space;

pub use front::front;
pub use optimiser::{Observation, Optimiser};
pub use space::{Dimension, Point, Space};
