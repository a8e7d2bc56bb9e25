//! Finite-element modal models of the bodies and their transient response.

pub mod supports;
pub mod transient;
