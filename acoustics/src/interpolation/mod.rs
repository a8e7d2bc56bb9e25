//! Quantities sampled at a few frequencies, as finely as their error asks, and interpolated between them.
//!
//! ```text
//! sample   adds samples to intervals of the frequency axis until each is known to the tolerance
//! Grid     where the samples lie; weights of the samples at any frequency; products with motions
//! ```
//!
//! Radiation matrices, pressures at receivers and fields around a body are all sampled here. They differ in the norm of
//! their misfit alone.

mod adaptive;
pub(crate) mod error;
mod grid;
mod interval;

pub(crate) use adaptive::{Piece, Plan, WIDEST, pieces, sample};
pub use error::SamplingError;
pub(crate) use grid::{Grid, Run, field_misfit};
pub(crate) use interval::Interval;
