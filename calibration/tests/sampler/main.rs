//! The sampler against closed forms, quadrature and its own laws.
#![allow(clippy::unwrap_used, missing_docs)]

mod closed_forms;
mod common;
mod conflicts;
mod laws;
mod ranks;
