//! Quantities sampled at a few frequencies, adaptively to a tolerance, and interpolated between them.
//!
//! ```text
//! sample   adds samples to intervals of the frequency axis until each meets the tolerance
//! Grid     frequencies of the samples; weights of the samples at any frequency; products with motions
//! ```
//!
//! Used for radiation matrices, receiver pressures and sound fields. These differ only in the norm of their misfit.

mod adaptive;
pub(crate) mod error;
mod grid;
mod interval;

pub(crate) use adaptive::{Piece, Plan, WIDEST, each, pieces, sample};
pub use error::SamplingError;
pub(crate) use grid::{Grid, Run, field_misfit, or_infinite};
pub(crate) use interval::Interval;
