//! Bayesian optimisation of costly functions with constraints, integers, choices and a front.
//!
//! The linear algebra is that of `nalgebra`, the initial points are those of `sobol_burley`; the Kriging models, the
//! acquisition and its search are written here. `egobox-ego` 0.42, the one crate with constraints, integers, choices
//! and a front, brings 118 further crates, among them the unmaintained `bincode` and three more versions of
//! `nalgebra`, and a handler of Ctrl-C; the front is experimental there. `optimizer` 1.0 has no constraints in its
//! Gaussian process, `nsga_rs` and `moors` need thousands of evaluations, and `gprx` 0.2 brings 28 crates for the
//! model alone.
//!
//! [`Optimiser::propose`] is a function of the seed and the observations alone: the same observations yield the same
//! proposals, on any number of threads, and a search that was interrupted goes on.
#![forbid(unsafe_code)]

mod acquisition;
mod front;
mod kriging;
mod optimiser;
mod space;

pub use front::front;
pub use optimiser::{Observation, Optimiser};
pub use space::{Dimension, Point, Space};
