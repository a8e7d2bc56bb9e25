//! The published laws, and laws fitted to driving tests.
#![allow(clippy::unwrap_used)]

mod fit;
mod law;
mod rate_fit;
