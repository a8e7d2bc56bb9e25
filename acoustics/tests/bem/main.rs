//! Boundary elements, and bodies in a heavy fluid.
#![allow(clippy::unwrap_used)]

mod common;

mod coarse;
mod compressed;
mod fluid_plates;
mod fluid_shell;
mod gaps;
mod laws;
mod means;
mod modal;
mod monopole;
mod sphere;
mod subdivision;
mod symmetry;
